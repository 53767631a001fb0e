"""One run finds all mistakes: it goes on past a motion that cannot be carried out."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_runner import CliRunner

import aioduco
from aioduco.cli.app import app
from aioduco.errors import EnvelopeViolated, TaskFailed
from aioduco.kinematics import arm as arm_of
from aioduco.sim.planner.path import PlanError
from aioduco.sim.planner.segments import joint_move, line_move
from aioduco.testing.preflight import PreflightReport
from aioduco.testing.preflight.going_on import last_reachable
from aioduco.testing.preflight.handlers import WaitingLine, handled

from .trying import tried

ARM = arm_of("gcr5_910")
READY = np.array((0.0, 0.0, np.pi / 2, 0.0, -np.pi / 2, 0.0))


def told(folder: Path, text: str) -> tuple[dict[str, Any], str]:
    """What the command writes, and what it shows."""
    path, result = folder / "program.py", folder / "result.json"
    path.write_text(text, encoding="utf-8")
    command = ["preflight", str(path), "--quiet", "--json", str(result)]
    done = CliRunner().invoke(app, command, env={"COLUMNS": "160"})
    return json.loads(result.read_text("utf-8")), done.output


def motions_of(report: dict[str, Any]) -> list[dict[str, Any]]:
    return [call for call in report["calls"] if call["task"] is not None and call["where"]]


def lines_of(report: PreflightReport) -> list[tuple[int, str]]:
    return [(finding.line, finding.kind) for finding in report.findings]


FAR = "(5.0, 0.0, 0.5, 3.14, 0.0, 0.0), v=1.0, a=2.0"
MANY = f"""
import asyncio
import aioduco
from aioduco import Joints

HOME = Joints.deg(0, -15, 105, 0, -90, 0)

async def main():
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        await robot.motion.movel({FAR})
        await robot.motion.movej2(HOME, v=3.0, a=6.0)
        await robot.motion.movej_pose2((0.0, -4.0, 0.3, 3.14, 0.0, 0.0), v=3.0, a=6.0)
        await robot.motion.movej2(HOME, v=3.0, a=6.0)
        here = aioduco.Pose.of(await robot.state.get_tcp_pose())
        await robot.motion.run(
            robot.motion.movel(here.shifted(z=0.05), v=0.5, a=2.0, r=0.01),
            robot.motion.movel(here.shifted(x=2.0), v=0.5, a=2.0, r=0.01),
            robot.motion.movel(here, v=0.5, a=2.0),
        )
        try:
            await robot.motion.movel({FAR})
        except aioduco.TaskFailed:
            print("handled")
        q = await robot.state.get_actual_joints_position()
        assert max(abs(a - b) for a, b in zip(q, HOME)) > 0.0
        print("over")

asyncio.run(main())
"""


@pytest.mark.slow
def test_one_run_finds_all_motions_that_cannot_be_carried_out(tmp_path: Path) -> None:
    report, shown = told(tmp_path, MANY)
    found = [(each["line"], each["kind"]) for each in report["findings"]]
    assert found == [(line, "unreachable") for line in (11, 13, 16, 22)]
    assert report["status"] == 0
    assert "from the last point" in report["findings"][0]["text"]
    states = {call["where"]["line"]: call["state"] for call in motions_of(report)}
    assert states[11] == "FINISHED"
    assert states[22] == "ERROR", "a program that handles the error gets it"
    # all of them are told of in the table
    assert shown.count("not possible") == 3
    assert "found: 4 problems" in shown
    assert "\\[" not in shown


BLOCKING = f"""
import aioduco.sync

with aioduco.sync.connect("192.168.1.10") as robot:
    robot.bring_up()
    robot.motion.movel({FAR})
    robot.blocking.movel({FAR})
    task = robot.motion.movel.start({FAR})
    task.wait()
"""


@pytest.mark.slow
def test_a_blocking_program_goes_on_too(tmp_path: Path) -> None:
    report = tried(tmp_path, BLOCKING)
    assert lines_of(report) == [(6, "unreachable"), (7, "unreachable"), (8, "unreachable")]
    assert report.status == 0


LOOP = """
import aioduco.sync

with aioduco.sync.connect("192.168.1.10") as robot:
    robot.bring_up()
    for x in (5.0, 6.0, 6.0, 7.0):
        robot.motion.movel((x, 0.0, 0.5, 3.14, 0.0, 0.0), v=1.0, a=2.0)
