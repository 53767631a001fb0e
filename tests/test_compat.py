"""The vendor's class: what it sends, returns and raises."""

from __future__ import annotations

import ast
import inspect
import json
import math
import signal
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast, get_args, get_origin, get_type_hints

import numpy as np
import pytest
from for_each import for_each
from interpreter import python
from thrift import Thrift
from thrift.transport.TTransport import TTransportException

from aioduco import compat
from aioduco._wire import idl, rpc
from aioduco._wire.connection import Connection
from aioduco.compat import DucoCobot
from aioduco.compat._generated import KEYWORDS
from aioduco.compat._runner import VendorModules
from aioduco.errors import (
    ConnectError,
    ConnectionLost,
    ControllerError,
    OutcomeUnknown,
    ParameterError,
    TaskStopped,
    UnknownFunction,
)
from aioduco.sim import Simulator
from aioduco.testing import Cut, FaultProxy, Place, RecordingServer, eventually

ROOT = Path(__file__).parents[1]
MANUAL = json.loads((ROOT / "tests/data/manual-3.8.json").read_text(encoding="utf-8"))["functions"]
VENDOR = json.loads((ROOT / "tests/data/vendor-python.json").read_text(encoding="utf-8"))
JOINTS = [0.1, 0.2, 1.5, 0.0, -1.5, 0.3]

#: what motions send for outputs that are not given
NO_OP = rpc.Op(trig_io_1=1, trig_io_2=1, trig_io_3=1)

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


def signature(name: str) -> dict[str, inspect.Parameter]:
    return dict(list(inspect.signature(getattr(DucoCobot, name)).parameters.items())[1:])


def arguments_of(text: str) -> dict[str, Any]:
    """The parameters of a signature in the data, with their defaults, `...` for none."""
    parts = [part.partition("=") for part in text.split(", ") if part]
    return {
        name: ... if not equals else None if value in ("op_", "[]") else ast.literal_eval(value)
        for name, equals, value in parts
    }


#: what public copies of the class have beyond the wire: nobody can say what they would send
BEYOND = {
    "get_joint_motion_params",
    "get_simulation_state",
    "get_stiffness_calibration_params",
    "save_stiffness_calibration_params",
    "set_servo_file_params",
    "set_stiffness_calibration_params",
}


@for_each("name", sorted(VENDOR["signatures"].keys() - BEYOND))
def test_signatures_are_those_of_the_vendors_class(name: str) -> None:
    ours = signature(name)
    newest, *older = map(arguments_of, VENDOR["signatures"][name])
    assert list(ours)[: len(newest)] == list(newest)
    # where the class has no default, ours may have the manual's
    stated = {each: default for each, default in newest.items() if default is not ...}
    stated |= dict.fromkeys(stated, True) if name == "fc_move" else {}  # as the manual prints it
    assert {each: ours[each].default for each in stated} == stated
    # what the wire has besides may be left out
    assert all(
        ours[each].default is not inspect.Parameter.empty for each in list(ours)[len(newest) :]
    )
    for each in older:
        assert each.keys() <= ours.keys() | KEYWORDS.get(name, {}).keys()


@for_each("function", [f for f in MANUAL if f["wire"]])
def test_names_and_defaults_are_the_manuals(function: dict[str, Any]) -> None:
    ours, wire = signature(function["name"]), function["wire"]
    others = KEYWORDS.get(wire, {})
    printed = [one for one in function["parameters"] if not one.get("out")]
    called = {one["name"]: others.get(one["name"], one["name"]) for one in printed}
    assert set(called.values()) <= ours.keys()
    # a prototype may be called as printed: by position, all or without what may be left out
    first = list(ours)[: len(printed)]
    if wire != "trackCartMotion":  # the manual has two of them the other way round
        assert first == list(called.values())
    may_be_left = [one["name"] for one in printed if "prototype_default" in one]
    assert all(ours[called[one]].default is not inspect.Parameter.empty for one in may_be_left)
    stated = {called[one["name"]]: one["default"] for one in printed if "default" in one}
    stated |= {
        row["parameter"]: row["default"] for row in VENDOR["manual_text"] if row["function"] == wire
    }
    for row in VENDOR["chosen"]:
        if wire in row["functions"] and "manual" in row:
            assert stated.pop(row["parameter"]) is row["manual"]
            assert ours[row["parameter"]].default is row["class"]
    after = dict(zip(ours, list(ours)[1:], strict=False))
    for name, default in stated.items():
        if ours[name].default is inspect.Parameter.empty:
            # one that follows must be given
            assert ours[after[name]].default is inspect.Parameter.empty
        else:
            assert ours[name].default == default


