"""Errors and warnings for code that means something else than it says: async and sync."""

from __future__ import annotations

import asyncio
import contextlib
import inspect
import io
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from for_each import for_each

import aioduco
import aioduco.sync
from aioduco import MotionCarriedOut, Op, Outcome, ParameterError, UnitWarning, output
from aioduco.devices.grippers import DigitalGripper, Robotiq, VacuumGripper
from aioduco.devices.teleoperation import teleoperate
from aioduco.kinematics import arm, models
from aioduco.models.rules import FARTHEST, LONGEST_ARM
from aioduco.recording.playback import play, run_waypoints
from aioduco.testing import eventually_async
from client.bench import HOME, POSE, Bench


@pytest.fixture
def waiting(bench: Bench) -> Iterator[aioduco.sync.Robot]:
    with aioduco.sync.connect(bench.host, bench.port) as robot:
        yield robot


def helped(thing: object) -> str:
    """What `help` prints."""
    with contextlib.redirect_stdout(io.StringIO()) as text:
        help(thing)
    return text.getvalue()


# -- run ---------------------------------------------------------------------------------------


def test_a_motion_that_was_carried_out_before_run(
    waiting: aioduco.sync.Robot, bench: Bench
) -> None:
    movel: Any = waiting.motion.movel
    for given in ([movel(POSE, v=0.2, a=0.5)], [[movel(POSE, v=0.2, a=0.5)]]):
        with pytest.raises(MotionCarriedOut, match=r"the arm has moved.*movel\.prepare") as raised:
            waiting.motion.run(*given)
        assert raised.value.outcome is Outcome.FINISHED
        assert "; nothing was sent" not in str(raised.value)
    assert len(bench.received("movel")) == 2


async def test_so_with_an_await_too_many(robot: aioduco.Robot, bench: Bench) -> None:
    given: Any = await robot.motion.movel(POSE, v=0.2, a=0.5)
    with pytest.raises(MotionCarriedOut, match="Leave out the `await`"):
        await robot.motion.run(given)


async def test_a_list_of_motions(robot: aioduco.Robot, bench: Bench) -> None:
    legs: Any = [robot.motion.movel(POSE, v=0.2, a=0.5) for _ in range(2)]
    with pytest.raises(ParameterError, match=r"run\(\*motions\); nothing was sent"):
        await robot.motion.run(legs)
    assert bench.commands == []


# -- tasks and waiting -------------------------------------------------------------------------


async def test_create_task_of_a_motion_says_what_to_write(
    robot: aioduco.Robot, bench: Bench
) -> None:
    motion: Any = robot.motion.movel(POSE, v=0.2, a=0.5)
    with pytest.raises(TypeError, match=r"not sent; await it, or `task = await motion\.start\(\)`"):
        asyncio.create_task(motion)  # noqa: RUF006  # it is refused
    assert bench.commands == []
    # the recipe
    task = await motion.start()
    assert await task is Outcome.FINISHED
    assert "not sent" not in repr(motion)


async def test_the_representation_of_a_motion_leaves_out_what_is_empty(
    robot: aioduco.Robot,
) -> None:
    op = Op.at_start(output(3))
    for motion, said in (
        (robot.motion.movej2(HOME, v=1.0, a=2.0), "<movej2([0, 0, 1.5, 0, -1.5, 0], v=1, a=2): "),
        (
            robot.motion.movel(POSE, v=0.2, a=0.5, r=0.01, tool="gun", op=op),
            (
                "<movel([0.5, 0.1, 0.6, 3.1, 0, -1.5], v=0.2, a=0.5, r=0.01, tool='gun', "
                "op=Op(time_or_dist_1=1, trig_io_1=3, trig_value_1=True)): "
            ),
        ),
    ):
        assert repr(motion).startswith(said)
        motion.mark_used()


async def test_what_was_waited_for_and_what_was_seen(robot: aioduco.Robot, bench: Bench) -> None:
    def pressed(_sample: object) -> bool:
        return False

    with pytest.raises(TimeoutError) as raised:
        await robot.wait_for(pressed, timeout=0.5)
    said = str(raised.value)
    assert "waited 0.5 s for" in said
    assert f"pressed ({__file__}:" in said
    assert "it held for none of" in said
    assert "RobotStates(" in said
    failures = robot.feed.statistics().failures
    bench.answer("get_robot_state", ConnectionError("gone"))
    # A sample that was under way may come yet.
    await eventually_async(lambda: robot.feed.statistics().failures > failures)
    with pytest.raises(TimeoutError, match="no sample of the state came"):
        await robot.wait_for(pressed, timeout=0.05)