"""


@pytest.mark.slow
def test_a_finding_says_how_many_others_its_line_has(tmp_path: Path) -> None:
    """Of the places of a loop only the first was told."""
    (found,) = tried(tmp_path, LOOP).findings
    assert (found.line, found.text.endswith("; and 2 more of this line")) == (7, True), found.text


@pytest.mark.slow
def test_an_error_that_another_line_handles_is_raised_there(tmp_path: Path) -> None:
    ending = (
        "    try:\n        task.wait()\n    except aioduco.DucoError:\n        raise SystemExit(3)"
    )
    report = tried(tmp_path, BLOCKING.replace("    task.wait()", ending))
    assert lines_of(report)[:3] == [(6, "unreachable"), (7, "unreachable"), (8, "unreachable")]
    assert report.status == 3


VENDOR = """
from aioduco.compat import DucoCobot

robot = DucoCobot("192.168.1.10", 7003)
robot.open()
robot.power_on(True)
robot.enable(True)
states = [robot.movel([5.0, 0.0, 0.5, 3.14, 0.0, 0.0], 0.2, 0.5, 0.0, [], "", "", True)]
robot.close()
raise SystemExit(states[0])
"""


@pytest.mark.slow
def test_a_vendors_program_gets_the_state_of_the_motion(tmp_path: Path) -> None:
    report = tried(tmp_path, VENDOR)
    assert (8, "unreachable") in lines_of(report)
    assert report.status == 6, "the state of a task that ended with an error"


KEPT = """
import asyncio
import aioduco
from aioduco.envelope import Envelope, ToolSpeed, Zone

async def main():
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        here = aioduco.Pose.of(await robot.state.get_tcp_pose())
        ceiling = Zone.box((0.0, 0.0, here.z - 0.95), (4.0, 4.0, 2.0), bodies=("tool",), keep="in")
        robot.envelope = Envelope("gcr5_910", ceiling, ToolSpeed(0.2, action="slow"))
        await robot.motion.movel(here.shifted(z=-0.05), v=0.8, a=2.0)
        await robot.motion.movel(here.shifted(z=0.15), v=0.2, a=2.0)
        await robot.motion.movel(here.shifted(z=-0.05), v=0.2, a=2.0)
        try:
            await robot.motion.movel(here.shifted(z=0.2), v=0.2, a=2.0)
        except aioduco.EnvelopeViolated:
            print("seen")

asyncio.run(main())
"""


@pytest.mark.slow
def test_a_motion_beyond_the_envelope_is_gone_past_and_a_slowed_one_said(tmp_path: Path) -> None:
    report, shown = told(tmp_path, KEPT)
    found = [(each["line"], each["kind"]) for each in report["findings"]]
    assert found == [(13, "envelope")], "one that is handled is none"
    slowed = {
        call["where"]["line"]: call["slowed"] for call in motions_of(report) if call["radius"] == 0
    }
    assert slowed[12] == pytest.approx(0.25, rel=0.01)
    assert slowed[13] == slowed[14] == 1.0
    assert "finished, slowed by the envelope to 25%" in shown


# -- where a motion leads ----------------------------------------------------------------------


def failure(make: object) -> PlanError:
    assert callable(make)
    with pytest.raises(PlanError) as caught:
        make()
    return caught.value


def test_the_last_point_of_a_line_that_leaves_the_reach() -> None:
    target = ARM.fkine(READY)
    target[0, 3] += 3.0
    error = failure(lambda: line_move(ARM, READY, target, 0.2, 0.5))
    found = last_reachable(ARM, READY, error)
    assert found is not None
    end, whole = found
    assert not whole
    at, begin = ARM.fkine(end), ARM.fkine(READY)
    assert at[0, 3] > begin[0, 3] + 0.1
    np.testing.assert_allclose(at[1:3, 3], begin[1:3, 3], atol=1e-6)
    further = begin.copy()
    further[0, 3] = at[0, 3] + 0.05
    assert len(ARM.ikine_all(further)) == 0


def test_the_end_of_a_line_through_a_singularity_is_reached() -> None:
    q = np.radians((-2, 67, 75, -24, 12, -31))
    target = ARM.fkine(np.radians((9, 48, 63, 21, -19, -17)))
    error = failure(lambda: line_move(ARM, q, target, 0.1, 0.5))
    found = last_reachable(ARM, q, error)
    assert found is not None
    assert found[1]
    np.testing.assert_allclose(ARM.fkine(found[0]), target, atol=1e-9)


def test_joints_beyond_their_limits_are_set_to_them() -> None:
    beyond = READY.copy()
    beyond[2] = ARM.upper[2] + 1.0
    error = failure(lambda: joint_move(ARM, READY, beyond, 1.0, 1.0))
    found = last_reachable(ARM, READY, error)
    assert found is not None
    assert not found[1]
    assert found[0][2] == ARM.upper[2]


def test_a_motion_without_a_known_way_has_no_end() -> None:
    assert last_reachable(ARM, READY, PlanError("parameter", "three points on a line")) is None


# -- which errors a program handles ------------------------------------------------------------


HANDLERS = """
import contextlib
import aioduco
from aioduco import DucoError as Wrong
def here():
    go()                                # 6
    try:
        go()                            # 8
    except (ValueError, aioduco.TaskFailed):
        go()                            # 10
    else:
        go()                            # 12
    try:
        go()                            # 14
    except Wrong:
        pass
    finally:
        go()                            # 18
    with contextlib.suppress(Wrong):
        go()                            # 20
    with open("file"):
        go()                            # 22
    try:
        go()                            # 24
    except KeyboardInterrupt:
        pass
    try:
        go()                            # 28
    except* Exception:
        pass
    try:
        go()                            # 32
    except choose():
        pass
