"""The panel's server without a browser: pages, connections, and who commands."""

from __future__ import annotations

import importlib.util
import json
import logging
import socket
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from typing import Any

import anyio
import pytest
from client.bench import Bench
from ports import free_port
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import InvalidStatus

import aioduco
from aioduco.envelope import Envelope, JointMargin
from aioduco.errors import ConnectError, ParameterError, RobotStateError
from aioduco.integrations.panel import Panel
from aioduco.sim import Simulator
from aioduco.testing import Delay, FaultProxy, eventually_async

if importlib.util.find_spec("viser") is None:  # which takes long to load
    pytest.skip("needs pip install 'aioduco[panel]'", allow_module_level=True)

PATIENT: dict[str, Any] = {
    "listen": 0, "hold_limit": 60.0, "page_limit": 60.0, "model": "gcr5_910",
}  # fmt: skip


class Page:
    """What a page is told, and what it says."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection
        self.told: list[dict[str, Any]] = []

    async def listen(self) -> None:
        async for message in self.connection:
            self.told.append(json.loads(message))

    def all(self, kind: str) -> list[dict[str, Any]]:
        return [message for message in self.told if message["tell"] == kind]

    def texts(self) -> list[str]:
        return [event["text"] for event in self.all("event")]

    @property
    def number(self) -> int:
        return int(self.all("hello")[0]["page"])

    @property
    def state(self) -> dict[str, Any]:
        return self.all("state")[-1]

    async def ask(self, ask: str, **values: Any) -> None:
        await self.connection.send(json.dumps({"ask": ask, **values}))

    async def press(self) -> None:
        motion = {"kind": "joints", "to": [0.5, 0.0, 1.5, 0.0, -1.5, 0.0], "percent": 10}
        await self.ask("press", seen=self.state["n"], motion=motion)

    async def command(self, token: str) -> None:
        await self.ask("take", token=token)
        await eventually_async(
            lambda: self.state["holder"] == self.number and self.state["phase"] == "held"
        )


def refused_more(page: Page, than: int) -> bool:
    return len(page.all("refused")) > than


@asynccontextmanager
async def page_of(panel: Panel, **options: Any) -> AsyncIterator[Page]:
    url = panel.url.replace("http", "ws") + "socket"
    async with connect(url, **options) as connection, anyio.create_task_group() as group:
        page = Page(connection)
        group.start_soon(page.listen)
        await eventually_async(lambda: page.all("hello") and page.all("state"))
        yield page
        group.cancel_scope.cancel()


@pytest.mark.slow
@pytest.mark.parametrize("verb", ["bring_up", "recover"])
async def test_after_a_collision_a_page_is_told_to_tare_again(bench: Bench, verb: str) -> None:
    async with Panel(bench.host, bench.port, **PATIENT) as panel, page_of(panel) as page:
        await page.command(panel.token)
        bench.collision = True
        bench.states[:3] = [6, 3, 7]
        await page.ask("do", verb=verb, seen=page.state["n"])
        await eventually_async(
            lambda: any("can move" in each["text"] for each in page.all("event"))
        )
        warned = [each["text"] for each in page.all("event") if each["severity"] == "warning"]
        assert any("After the collision" in text and "tare again" in text for text in warned)


async def test_one_page_commands_and_the_others_watch(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    """A wrong token moves nothing and is logged without it; stopping is free."""
    async with Panel(bench.host, bench.port, **PATIENT) as panel:
        assert panel.token not in repr(panel)
        async with page_of(panel) as one, page_of(panel) as two:
            assert bench.received("rpc_heartbeat") == (), "who moves the arm keeps its supervision"
            with caplog.at_level(logging.DEBUG):
                for wrong in ("not the token", panel.token + "!", panel.token[:-1]):
                    before = len(two.all("refused"))
                    await two.ask("take", token=wrong)
                    await eventually_async(partial(refused_more, two, before))
                for rubbish in ("{", b"\xff\x00", "[" * 2000, json.dumps({"ask": panel.token})):
                    before = len(two.all("refused"))
                    await two.connection.send(rubbish)
                    await eventually_async(partial(refused_more, two, before))
                await one.command(panel.token)
                await eventually_async(lambda: "wrong token" in caplog.text)
            assert "not the token" not in caplog.text
            assert panel.token[:-1] not in caplog.text
            assert bench.received("rpc_heartbeat"), "who commands is supervised"
            for ask, values in (
                ("take", {"token": panel.token}),
                ("do", {"verb": "bring_up", "seen": 1}),
                ("measure", {"step": "touch", "sensor": "torque"}),
                ("write", {"what": "held", "name": ""}),
                ("output", {"num": 1, "on": True, "tool": False, "seen": 1}),
            ):
                seen = len(two.all("refused"))
                await two.ask(ask, **values)
                await eventually_async(partial(refused_more, two, seen))
            await two.press()
            await two.ask("stop")
            await eventually_async(lambda: bench.received("stop"))
            await eventually_async(
                lambda: any("the arm stands" in line["text"] for line in two.all("event"))
            )
            assert bench.received("movej2") == ()
            assert bench.received("set_standard_digital_out") == ()
        await eventually_async(lambda: "free" in repr(panel))


@pytest.mark.slow
async def test_the_plots_go_on_when_the_clock_is_set_back(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with Panel(bench.host, bench.port, **PATIENT) as panel:
        await eventually_async(lambda: len(panel._history) > 1)
        before, wall = len(panel._history), time.time
        monkeypatch.setattr(time, "time", lambda: wall() - 3600.0)
        await eventually_async(lambda: len(panel._history) > before + 2)
        times = [point[0] for point in panel._history]
        assert times == sorted(times)


@pytest.mark.slow
async def test_what_comes_late_as_after_an_outage_starts_nothing(bench: Bench) -> None:
    async with Panel(bench.host, bench.port, **PATIENT) as panel, page_of(panel) as page:
        await page.command(panel.token)
        for verb in ("bring_up", "recover", "resume"):
            await page.ask("do", verb=verb, seen=0)
        await page.ask("output", num=1, on=True, tool=False, seen=0)
        await page.ask("do", verb="pause", seen=0)  # which starts nothing
        await eventually_async(lambda: len(page.all("refused")) == 4)
        await eventually_async(lambda: bench.received("pause"))
        assert {each["reason"] for each in page.all("refused")} == {
            "what this page shows is too old to move by"
        }
        for call in ("resume", "power_on", "enable", "set_standard_digital_out"):
            assert bench.received(call) == ()
        await page.ask("output", num=1, on=True, tool=False, seen=page.state["n"])
        await eventually_async(lambda: bench.received("set_standard_digital_out"))


async def test_the_lease_ends_with_its_page_and_the_arm_is_stopped(bench: Bench) -> None:
    bench.motion_time = 60.0
    async with Panel(bench.host, bench.port, **PATIENT) as panel:
        async with page_of(panel) as watcher:
            async with page_of(panel) as page:
                await page.command(panel.token)
                await page.press()
                await eventually_async(lambda: bench.received("movej2"))
                assert bench.received("stop") == ()
            await eventually_async(lambda: bench.received("stop"))
            await eventually_async(lambda: watcher.state["phase"] == "free")
        async with page_of(panel) as late:
            assert any(
                "its page is gone" in line["text"] for line in late.all("hello")[0]["events"]
            )


@pytest.mark.slow
async def test_a_stop_is_confirmed_when_a_motion_that_was_on_its_way_is_ruled_out(
    bench: Bench,
) -> None:
    bench.motion_time = 60.0
    with FaultProxy(bench.host, bench.port) as proxy:
        async with Panel(proxy.host, proxy.port, **PATIENT) as panel, page_of(panel) as page:
            await page.command(panel.token)
            proxy.on("movej2", Delay(request=0.3, reply=0.3))
            await page.press()
            await eventually_async(lambda: proxy.calls("movej2"))
            assert not bench.received("movej2")
            await page.ask("stop")
            await eventually_async(lambda: any("stands" in each for each in page.texts()))
            assert bench.received("movej2")
            assert not bench.moving()


@pytest.mark.cases(1)
@pytest.mark.parametrize("path", ["socket", "picture", ""])
@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Host": "evil.example"}, 403),
        ({"Host": "evil.example", "Origin": "http://evil.example"}, 403),
    ],
)
async def test_a_page_of_another_site_gets_no_connection(
    bench: Bench, headers: dict[str, str], status: int, path: str
) -> None:
    async with Panel(bench.host, bench.port, **PATIENT) as panel:
        url = panel.url.replace("http", "ws") + path
        options: dict[str, Any] = {"additional_headers": headers}
        with pytest.raises(InvalidStatus) as refused:
            async with connect(url, **options):
                pass
        assert refused.value.response.status_code == status
        origin: Any = panel.url.rstrip("/")
        async with page_of(panel, origin=origin) as page:
            assert page.all("state")


async def test_pages_come_when_the_panel_can_serve_them(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A page of the panel before, which tries every second, never got a picture."""
    port, make = free_port(), Panel._make_scene

    def make_scene(panel: Panel) -> Any:
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.1", port)).close()
        return make(panel)

    monkeypatch.setattr(Panel, "_make_scene", make_scene)
    async with Panel(bench.host, bench.port, **PATIENT | {"listen": port}) as panel, page_of(panel):
        pass


