"""The vendor's class: what it sends, what it returns, and what it never does."""

from __future__ import annotations

import inspect
import json
import subprocess
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args, get_origin, get_type_hints

import pytest

from aioduco import compat
from aioduco._wire import idl, rpc
from aioduco.compat import DucoCobot
from aioduco.errors import ConnectionLost, ControllerError, ParameterError
from aioduco.sim import Simulator
from aioduco.testing import RecordingServer

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).parents[1]
MANUAL = json.loads((ROOT / "tests/data/manual-3.8.json").read_text(encoding="utf-8"))["functions"]
JOINTS = [0.1, 0.2, 1.5, 0.0, -1.5, 0.3]

#: by type of a result, one of its values
RESULTS: dict[Any, Any] = {int: 7, bool: True, float: 1.5, str: "word"}


@pytest.fixture
def server() -> Iterator[RecordingServer]:
    with RecordingServer() as running:
        yield running


@pytest.fixture
def robot(server: RecordingServer) -> Iterator[DucoCobot]:
    with DucoCobot(server.host, server.port) as connected:
        yield connected


def sample(kind: Any) -> Any:
    """A value of a type, such as a call or an answer may have."""
    if kind in RESULTS:
        return RESULTS[kind]
    origin, parts = get_origin(kind), get_args(kind)
    if origin is dict:
        return {sample(parts[0]): sample(parts[1])}
    if origin is not None:
        return [sample(parts[0])]
    return kind()


def types_of(name: str) -> dict[str, Any]:
    return get_type_hints(getattr(rpc.Functions, name), dict(vars(rpc)))


def test_every_function_of_the_manual_is_there() -> None:
    names = {function["name"] for function in MANUAL} - {"DucoCobot"}
    assert len(names) > 150
    missing = [name for name in names | {"get_nonblock_taskstate"} if not hasattr(DucoCobot, name)]
    assert missing == []


def test_parameters_are_called_as_in_the_manual() -> None:
    for function in MANUAL:
        if function["wire"] is None:
            continue
        ours = set(inspect.signature(getattr(DucoCobot, function["name"])).parameters)
        theirs = {one["name"] for one in function["parameters"] if one["wire"]}
        assert theirs <= ours, function["name"]


@pytest.mark.parametrize("name", sorted(idl.functions()))
def test_each_function_sends_its_arguments_and_returns_the_answer(
    name: str, server: RecordingServer, robot: DucoCobot
) -> None:
    types = types_of(name)
    returns = types.pop("return")
    answer = None if returns is type(None) else sample(returns)
    server.answer(name, answer)
    args = tuple(sample(kind) for kind in types.values())
    assert getattr(robot, name)(*args) == answer
    assert [(call.method, call.args) for call in server.received()] == [(name, args)]


@pytest.mark.parametrize(
    ("name", "args", "sent"),
    [
        ("movej2", (JOINTS, 1.0, 2.0, 0.0, True), (JOINTS, 1.0, 2.0, 0.0, True, rpc.Op(), False)),
        ("servoj", (JOINTS, 1.0, 2.0, False), (JOINTS, 1.0, 2.0, False, 200.0, 25.0, 10.0, 1.0)),
        ("fc_move", (), (False,)),
        ("trackCartMotion", (0.1, 0.2, True, "t", "w"), (0.1, 0.2, True, "t", "w", 0.005)),
        ("start_record_track", ("a", 0, "t", "w"), ("a", 0, "t", "w", 5.0)),
        ("start_record_track", ("a", 1, "t", "w"), ("a", 1, "t", "w", 0.5)),
        ("start_record_track", ("a", 1, "t", "w", 0.0), ("a", 1, "t", "w", 0.0)),
    ],
)
def test_what_is_left_out_is_filled_in_as_the_vendor_does(
    name: str, args: tuple[Any, ...], sent: tuple[Any, ...], server: RecordingServer, robot: Any
) -> None:
    server.answer(name, 4)
    assert getattr(robot, name)(*args) == 4
    assert server.received(name)[0].args == sent


def test_the_manuals_spelling_sends_the_wires_name(
    server: RecordingServer, robot: DucoCobot
) -> None:
    server.answer("get_noneblock_taskstate", 4)
    assert robot.get_noblock_taskstate(1000) == robot.get_nonblock_taskstate(1001) == 4
    assert [call.args for call in server.received()] == [(1000,), (1001,)]


def test_structs_take_the_vendors_attributes(server: RecordingServer, robot: DucoCobot) -> None:
    op = compat.OP()
    op.time_or_dist_1, op.trig_io_1, op.trig_value_1 = 1, 3, True
    server.answer("movel", 4)
    assert robot.movel(JOINTS, 0.1, 0.2, 0.0, JOINTS, "default", "default", True, op) == 4
    assert server.received("movel")[0].args[8] == op