def test_time_outs_in_sync_say_what_did_not_come(waiting: aioduco.sync.Robot, bench: Bench) -> None:
    with pytest.raises(TimeoutError, match="waited"):
        waiting.wait_for(lambda _: False, timeout=0.05)
    with waiting.events.subscribe() as events, pytest.raises(TimeoutError, match=r"within 0\.01 s"):
        events.next(timeout=0.01)
    bench.motion_time = 30.0
    task = waiting.motion.movej2.start(HOME, v=1.0, a=1.0)
    with pytest.raises(TimeoutError, match=r"movej2.*has not ended within 0\.01 s: it goes on"):
        task.wait(timeout=0.01)


# -- units -------------------------------------------------------------------------------------


async def test_a_speed_in_percent_that_reads_like_rad_per_second(
    robot: aioduco.Robot, bench: Bench
) -> None:
    for speed in (1.0, 0.5, 3.9):
        with pytest.warns(UnitWarning, match="not rad/s: movej2") as caught:
            robot.motion.movej(HOME, v=speed, a=50).mark_used()
        assert caught[0].filename == __file__
    with pytest.warns(UnitWarning, match="v=1.0 is 1 %"):
        robot.motion.movej_pose(POSE, v=1.0, a=50).mark_used()
    for sure in (1, 3, 4.0, 50.0):
        robot.motion.movej(HOME, v=sure, a=1.0).mark_used()


def test_it_is_shown_once_and_names_the_line_in_sync_too(waiting: aioduco.sync.Robot) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        for _ in range(3):
            waiting.motion.movej.prepare(HOME, v=1.0, a=50).awaitable.mark_used()
    assert [(one.category, one.filename) for one in caught] == [(UnitWarning, __file__)]


async def test_millimetres_are_refused(robot: aioduco.Robot, bench: Bench) -> None:
    motion = robot.motion
    for refused in (
        lambda: motion.movel([492, 140, 442, 3.14, 0, 0], v=0.2, a=0.5),
        lambda: motion.movel([0.4, -30.0, 0.4, 3.14, 0, 0], v=0.2, a=0.5),
        lambda: motion.movel(POSE, v=0.2, a=0.5, r=20),
        lambda: motion.movej2(HOME, v=1.0, a=1.0, r=20),
        lambda: motion.movec(POSE, [600, *POSE[1:]], v=0.2, a=0.5),
        lambda: motion.move_spiral(POSE, None, rev=2, length=50, radius=0.1, mode=0, v=0.2, a=0.5),
        lambda: motion.move_spiral(
            POSE, None, rev=2, length=0.05, radius=100, mode=0, v=0.2, a=0.5
        ),
        lambda: robot.servo.pose(v=1.0, a=1.0)._check("point", [492, 140, 442, 3.14, 0, 0]),
    ):
        with pytest.raises(ParameterError, match=r"m \(millimetres\?\); nothing was sent"):
            refused()
    high, near = [0, 0, 300, 0, 0, 0], [0, 0, 0.01, 0, 0, 0]
    for sent in (
        robot.frames.set_load_data([2.0, 0, 0, 50]),
        robot.frames.set_tool_data("grip", [0, 0, 0.12, 0, 0, 0], [0.8, 0, 0, 50]),
        robot.frames.set_tool_data("grip", [0, 0, 12, 0, 0, 0], [0.8, 0, 0, 0.05]),
        robot.compound.combine_motion_config(2, 0, 2.0, 3.0),
        robot.force.fc_wait_pos(high, near, absolute=True, duration=0.1, timeout=10),
    ):
        with pytest.raises(ParameterError, match=r"m \(millimetres\?\); nothing was sent"):
            await sent
    motion.movel([FARTHEST, 0, 0.4, 3.14, 0, 0], v=0.2, a=0.5, r=LONGEST_ARM).mark_used()
    assert bench.commands == []