def test_a_link_holds_a_token_of_any_characters() -> None:
    panel = Panel("127.0.0.1", token="100% a & b#c/é")
    assert panel.link.endswith("#token=100%25%20a%20%26%20b%23c%2F%C3%A9")


async def test_a_panel_that_watches_lets_nobody_command(bench: Bench) -> None:
    async with Panel(bench.host, bench.port, token="", **PATIENT) as panel, page_of(panel) as page:
        assert panel.link == panel.url
        await page.ask("take", token="")
        await eventually_async(lambda: page.all("refused"))
        assert page.all("refused")[0]["reason"] == "this panel only watches"
        await page.connection.send("no JSON")
        await eventually_async(lambda: len(page.all("refused")) == 2)
        await page.ask("stop")
        await eventually_async(lambda: bench.received("stop"))


@pytest.mark.slow
async def test_a_page_that_takes_nothing_is_cut_off_and_holds_up_nobody(bench: Bench) -> None:
    async with Panel(bench.host, bench.port, rate=50.0, **PATIENT) as panel, page_of(panel) as page:
        url = panel.url.replace("http", "ws") + "socket"
        async with connect(url, max_queue=1):  # and reads no more
            await eventually_async(lambda: panel._server.pages == 2)
            for _ in range(600):  # megabytes, more than the system keeps for it
                panel._server.broadcast({"tell": "event", "text": "x" * 50_000})
                await anyio.lowlevel.checkpoint()
            await eventually_async(lambda: panel._server.pages == 1)
        seen = page.state["n"]
        await eventually_async(lambda: page.state["n"] > seen + 5)