def test_a_lost_connection_gives_minus_one_or_raises(server: RecordingServer) -> None:
    robot = DucoCobot(server.host, server.port)
    assert (robot.stop(True), robot.close()) == (-1, -1)  # never opened
    assert robot.open() == robot.open() == 0
    server.__exit__(None, None, None)
    assert robot.movej2(JOINTS, 1.0, 1.0, 0.0, True) == -1
    assert isinstance(robot.last_error, ConnectionLost)
    for read in (robot.get_tcp_pose, robot.robotmoving, robot.get_last_error):
        with pytest.raises(ConnectionLost):
            read()
    with pytest.raises(ConnectionLost):
        robot.modbus_read("signal")
    assert robot.open() == -1  # nobody is there
    assert robot.close() == -1


def test_a_lost_answer_is_told_in_last_error(server: RecordingServer) -> None:
    gate = threading.Event()
    server.answer("movej2", lambda *_: gate.wait(30.0) and 4)
    with DucoCobot(server.host, server.port, timeout=0.05) as robot:
        assert robot.movej2(JOINTS, 1.0, 1.0, 0.0, True) == -1
        assert "movej2" in str(robot.last_error)
        gate.set()
        server.answer("stop", 4)
        assert robot.stop(True) == -1  # the connection is over, until it is opened again
        assert robot.open() == 0
        assert robot.stop(True) == 4
        assert robot.last_error is None


def test_what_the_controller_cannot_do_raises(robot: DucoCobot) -> None:
    with pytest.raises(ControllerError):
        robot.get_tcp_pose()
    with pytest.raises(ControllerError):
        robot.stop(True)


def test_a_wrong_type_never_reaches_the_socket(server: RecordingServer, robot: Any) -> None:
    for joints in (["a"] * 6, 3.0, None):
        with pytest.raises(ParameterError):
            robot.movej2(joints, 1.0, 1.0, 0.0, True)
    assert server.received() == ()
    server.answer("stop", 4)
    assert robot.stop(True) == 4


def test_true_is_1_to_a_function_that_takes_a_number(
    server: RecordingServer, robot: DucoCobot
) -> None:
    server.answer("modbus_write", 4)
    server.answer("stop", 4)
    robot.modbus_write("valve", True)
    robot.stop(1)  # type: ignore[arg-type]  # as old scripts have it
    assert [call.args for call in server.received()] == [("valve", 1), (True,)]


@pytest.mark.parametrize("name", ["robotmoving", "open", "close"])
def test_another_thread_is_told_to_make_its_own(name: str, robot: DucoCobot) -> None:
    raised: list[BaseException] = []

    def use() -> None:
        try:
            getattr(robot, name)()
        except RuntimeError as exc:
            raised.append(exc)

    thread = threading.Thread(target=use, name="second")
    thread.start()
    thread.join()
    (error,) = raised
    assert "make another DucoCobot" in str(error)
    assert "'second'" in str(error)


def test_one_left_open_warns(server: RecordingServer) -> None:
    robot = DucoCobot(server.host, server.port)
    robot.open()
    with pytest.warns(ResourceWarning, match="unclosed <DucoCobot"):
        robot.__del__()


def test_nobody_there(server: RecordingServer) -> None:
    server.__exit__(None, None, None)
    robot = DucoCobot(server.host, server.port)
    assert robot.open() == -1
    assert "not connect" in str(robot.last_error) or str(server.port) in str(robot.last_error)
    with pytest.raises(ConnectionError), robot:
        pass


def test_get_version_asks_nobody() -> None:
    assert DucoCobot("nowhere").get_version().startswith("aioduco ")


def test_a_program_of_the_manual_on_a_simulated_arm() -> None:
    with Simulator(speed=10.0) as sim:
        robot = DucoCobot(sim.host, sim.port)
        assert robot.open() == 0
        assert robot.power_on(True) == robot.enable(True) == 4
        assert robot.get_robot_state()[0] == 6
        assert robot.movej2(JOINTS, 2.0, 4.0, 0.0, True) == 4
        assert (
            max(abs(a - b) for a, b in zip(robot.get_actual_joints_position(), JOINTS, strict=True))
            < 1e-3
        )
        assert robot.close() == 0


def test_the_generated_module_is_up_to_date_and_the_check_can_fail(tmp_path: Path) -> None:
    def check(root: Path) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "idl/generate_compat.py", "--check"],
            cwd=root,
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
        )

    done = check(ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    for name in (
        "idl/generate_compat.py",
        "tests/data/manual-3.8.json",
        "aioduco/__init__.py",
        "aioduco/_wire/__init__.py",
        "aioduco/_wire/rpc.py",
        "aioduco/compat/_generated.py",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        text = "" if name.endswith("__init__.py") else (ROOT / name).read_text(encoding="utf-8")
        (tmp_path / name).write_text(text.replace("kp: float = 200.0", "kp: float = 201.0"))
    done = check(tmp_path)
    assert done.returncode == 1
    assert "kp: float = 201.0" in done.stdout