@for_each("row", VENDOR["chosen"])
def test_what_is_chosen_besides(row: dict[str, Any]) -> None:
    for name in row["functions"]:
        assert signature(name)[row["parameter"]].default == row.get("default", row.get("class"))


@for_each("name", sorted(KEYWORDS))
def test_other_names_of_arguments_send_the_same(
    name: str, server: RecordingServer, robot: DucoCobot
) -> None:
    function = getattr(robot, name)
    types = types_of(name)
    returns = types.pop("return")
    server.answer(name, None if returns is type(None) else sample(returns))
    by_name = dict(
        zip(inspect.signature(function).parameters, map(sample, types.values()), strict=False)
    )
    function(**by_name)
    for other, real in KEYWORDS[name].items():
        given = {other if key == real else key: value for key, value in by_name.items()}
        function(**given)
        with pytest.raises(TypeError, match=f"{other} is another name of {real}"):
            function(**{**by_name, other: by_name[real]})
    (first, *rest) = server.received(name)
    assert len(rest) == len(KEYWORDS[name])
    assert all(call.args == first.args for call in rest)


@for_each("name", sorted(idl.functions()))
def test_each_function_sends_its_arguments_and_returns_the_answer(
    name: str, server: RecordingServer, robot: DucoCobot
) -> None:
    types = types_of(name)
    returns = types.pop("return")
    answer = None if returns is type(None) else sample(returns)
    server.answer(name, answer)
    args = tuple(sample(kind) for kind in types.values())
    before = len(server.received())
    assert getattr(robot, name)(*args) == answer
    (call,) = server.received()[before:]
    assert (call.method, call.args) == (name, args)


@pytest.mark.parametrize(
    ("name", "args", "sent"),
    [
        ("movej2", (JOINTS, 1.0, 2.0, 0.0, True), (JOINTS, 1.0, 2.0, 0.0, True, NO_OP, False)),
        ("rpc_heartbeat", (), (1000,)),
        ("set_wobj_offset", (JOINTS,), (JOINTS, True)),
        ("set_blend_ahead", (0,), (0, 1)),
        ("fc_guard_act", ([True], [1.0], None, "", 1), ([True], [1.0], "", "", 1, 0)),
        ("start_realtime_mode", (0,), (0, 100.0, 0.02)),
        (
            "combine_motion_config",
            (1, 0, 1, 0.01, 0, 0, 0, [0, 0]),
            (1, 0, 1.0, 0.01, 0.0, 0.0, 0.0, [0, 0], False, []),
        ),
        (  # as older versions of the class have it
            "combine_motion_config",
            (1, 0, 1.0, 0.01, 0.0, 0.0, 0.0, [0, 0], [NO_OP]),
            (1, 0, 1.0, 0.01, 0.0, 0.0, 0.0, [0, 0], False, [NO_OP]),
        ),
        ("move_eaxis", ("s", [0.1], 0.2, True, None, True), ("s", [0.1], 0.2, True, NO_OP)),
        ("speedj", (JOINTS, 1.0), (JOINTS, 1.0, -1, False)),
        ("get_tcp_pose_coord", (), ("", "")),
        ("servoj", (JOINTS, 1.0, 2.0), (JOINTS, 1.0, 2.0, False, 200.0, 25.0, 10.0, 1.0)),
        (
            "movel",
            (JOINTS, 0.1, 0.2, 0.0, None, None, None, True),
            (JOINTS, 0.1, 0.2, 0.0, [], "", "", True, NO_OP, False),
        ),
        (
            "movel",
            (JOINTS, 0.1, 0.2, 0.0, "", "", "", True, None),
            (JOINTS, 0.1, 0.2, 0.0, [], "", "", True, NO_OP, False),
        ),
        ("cal_ikine", (JOINTS, "", None, []), (JOINTS, [], [], [])),
        ("servoj", (JOINTS, 1.0, 2.0, False), (JOINTS, 1.0, 2.0, False, 200.0, 25.0, 10.0, 1.0)),
        ("fc_move", (), (True,)),
        ("trackCartMotion", (0.1, 0.2, True, "t", "w"), (0.1, 0.2, True, "t", "w", 0.005)),
        ("start_record_track", ("a", 0, "t", "w"), ("a", 0, "t", "w", 5.0)),
        ("start_record_track", ("a", 1, "t", "w"), ("a", 1, "t", "w", 0.25)),
        ("start_record_track", ("a", 1, "t", "w", 0.0), ("a", 1, "t", "w", 0.0)),
    ],
)
def test_what_is_left_out_is_filled_in_as_the_vendor_does(
    name: str, args: tuple[Any, ...], sent: tuple[Any, ...], server: RecordingServer, robot: Any
) -> None:
    returns = types_of(name)["return"]
    answer = None if returns is type(None) else 4 if returns is int else sample(returns)
    server.answer(name, answer)
    assert getattr(robot, name)(*args) == answer
    assert server.received(name)[0].args == sent


