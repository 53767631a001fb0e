"""A controller of manual 4.3: what it adds to its answers, and the order of its arguments."""

from __future__ import annotations

import math
from typing import Any

import pytest
from for_each import for_each

import aioduco
from aioduco._wire import codec, idl, newer, rpc
from aioduco._wire.framing import TType
from api.desk import Desk

HOME = [0.0, 0.0, 1.5, 0.0, -1.5, 0.0]
POSE, WOBJ, TOOL = [0.5, 0.1, 0.6, 3.1, 0.0, -1.5], [0.1] * 6, [0.2] * 6
TORQUES = [
    *("jointAuxiliaryPosition", "jointDynamicTorque", "jointGravityTorque"),
    *("jointActualTorque", "jointExtraTorque"),
]


def with_fields(struct: type, *added: tuple[Any, ...], without: int = 0, **values: Any) -> Any:
    """Return a struct with the fields of a newer controller, from the number `without` on anew."""
    idl.functions()
    spec = dict(vars(struct)["thrift_spec"])
    if without:
        spec = {number: entry for number, entry in spec.items() if number < without}
    spec.update({number: tuple(entry) for number, *entry in added})
    kind: Any = type("Newer", (), {"thrift_spec": spec})
    made = kind()
    for _, name, *_ in spec.values():
        setattr(made, name, values.get(name))
    return made


def body(name: str, value: Any) -> Any:
    function = idl.functions()[name]
    result = function.result()
    result.success = value
    encoded = codec._thrift().write_struct(result)
    data = b"\x80\x01\x00\x02" + function.head + (1).to_bytes(4) + encoded
    reader = codec.ReplyReader(function, 1)
    assert reader.whole(data)
    read = reader.value(data)
    again = codec.ReplyReader(function, 1)  # of a layout that is known by now
    assert again.whole(data)
    assert again.value(data) == read
    return read


def reachability(result: bool, index: int = 0, singularity: int = 0) -> Any:
    return with_fields(
        rpc.ReachabilityParam,
        *((2, TType.I32, "index", False), (3, TType.I32, "singularity_type", False)),
        without=2,
        result=result,
        index=index,
        singularity_type=singularity,
    )


async def check(desk: Desk, version: str, answer: Any) -> Any:
    desk.answer("get_robot_version", version)
    desk.answer("reach_check", answer)
    async with aioduco.connect(desk.host, desk.port) as robot:
        return await robot.kinematics.reach_check(
            base=POSE, wobj=WOBJ, tool=TOOL, ref_pos=HOME, check_points=[POSE]
        )


async def test_what_reach_check_found(desk: Desk) -> None:
    found = await check(desk, "V4.3.0", reachability(False, 2, 3))
    assert (found.reachable, found.joints, found.index, found.singularity) == (False, (), 2, 3)
    assert desk.received("reach_check")[0].args[:3] == (POSE, TOOL, WOBJ)
    found = await check(desk, "V4.3.0", reachability(True, 0, 0))
    assert (found.reachable, found.index, found.singularity) == (True, None, 0)


async def test_an_answer_of_4_3_from_a_controller_of_another_version(desk: Desk) -> None:
    with pytest.raises(aioduco.ControllerError, match="order"):
        await check(desk, "V3.8.0", reachability(True))
    assert desk.received("reach_check")[0].args[:3] == (POSE, WOBJ, TOOL)


async def test_the_torques_of_the_joints(desk: Desk) -> None:
    old = desk._answers["getRobotStatus"]()
    values = {entry[1]: getattr(old, entry[1]) for entry in old.thrift_spec.values()}
    added = [(22 + at, TType.LIST, name, TType.DOUBLE, False) for at, name in enumerate(TORQUES)]
    for at, name in enumerate(TORQUES):
        values[name] = [float(at)] * 6
    desk.answer("getRobotStatus", with_fields(rpc.RobotStatus, *added, **values))
    async with aioduco.connect(desk.host, desk.port) as robot:
        for _ in range(3):
            torques = (await robot.state.getRobotStatus()).torques
            assert torques is not None
            assert torques.auxiliary_positions.tolist() == [0.0] * 6
            assert torques.extra.tolist() == [4.0] * 6
        desk.answer("getRobotStatus", old)
        assert (await robot.state.getRobotStatus()).torques is None


@pytest.mark.parametrize("vel", [0.0, 0.25])
async def test_the_rates_of_external_axes(desk: Desk, vel: float) -> None:
    added = [(4, TType.DOUBLE, "vel", False), (5, TType.DOUBLE, "acc", False)]
    values: dict[str, Any] = {"scheme_name": "rail", "status": 1, "pos": 0.5}
    values |= {"vel": vel, "acc": 0.0}
    desk.answer("get_eaxis_info", [with_fields(rpc.EAxissInfo, *added, **values)])
    async with aioduco.connect(desk.host, desk.port) as robot:
        (scheme,) = await robot.external_axes.get_eaxis_info()
        assert (scheme.position, scheme.vel, scheme.acc) == (0.5, vel, 0.0)
        desk.answer("get_eaxis_info", [rpc.EAxissInfo("rail", 1, 0.5)])
        (scheme,) = await robot.external_axes.get_eaxis_info()
        assert math.isnan(scheme.vel)


