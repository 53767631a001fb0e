"""A connection that sends too much is closed, and other pages go on; a stop by HTTP."""

from __future__ import annotations

import contextlib
import functools
import http.client
import importlib.util
import json
import socket
import struct
from itertools import pairwise
from typing import Any

import anyio
import anyio.to_thread
import pytest
from client.bench import Bench
from websockets.asyncio.client import connect
from websockets.asyncio.server import serve
from websockets.exceptions import ConnectionClosed
from websockets.typing import Subprotocol

from aioduco.integrations.panel.page_connection import Allowance
from aioduco.testing import Delay, FaultProxy, eventually_async

if importlib.util.find_spec("viser") is None:  # which takes long to load
    pytest.skip("needs pip install 'aioduco[panel]'", allow_module_level=True)

import viser

from aioduco.integrations.panel import Panel, page_server
from integrations.panel.test_panel import PATIENT, Page, page_of


def test_an_allowance_is_a_rate_and_an_amount_at_once() -> None:
    allowance = Allowance(10.0, 20.0)
    assert allowance.takes(20.0, now=5.0)
    assert not allowance.takes(1.0, now=5.05)
    assert allowance.takes(1.0, now=5.125)
    assert allowance.takes(20.0, now=60.0)
    assert not allowance.takes(1.0, now=60.0), "no more than the amount is kept"
    assert not allowance.takes(1.0, now=59.0), "a clock that steps back gives nothing"