@pytest.mark.parametrize(
    "data", [[255, 1, -1, 127], b"\xff\x01\xff\x7f", bytearray([255, 1, 255, 127])]
)
def test_bytes_have_one_meaning(data: Any, server: RecordingServer, robot: DucoCobot) -> None:
    sent = [-1, 1, -1, 127]
    for name in ("write_raw_data_485", "tool_write_raw_data_485", "write_data_485"):
        server.answer(name, True)
        getattr(robot, name)(data)
        assert server.received(name)[0].args == (sent,)
    server.answer("write_raw_data_485_ht", True)
    robot.write_raw_data_485_ht(data, data, data)
    assert server.received("write_raw_data_485_ht")[0].args == (sent, sent, sent)
    server.answer("write_raw_data_can", True)
    robot.write_raw_data_can(255, data)
    assert server.received("write_raw_data_can")[0].args == (255, sent)
    server.answer("modbus_write_multiple_regs", 4)
    robot.modbus_write_multiple_regs(1, "r", 3, [40000, -25536, 7])
    assert server.received("modbus_write_multiple_regs")[0].args[3] == [-25536, -25536, 7]
    with pytest.raises(ParameterError):
        robot.write_raw_data_485([256])


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


class TheirOp:
    """As the vendor's client makes it: what is not set is None, and what it lacks is not there."""

    thrift_spec = ()

    def __init__(self) -> None:
        self.time_or_dist_1: Any = None
        self.trig_io_1: Any = None
        self.trig_value_1: Any = None
        self.trig_event_2: Any = None


class TheirPoint:
    def __init__(self, pos: list[float], op: TheirOp) -> None:
        self.pos, self.op = pos, op


def test_structs_may_be_the_vendors_own(server: RecordingServer, robot: Any) -> None:
    op = TheirOp()
    op.time_or_dist_1, op.trig_io_1, op.trig_value_1 = 1, 3, True
    ours = rpc.Op(time_or_dist_1=1, trig_io_1=3, trig_value_1=True)
    for name in ("movej2", "trackEnqueueOp", "combine_motion_config"):
        server.answer(name, 4)
    robot.movej2(JOINTS, 1.0, 1.0, 0.0, True, op)
    robot.trackEnqueueOp([TheirPoint(JOINTS, op)], False)
    robot.combine_motion_config(1, 0, 1.0, 0.01, 0.0, 0.0, 0.0, [0, 0], op_list=[op])
    assert server.received("movej2")[0].args[5] == ours
    assert server.received("trackEnqueueOp")[0].args[0] == [rpc.PointOp(JOINTS, ours)]
    assert server.received("combine_motion_config")[0].args[9] == [ours]
    robot.op_.time_or_dist_2 = 1
    robot.movej2(JOINTS, 1.0, 1.0, 0.0, True)
    assert server.received("movej2")[1].args[5].time_or_dist_2 == 1
    with pytest.raises(ParameterError):
        robot.movej2(JOINTS, 1.0, 1.0, 0.0, True, object())