def test_the_limit_is_that_of_the_longest_arm() -> None:
    stretched = [
        sum(abs(each) for each in (g.d1, g.d2, g.a2, g.a3, g.d5, g.d6))
        for g in (arm(model).geometry for model in models())
    ]
    assert max(stretched) <= LONGEST_ARM < max(stretched) + 0.01
    assert pytest.approx(8 * LONGEST_ARM, rel=0.01) == FARTHEST


# -- with, await, help -------------------------------------------------------------------------


async def test_a_robot_that_is_opened_in_the_wrong_way() -> None:
    awaited: Any = aioduco.connect("nowhere")
    waiting: Any = aioduco.sync.connect("nowhere")
    with pytest.raises(TypeError, match=r"write `async with aioduco\.connect"), awaited:
        raise AssertionError("entered")
    with pytest.raises(TypeError, match=r"await robot\.open\(\)"):
        await awaited
    with pytest.raises(TypeError, match=r"write `with aioduco\.sync\.connect"):
        async with waiting:
            raise AssertionError("entered")


_NONE: Any = None
#: what takes a robot, by its name in a program that awaits, and in one that does not
_TAKING: dict[str, tuple[Callable[[Any], Any], Callable[[Any], Any]]] = {
    "gripper at the tool": (Robotiq.at_tool, lambda r: aioduco.sync.Gripper(r, Robotiq.at_tool)),
    "gripper on outputs": (
        lambda r: DigitalGripper(r, close=1),
        lambda r: aioduco.sync.Gripper(r, DigitalGripper, close=1),
    ),
    "suction cup": (
        lambda r: VacuumGripper(r, suction=1),
        lambda r: aioduco.sync.Gripper(r, VacuumGripper, suction=1),
    ),
    "teleoperation": (
        lambda r: teleoperate(r, _NONE),
        lambda r: aioduco.sync.teleoperate(r, _NONE),
    ),
    "recorded path": (lambda r: play(r, _NONE), lambda r: aioduco.sync.play(r, _NONE)),
    "waypoints": (
        lambda r: run_waypoints(r, _NONE),
        lambda r: aioduco.sync.run_waypoints(r, _NONE),
    ),
}


@for_each("taking", _TAKING)
async def test_a_robot_of_the_other_kind(
    taking: str, robot: aioduco.Robot, waiting: aioduco.sync.Robot, bench: Bench
) -> None:
    with_await, without = _TAKING[taking]
    wrong = (TypeError, ParameterError)
    with pytest.raises(wrong, match=r"aioduco\.sync\.\w+\(robot"):
        await with_await(waiting)
    with pytest.raises(TypeError, match=r"`aioduco\.sync\.connect` made"):
        without(robot)
    assert bench.commands == []


@for_each("heartbeat", [1.0, None])
async def test_a_motion_of_a_robot_that_was_never_opened(heartbeat: float | None) -> None:
    robot = aioduco.connect("nowhere", heartbeat=heartbeat)
    motion = robot.motion.movej2([0.0] * 6, v=1.0, a=1.0)
    with pytest.raises(aioduco.RobotStateError, match="robot is not open; use it inside"):
        await motion.start()
    with pytest.raises(aioduco.RobotStateError, match="robot is not open; use it inside"):
        await robot.motion.movej2([0.0] * 6, v=1.0, a=1.0)


def test_help_of_a_task_shows_what_programs_use() -> None:
    for task in (aioduco.Task, aioduco.sync.Task):
        text = helped(task)
        assert " wait(" in text
        for internal in ("on_wait_cancelled", "_finish", "observed", "begins_at"):
            assert internal not in text


def test_help_of_sync_motions_shows_how_they_are_called(waiting: aioduco.sync.Robot) -> None:
    for movej2 in (waiting.motion.movej2, type(waiting.motion).movej2):
        text = helped(movej2)
        assert "movej2(" in text.splitlines()[2]
        # a line, or from Python 3.13 on a line for each parameter
        plain = " ".join(text.split()).replace("'", "")  # up to Python 3.13 types are quoted
        assert "joints: JointsLike, v: Real, a: Real" in plain
        assert "-> Outcome" in plain
        assert "关节运动" in text
        assert inspect.signature(movej2).return_annotation == "Outcome"
    assert repr(waiting.motion.movej2) == "<motion movej2>"
    section = " ".join(helped(type(waiting.motion)).replace("|", " ").split()).replace("( ", "(")
    assert "movel(self, pose: PoseLike" in section.replace("'", "")
    assert "set_blend_ahead(" in section