FLOODS = {
    "wrong tokens": json.dumps({"ask": "take", "token": "guess"}),
    "stops": json.dumps({"ask": "stop"}),
    "keep-alives": json.dumps({"ask": "beat", "seen": 1, "down": True}),
    "rubbish": "[" * 60,
    "long rubbish": "[" * 4000,
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", FLOODS)
async def test_a_flood_is_cut_off_and_another_page_stops_the_arm(bench: Bench, kind: str) -> None:
    async with Panel(bench.host, bench.port, **PATIENT) as panel, page_of(panel) as page:
        url = panel.url.replace("http", "ws") + "socket"
        message = masked(FLOODS[kind].encode())
        async with connect(url) as flood:
            # in one piece, far more than any computer takes the time to allow
            flood.transport.write(message * (4_000_000 // len(message)))
            await read_all(flood)  # it is cut off
        before = len(bench.received("stop"))
        assert before < 100, "stops that wait are one"
        await page.ask("stop")
        await eventually_async(lambda: len(bench.received("stop")) > before)
        assert len(lines(page, "wrong token")) < 100, "nobody else is told of each"


async def read_all(connection: Any) -> None:
    with contextlib.suppress(ConnectionClosed):
        async for _ in connection:
            pass


def lines(page: Page, text: str) -> list[str]:
    return [line["text"] for line in page.all("event") if text in line["text"]]


@pytest.mark.slow
async def test_the_messages_of_two_pages_take_turns(bench: Bench) -> None:
    """What one page has sent at once does not go before a stop of another."""
    async with Panel(bench.host, bench.port, **PATIENT) as panel:
        taken: list[str] = []
        take = panel._server._take

        def note(page: int, message: str | bytes) -> None:
            taken.append("stop" if '"stop"' in str(message) else "other")
            take(page, message)

        panel._server._take = note
        async with page_of(panel) as page, page_of(panel) as other:
            # in one piece, which the server reads at once
            beat = json.dumps({"ask": "beat", "seen": 1, "down": False}).encode()
            other.connection.transport.write(masked(beat) * 500)
            page.connection.transport.write(masked(b'{"ask": "stop"}') * 5)
            await eventually_async(lambda: len(taken) == 505)
        places = [number for number, each in enumerate(taken) if each == "stop"]
        assert places[-1] < 400
        assert all(b - a <= 3 for a, b in pairwise(places)), "one of the other page between"


def masked(text: bytes) -> bytes:
    """A frame of a client, with a mask of zeros."""
    long = len(text) > 125
    length = struct.pack("!BH", 254, len(text)) if long else bytes([0x80 | len(text)])
    return b"\x81" + length + bytes(4) + text


@pytest.mark.slow
async def test_connections_that_ask_nothing_make_room(bench: Bench) -> None:
    async with Panel(bench.host, bench.port, **PATIENT) as panel, contextlib.AsyncExitStack() as st:
        silent = []
        for _ in range(150):
            one = st.enter_context(
                await anyio.to_thread.run_sync(
                    socket.create_connection, ("127.0.0.1", panel._server.port)
                )
            )
            one.sendall(b"GET / HTTP/1.1\r\nX: ")
            silent.append(one)
        async with page_of(panel) as page:
            assert page.all("hello")
        silent[0].settimeout(60.0)
        with contextlib.suppress(ConnectionResetError):
            assert await anyio.to_thread.run_sync(silent[0].recv, 1) == b""


def ask(panel: Panel, method: str, path: str, **headers: str) -> tuple[int, dict[str, Any]]:
    connection = http.client.HTTPConnection("127.0.0.1", panel._server.port, timeout=60.0)
    connection.request(method, path, headers={name.title(): v for name, v in headers.items()})
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer.status, json.loads(body) if body.startswith(b"{") else {}


async def test_a_stop_needs_no_page_and_no_token(bench: Bench) -> None:
    async with Panel(bench.host, bench.port, **PATIENT) as panel:
        status, said = await anyio.to_thread.run_sync(ask, panel, "POST", "/stop")
        assert (status, said["stopped"]) == (200, True)
        assert bench.commands == ["stop"]


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("method", "path", "headers", "status"),
    [
        ("POST", "/stop", {"origin": "http://evil.example"}, 403),
        ("POST", "/stop", {"origin": "null"}, 403),
        ("POST", "/stop", {"host": "evil.example"}, 403),
        ("POST", "/", {}, 405),
        ("DELETE", "/stop", {}, 405),
        ("GET", "/stop", {}, 404),
    ],
)
async def test_no_other_request_stops(
    bench: Bench, method: str, path: str, headers: dict[str, str], status: int
) -> None:
    async with Panel(bench.host, bench.port, **PATIENT) as panel:
        told, _ = await anyio.to_thread.run_sync(lambda: ask(panel, method, path, **headers))
        assert told == status
        assert bench.received("stop") == ()


@pytest.mark.slow
async def test_a_stop_while_the_panel_ends_is_confirmed(bench: Bench) -> None:
    """It was answered that the panel has ended, although the arm was stopped."""
    answers: list[tuple[int, dict[str, Any]]] = []
    with FaultProxy(bench.host, bench.port) as proxy:
        proxy.on("stop", Delay(reply=0.2), times=None)
        async with (
            anyio.create_task_group() as tasks,
            Panel(proxy.host, proxy.port, **PATIENT) as panel,
        ):

            async def stop() -> None:
                answers.append(await anyio.to_thread.run_sync(ask, panel, "POST", "/stop"))

            tasks.start_soon(stop)
            await eventually_async(lambda: proxy.calls("stop"))
    assert [(status, said["stopped"]) for status, said in answers] == [(200, True)]


@pytest.mark.slow
async def test_a_stop_that_fails_says_so(bench: Bench) -> None:
    async with Panel(bench.host, bench.port, **PATIENT) as panel, page_of(panel) as page:
        bench.answer("stop", -1)
        status, said = await anyio.to_thread.run_sync(ask, panel, "POST", "/stop")
        assert status == 503
        assert "stop failed" in said["said"]
        await eventually_async(lambda: lines(page, "stop failed"))


@pytest.mark.slow
async def test_the_picture_is_behind_the_pages_port_and_viser_has_none(bench: Bench) -> None:
    psutil = pytest.importorskip("psutil")

    def listening() -> set[int]:
        return {
            each.laddr.port
            for each in psutil.Process().net_connections("tcp")
            if each.status == psutil.CONN_LISTEN
        }

    before = listening()
    async with Panel(bench.host, bench.port, **PATIENT) as panel:
        assert listening() - before == {panel._server.port}
        url = panel.url.replace("http", "ws") + "picture"
        spoken = [Subprotocol(f"viser-v{viser.__version__}")]
        async with connect(url, subprotocols=spoken, max_size=None) as picture:
            assert len(await picture.recv()) > 100
            await picture.send(b"\x81" * 4000)  # nothing that a page sends reaches viser
            assert len(await picture.recv()) > 100


async def test_a_panel_ends_without_the_requests_that_browsers_keep_back(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They open connections that they do not use; the end waited ten seconds for each."""
    patient = functools.partial(serve, open_timeout=None)
    monkeypatch.setattr(page_server, "serve", patient)
    async with Panel(bench.host, bench.port, **PATIENT) as panel:
        port = panel._server.port
        unused = await anyio.connect_tcp("127.0.0.1", port)
        async with await anyio.connect_tcp("127.0.0.1", port) as asked:  # the other one is taken
            await asked.send(b"HEAD / HTTP/1.1\r\n\r\n")
            await asked.receive()
    await unused.aclose()