def test_a_lost_connection_raises_what_the_vendors_class_raises(server: RecordingServer) -> None:
    robot = DucoCobot(server.host, server.port)
    assert robot.close() == 0
    with pytest.raises(TTransportException) as never_opened:
        robot.stop(True)
    assert never_opened.value.type == TTransportException.NOT_OPEN
    assert robot.open() == robot.open() == 0
    server.__exit__(None, None, None)
    for call in (
        robot.get_tcp_pose,
        robot.robotmoving,
        lambda: robot.movej2(JOINTS, 1, 1, 0, True),
    ):
        with pytest.raises(Thrift.TException) as lost:
            call()
        assert isinstance(lost.value, ConnectionLost)
        assert lost.value is robot.last_error
        assert lost.value.args[0] == lost.value.__dict__["message"] == str(lost.value)
    assert robot.open() == -1  # nobody is there
    assert isinstance(robot.last_error, ConnectError)
    assert str(server.port) in str(robot.last_error)
    with pytest.raises(ConnectionError), robot:
        pass
    assert robot.close() == 0


@for_each("ip", [None, "", 5, "arm 1"])
def test_open_returns_minus_one_for_what_is_no_address(ip: Any) -> None:
    robot = DucoCobot(ip)
    assert robot.open() == -1
    assert "the host must be a name or an address" in str(robot.last_error)


@pytest.mark.slow
def test_a_lost_answer_is_told_in_last_error(server: RecordingServer) -> None:
    gate = threading.Event()
    server.answer("movej2", lambda *_: gate.wait(30.0) and 4)
    with DucoCobot(server.host, server.port, timeout=1.0) as robot:
        with pytest.raises(OutcomeUnknown, match="movej2"):
            robot.movej2(JOINTS, 1.0, 1.0, 0.0, True)
        assert "movej2" in str(robot.last_error)
        gate.set()
        server.answer("stop", 4)
        server.answer("robotmoving", True)
        assert robot.stop(True) == 4  # on a new connection
        with pytest.raises(ConnectionLost):
            robot.robotmoving()  # the object's own is over, until it is opened again
        assert robot.open() == 0
        assert robot.robotmoving() is True
        assert robot.last_error is None


def test_what_the_controller_cannot_do_raises(robot: DucoCobot) -> None:
    for call in (robot.get_tcp_pose, lambda: robot.stop(True)):
        with pytest.raises(ControllerError) as refused:
            call()
        assert isinstance(refused.value, Thrift.TApplicationException)


def test_a_wrong_type_never_reaches_the_socket(server: RecordingServer, robot: Any) -> None:
    for joints in (["a"] * 6, 3.0, None, ""):
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


def in_thread(call: Any, name: str = "second") -> tuple[threading.Thread, list[Any]]:
    """A call in a thread of its own, and what it gave, once the thread has ended."""
    ended: list[Any] = []

    def run() -> None:
        try:
            ended.append(call())
        except (ConnectionLost, TaskStopped) as exc:
            ended.append(exc)

    thread = threading.Thread(target=run, name=name)
    thread.start()
    return thread, ended


class Blocking:
    """A motion on a recording server that goes on until `gate` is set."""

    def __init__(self, server: RecordingServer) -> None:
        self.gate, self.begun = threading.Event(), threading.Event()
        server.answer("movej2", self._move)
        server.answer("robotmoving", True)
        server.answer("stop", 4)

    def _move(self, *_: Any) -> int:
        self.begun.set()
        assert self.gate.wait(30.0)
        return 4

    def start(self, robot: DucoCobot) -> tuple[threading.Thread, list[Any]]:
        started = in_thread(lambda: robot.movej2(JOINTS, 1.0, 1.0, 0.0, True), "mover")
        assert self.begun.wait(30.0)
        return started


def test_threads_take_turns_and_a_stop_does_not_wait(
    server: RecordingServer, robot: DucoCobot, caplog: pytest.LogCaptureFixture
) -> None:
    motion = Blocking(server)
    mover, moved = motion.start(robot)
    asker, answers = in_thread(robot.robotmoving)
    assert robot.open() == 0
    assert robot.stop(True) == 4  # the same object
    with DucoCobot(server.host, server.port) as second:
        assert second.stop(True) == 4
        assert second.robotmoving() is True
    assert [call.method for call in server.received()] == ["movej2", "stop", "stop", "robotmoving"]
    assert asker.is_alive()
    motion.gate.set()
    mover.join()
    asker.join()
    assert (moved, answers) == ([4], [True])
    eventually(lambda: "is used in thread" in caplog.text)
    assert caplog.text.count("is used in thread") == 1