@pytest.mark.slow
@pytest.mark.parametrize("how", ["let go", "silent"])
async def test_a_jog_lasts_as_long_as_its_button_is_held(how: str) -> None:
    with Simulator(joints=(0.0, 0.0, 1.5, 0.0, -1.5, 0.0)) as sim:
        async with aioduco.connect(sim.host, sim.port, heartbeat=None) as robot:
            await robot.bring_up()
        options: dict[str, Any] = PATIENT | ({"hold_limit": 5.0} if how == "silent" else {})
        async with (
            Panel(sim.host, sim.port, clock=sim.clock, **options) as panel,
            page_of(panel) as page,
        ):
            await page.command(panel.token)
            motion = {"kind": "jog", "axis": 1, "direction": 1, "percent": 10}
            await page.ask("press", seen=page.state["n"], motion=motion)
            await eventually_async(lambda: sim.joints[0] > 0.01, timeout=60)
            if how == "let go":
                await page.ask("let_go")
            await eventually_async(lambda: page.state["motion"] is None, timeout=60)
            await eventually_async(lambda: not sim.moving, timeout=60)
            lines = [line["text"] for line in page.all("event")]
            assert any("silent or late" in line for line in lines) is (how == "silent"), lines
            assert page.state["holder"] == page.number, "the lease is kept"


@pytest.mark.slow
async def test_what_is_measured_is_told_to_every_page(bench: Bench) -> None:
    bench.answer("get_flange_pose", [0.5, 0.1, 0.6, 3.1, 0.0, -1.5])
    async with Panel(bench.host, bench.port, **PATIENT) as panel, page_of(panel) as watcher:
        async with page_of(panel) as page:
            assert page.all("hello")[0]["measured"]["tool"].startswith("0 touches")
            await page.command(panel.token)
            await page.ask("measure", step="touch", sensor="torque")
            await eventually_async(
                lambda: [line["tool"][:9] for line in watcher.all("measured")] == ["1 touches"]
            )
            await page.ask("write", what="tip", name="pen")
            await eventually_async(
                lambda: any("touch the point" in line["text"] for line in watcher.all("event"))
            )
        assert bench.received("set_tool_data") == ()


async def test_the_arm_of_the_envelope_is_shown_where_the_controller_tells_none(
    bench: Bench,
) -> None:
    """It was shown as a GCR5-910, with the limits of its joints."""
    limits = Envelope("gcr3_618", JointMargin(0.1))
    async with (
        Panel(bench.host, bench.port, **PATIENT | {"model": None}, envelope=limits) as panel,
        page_of(panel) as page,
    ):
        assert page.all("hello")[0]["model"] == "gcr3_618"


async def test_wrong_arguments_and_no_controller() -> None:
    for wrong in (
        {"rate": 0.0}, {"hold_limit": 0.0}, {"page_limit": float("nan")}, {"model": "gcr99"},
        {"directions": 1}, {"rate": 2.0, "hold_limit": 0.4},
    ):  # fmt: skip
        options: dict[str, Any] = wrong
        with pytest.raises(ParameterError):
            Panel("127.0.0.1", 1, **options)
    assert Panel("127.0.0.1", 1, rate=2.0, token="").rate == 2.0, "it only watches"
    with pytest.raises(ConnectError):
        async with (panel := Panel("127.0.0.1", 1, **PATIENT)):
            pass
    with pytest.raises(RobotStateError, match="a panel is opened once"):
        await panel.__aenter__()
