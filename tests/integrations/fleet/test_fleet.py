"""Two gateways in processes of their own, simulated arms, and a third process that stops them."""

from __future__ import annotations

import asyncio
import dataclasses
import errno
import json
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Self
from unittest.mock import AsyncMock, Mock

import anyio
import pytest
import zenoh
from ports import free_port
from typer.testing import CliRunner

import aioduco
from aioduco._process.reporting import reporter
from aioduco.cli.app import app
from aioduco.cli.exit_codes import STOP_UNCONFIRMED
from aioduco.integrations.fleet import (
    ArmSettings,
    FleetClient,
    FleetGateway,
    FleetSettings,
    FleetStop,
    FleetView,
)
from aioduco.integrations.fleet.link import FleetLink
from aioduco.integrations.fleet.reports import ArmStopped, StopReport
from aioduco.sim import Simulator
from aioduco.testing import eventually_async

#: s after which the controller stops the arm of a gateway that died: long, for a busy machine
HEARTBEAT = 8.0
ROUTER = """
import sys, zenoh
config = zenoh.Config()
for name, value in (
    ("mode", '"router"'), ("listen/endpoints", f'["{sys.argv[1]}"]'),
    ("scouting/multicast/enabled", "false"),
):
    config.insert_json5(name, value)
session = zenoh.open(config)
print("ready", flush=True)
sys.stdin.read()
"""


#: beginning of the keys of gateways
KEY = "0123456789abcdef" * 2


def free_endpoint() -> str:
    return f"tcp/127.0.0.1:{free_port()}"