@pytest.mark.parametrize("other", [False, True])
def test_a_motion_that_waits_when_the_arm_is_stopped_is_not_sent(
    server: RecordingServer, robot: DucoCobot, monkeypatch: pytest.MonkeyPatch, other: bool
) -> None:
    """By another object, too, as manual 1.3.3 asks for; what comes after the stop is sent."""
    motion = Blocking(server)
    server.answer("servoj", 1000)
    server.answer("set_standard_digital_out", 4)
    waiting, acquire = threading.Semaphore(0), robot._acquire
    mover, _ = motion.start(robot)

    def wait() -> None:
        waiting.release()
        acquire()

    monkeypatch.setattr(robot, "_acquire", wait)
    next_one, moved = in_thread(lambda: robot.servoj(JOINTS, 1.0, 1.0))
    output, is_set = in_thread(lambda: robot.set_standard_digital_out(1, False, True))
    for _ in range(2):
        assert waiting.acquire(timeout=30.0)
    with DucoCobot(server.host, server.port) as second:
        assert (second if other else robot).stop(True) == 4
    motion.gate.set()
    for thread in (mover, next_one, output):
        thread.join()
    assert isinstance(moved[0], TaskStopped)
    assert "servoj was not sent" in str(moved[0])
    assert is_set == [4]
    assert not server.received("servoj")
    assert robot.servoj(JOINTS, 1.0, 1.0) == 1000


