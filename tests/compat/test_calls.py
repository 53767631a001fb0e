"""The vendor's class: what its functions send, return and refuse."""

from __future__ import annotations

import ast
import inspect
import json
import math
from pathlib import Path
from typing import Any, cast, get_args, get_origin, get_type_hints

import numpy as np
import pytest
from for_each import for_each
from thrift import Thrift

from aioduco import compat
from aioduco._wire import idl, rpc
from aioduco.compat import DucoCobot
from aioduco.compat._generated import KEYWORDS
from aioduco.errors import (
    ControllerError,
    ParameterError,
    UnknownFunction,
)
from aioduco.sim import Simulator
from aioduco.testing import RecordingServer

ROOT = Path(__file__).parents[2]
MANUAL = json.loads((ROOT / "tests/data/manual-3.8.json").read_text(encoding="utf-8"))["functions"]
VENDOR = json.loads((ROOT / "tests/data/vendor-python.json").read_text(encoding="utf-8"))
JOINTS = [0.1, 0.2, 1.5, 0.0, -1.5, 0.3]

#: what motions send for outputs that are not given
NO_OP = rpc.Op(trig_io_1=1, trig_io_2=1, trig_io_3=1)

#: by type of a result, one of its values
RESULTS: dict[Any, Any] = {int: 7, bool: True, float: 1.5, str: "word"}


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


@for_each("ip", [None, "", 5, "arm 1"])
def test_open_returns_minus_one_for_what_is_no_address(ip: Any) -> None:
    robot = DucoCobot(ip)
    assert robot.open() == -1
    assert "the host must be a name or an address" in str(robot.last_error)


@for_each("port", [-1, 0, 65536, 7003.5, True, None, "x", ""])
def test_open_returns_minus_one_for_what_is_no_port(port: Any) -> None:
    """It told of an unknown host, tried port 0 in place of 65536, or raised."""
    robot = DucoCobot("127.0.0.1", port)
    assert robot.open() == -1
    assert "the port must be a whole number from 1 to 65535" in str(robot.last_error)


def test_a_port_may_be_text(server: RecordingServer) -> None:
    port: Any = str(server.port)
    with DucoCobot(server.host, port):
        pass


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


def test_get_version_asks_nobody() -> None:
    robot = DucoCobot("nowhere")
    assert robot.get_version().startswith("aioduco ")
    assert robot.get_verion() == robot.get_version()


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