class Fleet:
    """Files and processes of a fleet.

    Args:
        folder: for the files.
        arms: by gateway, its arm's simulator.
        router: through which alone they are connected; None if each connects to the first one.
    """

    def __init__(self, folder: Path, arms: dict[str, Simulator], router: str | None = None) -> None:
        self.files: dict[str, Path] = {}
        keys = folder / "keys.toml"
        keys.write_text(
            "".join(f'{name} = "{KEY}{number:02}"\n' for number, name in enumerate(arms))
        )
        self.processes: dict[str, subprocess.Popen[str]] = {}
        first: str | None = None
        for name, sim in arms.items():
            listen = free_endpoint()
            connect = router or first
            first = first or listen
            # with a router there is no other way
            own = json.dumps([] if router else [listen])
            others = json.dumps([connect] if connect else [])
            self.files[name] = folder / f"{name}.toml"
            self.files[name].write_text(
                "[fleet]\n"
                f'name = "plant"\ngateway = "{name}"\nexpect = {json.dumps([*arms])}\n'
                f"listen = {own}\nconnect = {others}\nkeys = {json.dumps(str(keys))}\n"
                f'[[arm]]\nname = "arm-of-{name}"\nhost = "{sim.host}"\nport = {sim.port}\n'
                f"heartbeat = {HEARTBEAT}\n"
            )

    def settings(self, name: str) -> FleetSettings:
        return FleetSettings.read(self.files[name])

    def command(self, *words: str) -> list[str]:
        return [sys.executable, "-m", "aioduco.cli", "fleet", *words]

    def start(self, name: str) -> None:
        if name in self.processes:
            self._end(self.processes[name])
        self.processes[name] = subprocess.Popen(
            self.command("serve", str(self.files[name])),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        output = self.processes[name].stdout
        assert output is not None
        assert output.readline().startswith(f"gateway {name} of plant on ")

    async def run(self, *words: str) -> tuple[int, Any]:
        done = await anyio.run_process(self.command(*words), check=False)
        return done.returncode, json.loads(done.stdout)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for process in self.processes.values():
            self._end(process)

    def _end(self, process: subprocess.Popen[str]) -> None:
        process.kill()
        process.communicate()


@contextmanager
def simulators(count: int) -> Iterator[list[Simulator]]:
    with ExitStack() as stack:
        yield [stack.enter_context(Simulator(speed=1.0)) for _ in range(count)]


async def set_moving(sim: Simulator) -> aioduco.Robot:
    """Have an arm move for a minute by a program that keeps no heartbeat."""
    robot = aioduco.connect(sim.host, sim.port, heartbeat=None)
    await robot.open()
    await robot.bring_up(timeout=60.0)
    await robot.motion.movej2([1.0] * 6, 0.015, 1.0).start()
    await eventually_async(lambda: sim.moving, 30.0)
    return robot


def moves(sim: Simulator) -> bool:
    return sim.moving


def up(view: FleetView) -> list[str]:
    return [arm.name for report in view.gateways for arm in report.arms if arm.link == "up"]


@pytest.mark.slow
@pytest.mark.timeout(600)
async def test_one_stop_and_one_view_and_a_gateway_that_dies_stops_its_own_arms(
    tmp_path: Path,
) -> None:
    with simulators(2) as (one, two), Fleet(tmp_path, {"one": one, "two": two}) as fleet:
        for name in ("one", "two"):
            fleet.start(name)
        robots = [await set_moving(sim) for sim in (one, two)]
        async with FleetClient(fleet.settings("two")) as client:
            await eventually_async(lambda: len(up(client.view)) == 2, 60.0)
            view = await client.status(60.0)
            assert not view.missing
            assert [report.gateway for report in view.gateways] == ["one", "two"]
            # the third process: a view, and a stop of one arm of the other gateway
            code, table = await fleet.run(
                "status", str(fleet.files["two"]), "--json", "--timeout", "60"
            )
            assert code == 0
            states = [arm["robot"] for gateway in table["gateways"] for arm in gateway["arms"]]
            assert states == ["ENABLE", "ENABLE"]
            # the gateway dies
            fleet.processes["one"].kill()
            await eventually_async(lambda: not one.moving, 60.0)
            assert moves(two)
            await eventually_async(lambda: client.view.missing == ("one",), 60.0)
            assert up(client.view) == ["arm-of-two"]
            # a stop reaches those that are there, and says that one is missing
            words = ("stop", str(fleet.files["two"]), "--json", "--timeout", "30")
            code, table = await fleet.run(*words)
            assert code == 4
            assert table["missing"] == ["one"]
            assert table["gateways"][0]["arms"] == [{"name": "arm-of-two", "error": ""}]
            assert not moves(two)
            fleet.start("one")
            await eventually_async(lambda: len(up(client.view)) == 2, 60.0)
            done = await client.stop(["arm-of-one", "nobody"], 60.0)
            assert done.unknown == ("nobody",)
            assert (await client.stop(timeout=60.0)).confirmed
        for robot in robots:
            await robot.aclose()


@pytest.mark.slow
@pytest.mark.timeout(600)
async def test_a_lost_router_changes_nothing_about_supervision(tmp_path: Path) -> None:
    endpoint = free_endpoint()

    def route() -> subprocess.Popen[str]:
        process = subprocess.Popen(
            [sys.executable, "-c", ROUTER, endpoint],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        stack.callback(end, process)
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        return process

    def end(process: subprocess.Popen[str]) -> None:
        process.kill()
        process.communicate()

    with simulators(1) as (sim,), ExitStack() as stack:
        router = route()
        fleet = stack.enter_context(Fleet(tmp_path, {"one": sim}, endpoint))
        fleet.start("one")
        robot = await set_moving(sim)
        looking = FleetSettings("plant", listen=(), connect=(endpoint,), expect=("one",))
        looking = dataclasses.replace(looking, keys=str(tmp_path / "keys.toml"))
        async with FleetClient(looking) as client:
            await eventually_async(lambda: bool(up(client.view)), 60.0)
            end(router)
            await eventually_async(lambda: client.view.missing == ("one",), 60.0)
            begin = sim.time
            # longer than the heartbeat, and the arm moves: the gateway keeps it
            await eventually_async(lambda: sim.time > begin + 2 * HEARTBEAT, 60.0)
            assert moves(sim)
            route()
            await eventually_async(lambda: bool(up(client.view)), 60.0)
            assert (await client.stop(timeout=60.0)).confirmed
            assert not moves(sim)
        await robot.aclose()


@pytest.mark.slow
@pytest.mark.usefixtures("hangups")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_gateway_that_is_told_to_end_stops_its_arms_first(
    tmp_path: Path, number: signal.Signals
) -> None:
    with simulators(1) as (sim,), Fleet(tmp_path, {"one": sim}) as fleet:
        fleet.start("one")

        async def move() -> None:
            robot = await set_moving(sim)
            async with FleetClient(fleet.settings("one")) as client:
                await eventually_async(lambda: bool(up(client.view)), 60.0)
            process = fleet.processes["one"]
            process.send_signal(number)
            assert await anyio.to_thread.run_sync(process.wait, 60.0) == 128 + number
            assert not moves(sim)
            await robot.aclose()

        anyio.run(move)


@pytest.mark.slow
@pytest.mark.timeout(600)
async def test_a_gateway_that_was_suspended_supervises_its_arms_again(tmp_path: Path) -> None:
    with simulators(1) as (sim,), Fleet(tmp_path, {"one": sim}) as fleet:
        fleet.start("one")
        robot = await set_moving(sim)
        async with FleetClient(fleet.settings("one")) as client:
            await eventually_async(lambda: bool(up(client.view)), 60.0)
            process = fleet.processes["one"]
            process.send_signal(signal.SIGSTOP)
            await eventually_async(lambda: not sim.moving, 60.0)
            await eventually_async(lambda: not up(client.view), 60.0)
            process.send_signal(signal.SIGCONT)
            assert process.stderr is not None
            said = ""
            while said != "the gateway had stood still: it supervises arm-of-one again\n":
                said = await anyio.to_thread.run_sync(process.stderr.readline)
                assert said, "it ended"
            await eventually_async(lambda: bool(up(client.view)), 60.0)
            await robot.motion.movej2([0.0] * 6, 0.015, 1.0).start()
            await eventually_async(lambda: sim.moving, 30.0)
            process.kill()
            await eventually_async(lambda: not sim.moving, 60.0)
        await robot.aclose()


@pytest.fixture
def sessions(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Sessions of Zenoh that are opened in this process."""
    opened: list[Any] = []
    connect = zenoh.open

    def watched(config: Any) -> Any:
        opened.append(connect(config))
        return opened[-1]

    monkeypatch.setattr(zenoh, "open", watched)
    return opened


def refuse(*_: object) -> None:
    raise zenoh.ZError("refused")


@pytest.mark.parametrize("declares", ["answer_stops", "declare_alive"])
async def test_a_gateway_that_cannot_be_declared_leaves_nothing_open(
    declares: str, sessions: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FleetLink, declares, refuse)
    arms = (ArmSettings("left", "127.0.0.1", free_port()),)
    gateway = FleetGateway(FleetSettings("plant", "one", listen=(free_endpoint(),), arms=arms))
    before = asyncio.all_tasks()
    with pytest.raises(zenoh.ZError, match="refused"):
        await gateway.__aenter__()
    assert [session.is_closed() for session in sessions] == [True]
    assert asyncio.all_tasks() == before


@pytest.mark.parametrize("arms", [[], 5, [["left"]]])
async def test_a_stop_of_no_arm_is_refused_and_not_confirmed(arms: Any) -> None:
    client = FleetClient(FleetSettings("plant", listen=(free_endpoint(),)))
    with pytest.raises(aioduco.ParameterError, match=r"arms is .*None for all of the fleet"):
        await client.stop(arms)


@pytest.mark.slow
@pytest.mark.parametrize("declares", ["watch_gateways", "watch_states"])
async def test_a_client_that_cannot_be_declared_leaves_nothing_open(
    declares: str, sessions: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FleetLink, declares, refuse)
    client = FleetClient(FleetSettings("plant", listen=(free_endpoint(),)))
    with pytest.raises(zenoh.ZError, match="refused"):
        await client.__aenter__()
    assert [session.is_closed() for session in sessions] == [True]


@pytest.mark.slow
async def test_a_client_that_is_entered_again_leaves_no_session_open(sessions: list[Any]) -> None:
    client = FleetClient(FleetSettings("plant", listen=(free_endpoint(),)))
    for _ in range(2):
        async with client:
            pass
    assert [session.is_closed() for session in sessions] == [True, True]


def test_an_address_that_is_taken_and_a_wrong_file_are_said(tmp_path: Path) -> None:
    file = tmp_path / "fleet.toml"
    with socket.create_server(("127.0.0.1", 0)) as taken:
        endpoint = f"tcp/127.0.0.1:{taken.getsockname()[1]}"
        for more, code, said in (
            (f'gateway = "one"\nlisten = ["{endpoint}"]\n', 1, endpoint),
            ("rate = 1000\n", 2, "0.1 to 100"),
            ("", 2, "needs a name"),
            ('gateway = "one"\nlisten = ["10.0.0.1:7447"]\n', 2, "10.0.0.1:7447"),
            ('gateway = "one"\nzenoh = "none.json5"\n', 2, "none.json5 cannot be read"),
        ):
            file.write_text(f'[fleet]\nname = "plant"\n{more}')
            done = CliRunner().invoke(app, ["fleet", "serve", str(file)])
            assert (done.exit_code, said in " ".join(done.output.split())) == (code, True)


def test_a_stop_that_is_not_confirmed_says_so_where_its_output_cannot_be_written(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """The exit code tells that arms may move, and the other stream which ones."""
    stands, moves = ArmStopped("left"), ArmStopped("right", "not connected")
    lacking = FleetStop((StopReport("one", (stands, moves)),), ("two",), ())

    async def stop(*_: object, waiting: Callable[[FleetStop], object]) -> FleetStop:
        waiting(lacking)
        return lacking

    monkeypatch.setattr(FleetClient, "__init__", lambda *_: None)
    monkeypatch.setattr(FleetClient, "__aenter__", AsyncMock(return_value=Mock(stop=stop)))
    monkeypatch.setattr(FleetClient, "__aexit__", AsyncMock(return_value=None))
    file = tmp_path / "fleet.toml"
    file.write_text('[fleet]\nname = "plant"\n')
    monkeypatch.setattr(sys, "stdout", Mock(write=Mock(side_effect=OSError(errno.ENOSPC, "full"))))
    for given in ([], ["--json"]):
        with pytest.raises(SystemExit) as ended:
            app(["fleet", "stop", str(file), *given])
        assert ended.value.code == STOP_UNCONFIRMED
        said = capsys.readouterr().err
        assert "output cannot be written" in said
        assert given or ("right" in said and "two" in said)
        assert "answered: one; still waiting for two" in said


@pytest.mark.slow
async def test_an_arm_that_is_not_reached_is_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    """And again after it was reached; a plant may be off for a year."""
    tried = 0
    again = anyio.Event()

    def reach(_: ArmSettings) -> aioduco.Robot:
        nonlocal tried
        tried += 1
        if tried == 3:
            again.set()
        return aioduco.connect("127.0.0.1", taken)

    taken = free_port()  # nobody listens there
    arm = ArmSettings("left", "127.0.0.1", taken)
    settings = FleetSettings("plant", "one", (free_endpoint(),), arms=(arm,))
    async with FleetGateway(settings, reach) as gateway:
        await again.wait()
        await gateway._stop(b"")
    reporter.flush()
    said = [each for each in caplog.messages if "not supervised" in each]
    assert len(said) == 1, said
    (stopped,) = (each for each in caplog.messages if each.startswith("the fleet"))
    assert stopped.startswith("the fleet's stop of left is not confirmed: not connected: ")


def test_a_stop_without_a_router_was_not_sent(tmp_path: Path) -> None:
    file = tmp_path / "fleet.toml"
    file.write_text(f'[fleet]\nname = "plant"\nlisten = []\nconnect = ["{free_endpoint()}"]\n')
    done = CliRunner().invoke(app, ["fleet", "stop", str(file)])
    assert done.exit_code == STOP_UNCONFIRMED
    assert "no stop was sent" in done.output
    assert "emergency stop" in done.output
    assert ".rs:" not in done.output


@pytest.mark.parametrize("own", [False, True])
async def test_a_computer_that_does_not_answer_holds_up_no_session_for_long(
    tmp_path: Path, own: bool
) -> None:
    """Unless a file of Zenoh's own says so."""
    file = tmp_path / "zenoh.json5"
    file.write_text("{transport: {unicast: {open_timeout: 7000}}}")
    link = FleetLink(FleetSettings("plant", zenoh=str(file) if own else ""), listens=False)
    found = link._config(zenoh).get_json("transport/unicast/open_timeout")
    assert int(found) == (7000 if own else 2000)


async def test_the_error_of_a_block_leaves_it_as_it_is() -> None:
    """Not in a group, which `except DucoError` does not catch."""
    settings = FleetSettings("hall", gateway="cell", listen=(free_endpoint(),))
    wrong = aioduco.ParameterError("v", 9, "at most 1")
    with pytest.raises(aioduco.ParameterError) as raised:
        async with FleetGateway(settings), FleetClient(settings):
            raise wrong
    assert raised.value is wrong


async def test_a_gateway_that_tells_its_state_no_more_is_missing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its connections live on while its program hangs: its last state was taken for the present."""
    with Simulator() as sim:
        arms = (ArmSettings("left", sim.host, sim.port),)
        settings = FleetSettings("hall", gateway="cell", listen=(free_endpoint(),), arms=arms)
        async with FleetGateway(settings), FleetClient(settings) as client:

            def age() -> float:
                return max((a.seconds for g in client.view.gateways for a in g.arms), default=0.0)

            await eventually_async(lambda: age() > 0.0)
            assert not (await client.status(60.0)).missing
            monkeypatch.setattr(FleetLink, "publish_state", lambda *_: None)
            await eventually_async(lambda: age() > 1.0)
            view = await client.status(0.1)
            assert (view.gateways, view.missing) == ((), ("cell",))


async def test_a_client_can_be_used_again_but_not_opened_twice() -> None:
    settings = FleetSettings("hall", gateway="cell", listen=(free_endpoint(),))
    async with FleetGateway(settings):
        client = FleetClient(settings)
        for _ in range(2):
            async with client:
                await eventually_async(lambda: len(client.view.gateways) == 1, timeout=60.0)
                with pytest.raises(aioduco.RobotStateError, match="open already"):
                    await client.__aenter__()