def test_a_stop_until_the_last_moment_keeps_a_motion_back(
    server: RecordingServer, robot: DucoCobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    server.answer("stop", 4)
    hand_over = Connection.hand_over

    def late(connection: Connection) -> None:
        hand_over(connection)
        if connection is robot._connection:
            assert second.stop(True) == 4

    with DucoCobot(server.host, server.port) as second:
        monkeypatch.setattr(Connection, "hand_over", late)
        with pytest.raises(TaskStopped):
            robot.movej2(JOINTS, 1.0, 1.0, 0.0, True)
    assert [call.method for call in server.received()] == ["stop"]


def test_a_call_in_the_middle_of_another_by_a_signal_handler(
    server: RecordingServer, robot: DucoCobot
) -> None:
    motion = Blocking(server)
    answers = []
    waiting = threading.get_ident()

    def handler(*_: Any) -> None:
        answers.append((robot.stop(True), robot.robotmoving()))
        motion.gate.set()

    def kill() -> None:
        assert motion.begun.wait(30.0)
        signal.pthread_kill(waiting, signal.SIGUSR1)

    former = signal.signal(signal.SIGUSR1, handler)
    try:
        killer = threading.Thread(target=kill)
        killer.start()
        assert robot.movej2(JOINTS, 1.0, 1.0, 0.0, True) == 4
        killer.join()
    finally:
        signal.signal(signal.SIGUSR1, former)
    assert answers == [(4, True)]


def test_after_an_interrupted_call_the_next_ones_are_sent(
    server: RecordingServer, robot: DucoCobot
) -> None:
    motion = Blocking(server)
    server.answer("disable", 4)

    def kill(thread: int) -> None:
        assert motion.begun.wait(30.0)
        signal.pthread_kill(thread, signal.SIGUSR1)

    former = signal.signal(signal.SIGUSR1, signal.default_int_handler)  # as Ctrl-C
    killer = threading.Thread(target=kill, args=(threading.get_ident(),))
    killer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            robot.movej2(JOINTS, 1.0, 1.0, 0.0, True)
        assert robot.stop(True) == robot.disable(True) == 4
        assert robot.robotmoving() is True
    finally:
        signal.signal(signal.SIGUSR1, former)
        motion.gate.set()
        killer.join()


def test_a_stop_is_sent_although_the_connection_is_lost(server: RecordingServer) -> None:
    server.answer("stop", 4)
    server.answer("robotmoving", True)
    with (
        FaultProxy(server.host, server.port) as proxy,
        DucoCobot(proxy.host, proxy.port) as robot,
    ):
        proxy.on("robotmoving", Cut(Place.BEFORE_REPLY))
        with pytest.raises(ConnectionLost):
            robot.robotmoving()
        with pytest.raises(ConnectionLost, match=r"the connection broke.*; call open\(\) first"):
            robot.robotmoving()
        assert robot.stop(True) == 4
        assert robot.open() == 0
        proxy.on("stop", Cut(Place.BEFORE_REPLY))
        assert robot.stop(True) == 4  # the first answer is lost
    assert len(server.received("stop")) == 3


def test_closing_ends_what_another_thread_waits_for(
    server: RecordingServer, robot: DucoCobot
) -> None:
    motion = Blocking(server)
    mover, moved = motion.start(robot)
    assert robot.close() == 0
    mover.join()
    assert isinstance(moved[0], OutcomeUnknown)
    assert robot.open() == 0
    assert robot.stop(True) == 4
    motion.gate.set()


def test_a_call_that_waits_when_its_connection_is_closed_is_not_sent_on_the_next(
    server: RecordingServer, robot: DucoCobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = Blocking(server)
    waits, opened, acquire = threading.Event(), threading.Event(), robot._acquire
    mover, _ = motion.start(robot)

    def wait() -> None:
        if threading.current_thread().name == "waiter":
            waits.set()
            assert opened.wait(30.0)
        acquire()

    monkeypatch.setattr(robot, "_acquire", wait)
    waiter, answers = in_thread(lambda: robot.movej2(JOINTS, 1.0, 1.0, 0.0, True), "waiter")
    assert waits.wait(30.0)
    motion.gate.set()
    assert robot.close() == 0
    assert robot.open() == 0
    opened.set()
    waiter.join()
    mover.join()
    assert isinstance(answers[0], ConnectionLost)
    assert len(server.received("movej2")) == 1


def test_one_left_open_warns(server: RecordingServer) -> None:
    robot = DucoCobot(server.host, server.port)
    robot.open()
    with pytest.warns(ResourceWarning, match="unclosed <DucoCobot"):
        robot.__del__()


def test_get_version_asks_nobody() -> None:
    robot = DucoCobot("nowhere")
    assert robot.get_version().startswith("aioduco ")
    assert robot.get_verion() == robot.get_version()


#: a program of the vendor's users; {lib} is where its imports put Thrift's library
PROGRAM = """
import os, sys, threading
sys.path.append("gen_py")
sys.path.append("lib")
from DucoCobot import DucoCobot
from gen_py.robot.ttypes import StateRobot, StateProgram, OperationMode, TaskState, Op, PointOp
from {lib} import Thrift
from {lib}.transport import TSocket, TTransport
from {lib}.protocol import TBinaryProtocol
from gen_py.robot import RPCRobot
from vendor.DucoCobot import DucoCobot as Same
from vendor.gen_py.robot.ttypes import TaskState as SameState

assert Same is DucoCobot and SameState.ST_Finished == 4 == TaskState.ST_Finished
assert TaskState._VALUES_TO_NAMES[5] == "ST_Interrupt" and StateRobot.SR_Enable == 6
ip, port = sys.argv[1], int(sys.argv[2])
beats = DucoCobot(ip, port)
robot = DucoCobot(ip, port)
print("open", robot.open(), beats.open())
print("power", robot.power_on(True), robot.enable(True))
op = Op(0, 1, False, 0, 0, "", 0, 1, False, 0, 0, "", 0, 1, False, 0, 0, "")
print("move", robot.movej2([0.1, 0, 1.5, 0, 1.5, 0], 2, 4, 0, True, op=op))
beats.rpc_heartbeat()
beats.close()
robot.close()
try:
    robot.get_tcp_pose()
except Thrift.TException as tx:
    print("lost", type(tx).__name__, tx.message)
    print(isinstance(tx, TTransport.TTransportException), tx.type == 1)
print(os.path.basename(__file__), sys.argv[0] == __file__, __name__)
"""


#: the runner where Thrift's library is not installed
WITHOUT_THRIFT = """
import importlib.util
import sys
find = importlib.util.find_spec
importlib.util.find_spec = lambda name: None if name == "thrift" else find(name)
from aioduco.compat.__main__ import main
main(sys.argv[1:])
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lib", "runner"),
    [
        ("thrift", ["-m", "aioduco.compat"]),
        ("lib.thrift", ["-m", "aioduco.compat"]),
        ("thrift", ["-c", WITHOUT_THRIFT]),
    ],
    ids=["installed", "the vendor's copy", "not installed"],
)
def test_a_program_for_the_vendors_class_runs_unchanged(
    lib: str, runner: list[str], tmp_path: Path
) -> None:
    program = tmp_path / "program.py"
    program.write_text(PROGRAM.format(lib=lib), encoding="utf-8")
    (tmp_path / "lib").mkdir()
    (tmp_path / "vendor").mkdir()
    with Simulator(speed=10.0) as sim:
        done = python(*runner, str(program), sim.host, str(sim.port), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[:3] == ["open 0 0", "power 4 4", "move 4"]
    assert lines[3].startswith("lost ConnectionLost get_tcp_pose was not sent")
    assert lines[4:] == ["True True", "program.py True __main__"]


def test_thrifts_library_is_replaced_only_where_it_is_missing() -> None:
    with_it, without = VendorModules(thrift=False), VendorModules(thrift=True)
    assert with_it.find_spec("thrift.Thrift") is None
    assert with_it.find_spec("vendor.lib.thrift.Thrift") is not None
    for name in ("thrift", "thrift.Thrift", "vendor.lib.thrift.transport.TTransport"):
        assert without.find_spec(name) is not None
    for name in ("thriftpy2.thrift", "other.thrift", "thrift.server", "my.ducocobot", "gen"):
        assert without.find_spec(name) is None


def test_functions_of_the_newer_manual_without_arguments_are_sent(
    server: RecordingServer, robot: DucoCobot
) -> None:
    for name, returned in idl.functions().newer.items():
        value = {"list<double>": [0.5] * 6, "i32": 4, "bool": True, "void": None}[returned]
        server.answer(name, value)
        assert getattr(robot, name)() == value
        assert server.received(name)[0].args == ()


def test_an_older_controller_does_not_know_them() -> None:
    with Simulator(speed=math.inf) as sim, DucoCobot(sim.host, sim.port) as robot:
        for name in idl.functions().newer:
            with pytest.raises(UnknownFunction, match=name):
                getattr(robot, name)()
        assert robot.get_robot_state()  # the connection lives on


@pytest.mark.parametrize("radius", [0, 0.0])
def test_an_arc_without_a_fixed_radius(
    radius: float, server: RecordingServer, robot: DucoCobot
) -> None:
    server.answer("movec", 4)
    arc = (JOINTS, JOINTS, 0.2, 0.4, 0.0, 0, None, "", "", True, None, True)
    assert robot.movec(*arc, radius) == robot.movec(*arc, arc_rad=radius) == 4
    assert len(server.received("movec")[0].args) == len(arc)
    for wrong in (0.1, np.array([0.0, 0.1]), "0", None, math.nan):
        with pytest.raises(ParameterError, match=r"arc_rad is .* must be 0: where the wire"):
            robot.movec(*arc, cast("Any", wrong))


def test_a_jog_as_section_1_3_5_spells_it(server: RecordingServer, robot: DucoCobot) -> None:
    server.answer("move_jog", 4)
    jog = compat.MoveJogTaskParams(jog_direction=1, jog_type=1, use_step=True, step_cartValue=0.05)
    robot.move_jog(jog, True)
    jog.step_cartValue = 0.06
    robot.move_jog(jog, True)
    sent = [call.args[0].step_cartvalue for call in server.received("move_jog")]
    assert sent == [0.05, 0.06]
    with pytest.raises(TypeError, match="another name"):
        compat.MoveJogTaskParam(step_cartValue=0.05, step_cartvalue=0.05)


def test_whole_numbers_may_be_doubles(server: RecordingServer, robot: Any) -> None:
    server.answer("write_raw_data_can", True)
    robot.write_raw_data_can(3.0, [1])
    assert server.received("write_raw_data_can")[0].args[0] == 3
    with pytest.raises(ParameterError):
        robot.write_raw_data_can(3.5, [1])


#: how programs load a module whose name they are told
LOAD = "import importlib, sys\ndef load(name):\n    return importlib.import_module(name).DucoCobot"


#: ways to name a package of which there is nothing, `{}`
NAMED = [
    "from {}.DucoCobot import DucoCobot",
    "from {}.DucoCobot import *",
    "from {} import DucoCobot as m; DucoCobot = m.DucoCobot",
    "import {}.deeper.DucoCobot as m; DucoCobot = m.DucoCobot",
    "from {}.gen_py.robot.ttypes import Op; DucoCobot = Op",
    "from {0}.lib.thrift import Thrift; from {0}.DucoCobot import DucoCobot",
    "import importlib; DucoCobot = importlib.import_module('{}.DucoCobot').DucoCobot",
    "def sdk(name='{}.DucoCobot'):\n    return load(name)\nDucoCobot = sdk()",
    "SDK = {{'module': '{}.DucoCobot'}}\nDucoCobot = load(SDK['module'])",
]


@pytest.mark.slow
def test_packages_without_the_vendors_files(tmp_path: Path) -> None:
    """Each is named in one way alone."""
    lines = [LOAD]
    for number, way in enumerate(NAMED):
        lines += [way.format(f"vendor_{number}"), "print(DucoCobot.__module__)", "del DucoCobot"]
    lines += ["try:\n    import vendor_x\nexcept ImportError:\n    print('others are missing')", ""]
    program = tmp_path / "program.py"
    program.write_text("\n".join(lines), encoding="utf-8")
    done = python("-m", "aioduco.compat", str(program))
    wanted = ["aioduco.compat"] * len(NAMED)
    wanted[4] = "aioduco._wire.rpc"
    assert done.stdout.splitlines() == [*wanted, "others are missing"], done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments", [["--sdk-module", "vendor_api.DucoCobot"], ["--sdk-module=vendor_api.DucoCobot"]]
)
def test_packages_that_only_the_arguments_of_a_program_name(
    arguments: list[str], tmp_path: Path
) -> None:
    program = tmp_path / "program.py"
    program.write_text(
        f"{LOAD}\nprint(load(sys.argv[-1].rpartition('=')[2]).__module__)\n", encoding="utf-8"
    )
    done = python("-m", "aioduco.compat", str(program), *arguments)
    assert done.stdout.strip() == "aioduco.compat", done.stderr


@pytest.mark.cases(1)
@pytest.mark.parametrize("name", ["cell.node", "cell.deeper", "cell"])
def test_a_program_that_is_a_module_of_a_package(name: str, tmp_path: Path) -> None:
    """As nodes of ROS are: such a program imports the vendor's class from its own package."""
    own = tmp_path / "cell" / "deeper"
    own.mkdir(parents=True)
    (own.parent / "__init__.py").touch()
    (own / "__init__.py").touch()
    for file, dots in (("node.py", "."), ("__main__.py", "."), ("deeper/__main__.py", "..")):
        (own.parent / file).write_text(
            "import sys\n"
            f"from {dots}DucoCobot import DucoCobot\n"
            f"from {dots}gen_py.robot.ttypes import Op\n"
            "from vendor_api.DucoCobot import DucoCobot as Same\n"
            "print(DucoCobot.__module__, Same is DucoCobot, __name__, sys.argv[1:])\n",
            encoding="utf-8",
        )
    done = python("-m", "aioduco.compat", "-m", name, "-m", "more", cwd=tmp_path)
    assert done.stdout == "aioduco.compat True __main__ ['-m', 'more']\n", done.stderr


@pytest.mark.parametrize("package", ["DucoCobot", "cell.DucoCobot"])
def test_own_modules_in_the_vendors_folder(package: str, tmp_path: Path) -> None:
    """They are imported as they are, wherever that folder is."""
    folder = tmp_path.joinpath(*package.split("."))
    folder.mkdir(parents=True)
    (folder / "DucoCobot.py").write_text("raise ImportError", encoding="utf-8")
    (folder / "points.py").write_text("HOME = 'home'", encoding="utf-8")
    program = tmp_path / "program.py"
    program.write_text(
        f"from {package}.DucoCobot import DucoCobot\n"
        f"from {package}.points import HOME\n"
        "print(DucoCobot.__module__, HOME)\n",
        encoding="utf-8",
    )
    done = python("-m", "aioduco.compat", str(program))
    assert done.stdout == "aioduco.compat home\n", done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["nothing", "nothing.here", "there.not", "json.decoder.not", "..here"]
)
def test_a_module_that_is_not_there(name: str, tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "there/__init__.py").touch()
    done = python("-m", "aioduco.compat", "-m", name, cwd=tmp_path)
    assert done.returncode == 2
    assert f" {name} is no module in " in done.stderr