def moves(robot: aioduco.Robot) -> dict[str, Any]:
    """How to make each motion with external axes."""
    axes, to = robot.external_axes, ("rail", [0.5, 0.0, 0.0], 0.25)
    return {
        "move_eaxis": lambda: axes.move_eaxis(*to),
        "movej2_eaxis": lambda: axes.movej2_eaxis(HOME, 1.0, 1.0, *to),
        "movej2_pose_eaxis": lambda: axes.movej2_pose_eaxis(POSE, 1.0, 1.0, *to),
        "movel_eaxis": lambda: axes.movel_eaxis(POSE, 0.1, 0.1, *to),
        "movec_eaxis": lambda: axes.movec_eaxis(POSE, TOOL, 0.1, 0.1, *to),
        "move_circle_eaxis": lambda: axes.move_circle_eaxis(POSE, TOOL, 0.1, 0.1, *to),
    }


@pytest.mark.parametrize(
    ("version", "refused"),
    [
        ("V3.8.0", ()),
        ("", ()),
        ("V4.0.1", tuple(newer.SCHEMES)),
        ("2026.04.14", tuple(newer.SCHEMES)),
        ("D1 beta", tuple(newer.SCHEMES)),
        ("older, it says", ()),
        ("V4.3.0", ("move_circle_eaxis",)),
    ],
)
async def test_motions_of_external_axes(desk: Desk, version: str, refused: tuple[str, ...]) -> None:
    """A scheme by its name in 3.8, schemes in lists in 4.3; where that is not known, nothing."""
    desk.answer("get_robot_version", version)
    async with aioduco.connect(desk.host, desk.port) as robot:
        for name, made in moves(robot).items():
            if name in refused:
                with pytest.raises(aioduco.LayoutUnknown, match=f"{name}.*{version}.*nothing was"):
                    made()
                continue
            motion = made()
            motion.mark_used()  # it is looked at in place of being sent
            args = dict(zip(idl.functions()[name].parameters, motion.command.args, strict=True))
            assert isinstance(args["scheme_name"], list) is (version == "V4.3.0")
            speed = args["v"] if name == "move_eaxis" else args["eaxis_v"]
            assert speed == ([0.25] if version == "V4.3.0" else 0.25)
    assert not any(desk.received(name) for name in newer.SCHEMES)


@for_each("name", newer.SCHEMES)
def test_a_motion_of_external_axes_is_not_made_before_the_version_is_known(name: str) -> None:
    with pytest.raises(aioduco.RobotStateError, match=f"{name} was not sent.*not open"):
        moves(aioduco.connect("127.0.0.1"))[name]()


@for_each("name", newer.SCHEMES)
def test_a_tap_reads_schemes_in_lists(name: str) -> None:
    function = idl.functions()[name]
    assert function.listed is not None
    zeros = dict(zip(function.parameters, (zero() for zero in function.listed.zeros), strict=True))
    lists = {"scheme_name": ["rail"], "epose": [[0.5]]}
    data = codec.encode(function, tuple((zeros | lists).values()))
    assert codec.decode_arguments(function, data) | lists == codec.decode_arguments(function, data)


async def test_functions_without_arguments(desk: Desk) -> None:
    desk.answer("get_base", POSE)
    desk.answer("get_home_pose", HOME)
    desk.answer("get_installation", [0.5, 0.25])
    desk.answer("get_tcp_pose_command", POSE)
    desk.answer("get_tcp_speed_command", TOOL)
    desk.answer("get_simulation_state", True)
    desk.answer("clear_error_message", None)
    desk.answer("enable_laser_track", 1001)
    desk.answer("disable_laser_track", 4)
    desk.answer("reset_laser_track", 0)
    async with aioduco.connect(desk.host, desk.port) as robot:
        assert await robot.frames.get_base() == aioduco.Pose(*POSE)
        assert await robot.settings.get_home_pose() == aioduco.Joints(*HOME)
        assert await robot.settings.get_installation() == (0.5, 0.25)
        assert await robot.state.get_tcp_pose_command() == aioduco.Pose(*POSE)
        assert (await robot.state.get_tcp_speed_command()).tolist() == TOOL
        assert await robot.settings.get_simulation_state() is True
        await robot.state.clear_error_message()
        assert await robot.compound.enable_laser_track() == 1001
        await robot.compound.disable_laser_track()
        await robot.compound.reset_laser_track()
    for name in idl.functions().newer:
        (call,) = desk.received(name)
        assert call.args == ()


async def test_a_laser_that_is_not_there(desk: Desk) -> None:
    desk.answer("enable_laser_track", -1)
    desk.answer("disable_laser_track", 7)
    async with aioduco.connect(desk.host, desk.port) as robot:
        with pytest.raises(aioduco.Refused):
            await robot.compound.enable_laser_track()
        with pytest.raises(aioduco.TaskIllegal):
            await robot.compound.disable_laser_track()


def test_a_field_of_another_type_is_passed_over() -> None:
    """In a struct; an answer of another type as a whole is none."""
    spec = {1: (TType.STRING, "scheme_name", False), 2: (TType.STRING, "status", False)}
    kind: Any = type("Strange", (), {"thrift_spec": spec})
    strange = kind()
    strange.scheme_name, strange.status = "rail", "on"
    assert body("get_eaxis_info", [strange]) == [rpc.EAxissInfo("rail", 0, 0.0)]