"""


@pytest.mark.parametrize(
    ("kind", "seen"), [(TaskFailed, {8, 14, 20, 28, 32}), (EnvelopeViolated, {14, 20, 28, 32})]
)
def test_the_handlers_around_a_line(tmp_path: Path, kind: type[Exception], seen: set[int]) -> None:
    path = tmp_path / "handlers.py"
    path.write_text(HANDLERS, encoding="utf-8")
    names = {"contextlib": contextlib, "aioduco": aioduco, "Wrong": aioduco.DucoError}
    found = {
        number for number, line in enumerate(HANDLERS.splitlines(), 1)
        if "go()" in line and handled([WaitingLine(str(path), number, names)], kind)
    }  # fmt: skip
    assert found == seen
    assert handled([WaitingLine(str(path), 6, names, later=True)], kind), "another line may wait"


@pytest.mark.parametrize(
    ("text", "asks"),
    [
        ("await asyncio.gather(first(), second(), return_exceptions=True)", True),
        ("await asyncio.wait(tasks)", False),
        ("await task.wait()", True),
        ("task.wait()", False),
        ("if task.exception() is None: pass", True),
        ("await task", False),
    ],
)
def test_a_program_may_ask_a_task_for_its_error(tmp_path: Path, text: str, asks: bool) -> None:
    path = tmp_path / "asks.py"
    path.write_text(f"async def main():\n    {text}\n", encoding="utf-8")
    assert handled([WaitingLine(str(path), 2, {}, later=True)], TaskFailed) is asks
    assert not handled([WaitingLine(str(path), 2, {})], TaskFailed)


def test_a_library_that_raises_the_error_again_does_not_handle_it(tmp_path: Path) -> None:
    path = tmp_path / "library.py"
    path.write_text("try:\n    go()\nexcept Exception as exc:\n    note(exc)\n    raise\n", "utf-8")
    assert not handled([WaitingLine(str(path), 2, {}, library=True)], TaskFailed)
    assert handled([WaitingLine(str(path), 2, {})], TaskFailed), "a program may act before"


@pytest.mark.slow
def test_where_a_program_waits_endlessly_is_found(tmp_path: Path) -> None:
    report = tried(
        tmp_path,
        """
import asyncio
import aioduco

async def other(never):
    await never.wait()

async def main():
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        never = asyncio.Event()
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(other(never), name="other")
            await robot.feed.wait_for(lambda sample: False)

asyncio.run(main())
""",
    )
    waits = {each.function: each.line for each in report.findings if each.kind == "endless wait"}
    assert waits == {"other": 6, "main": 14}


@pytest.mark.slow
def test_a_program_that_slept_for_long_may_take_its_time_afterwards(tmp_path: Path) -> None:
    report = tried(
        tmp_path,
        """
import select
import time
import aioduco.sync
from aioduco import Joints

with aioduco.sync.connect("192.168.1.10") as robot:
    robot.bring_up()
    time.sleep(1000.0)
    select.select([], [], [], 4.0)  # as of a computation, or of a computer that is busy
    robot.motion.movej2(Joints.deg(0, -15, 105, 0, -90, 0), v=1.0, a=2.0)
""",
    )
    assert report.ok, report.findings


@pytest.mark.slow
def test_when_a_value_came_is_said_in_the_programs_time(tmp_path: Path) -> None:
    report = tried(
        tmp_path,
        """
import asyncio
import time
import aioduco
from aioduco import Joints

async def main():
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        before = time.monotonic()
        await asyncio.sleep(1000.0)
        sample = await robot.feed.latest()
        state = await robot.state.get_robot_state()
        with robot.events.subscribe() as events:
            await robot.feed.latest()
            await robot.motion.movej2(Joints.deg(0, -15, 105, 0, -90, 0), v=1.0, a=2.0)
            event = await anext(events)
        for at in (sample.received_at, sample.io.received_at, state.received_at, event.at):
            assert before + 1000.0 <= at <= time.monotonic(), (before, at)
        assert 0.0 <= sample.age < 900.0  # real time

asyncio.run(main())
""",
    )
    assert report.ok, report.findings
