"""Findings of a twin about an arm that differs in one thing, in simulated time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any, Literal

import numpy as np
import pytest
from for_each import for_each

from aioduco.kinematics import arm as arm_of
from aioduco.kinematics.mounting import base_in_world, gravity
from aioduco.models.enums import RobotState, SafetyState
from aioduco.models.pose import Pose
from aioduco.sim.twin.data import Cause, Divergence, Quantity, TwinCommand
from aioduco.sim.twin.limits import TwinLimits, deviations, learn
from aioduco.sim.twin.monitor import TwinMonitor
from aioduco.sim.twin.predictor import Timeline

from .arms import ARM, NOWHERE, READY, PerfectArm, movej2, work

THERE = (0.6, 0.2, 1.3, 0.2, -1.3, 0.3)
EFFORT = np.array(ARM.effort)
NARROW = TwinLimits(
    arm="gcr5_910",
    mass=0.15,
    force=3.0,
    friction=0.12,
    torque=tuple((0.01 * EFFORT).tolist()),
    tracking=(1e-3,) * 6,
    position=3e-4,
    angle=6e-4,
    path=3e-3,
    delay=0.03,
    usual_delay=0.03,
    dry=tuple((0.03 * EFFORT).tolist()),
    noise=tuple((0.002 * EFFORT).tolist()),
    learned=60.0,
)


def rubbed() -> PerfectArm:
    """An arm in good order."""
    arm = PerfectArm()
    arm.torques = rubbing()
    return arm


def monitor(*, commands: bool = True, mounting: Pose | None = None) -> TwinMonitor:
    return TwinMonitor(ARM, NARROW, tool=NOWHERE, mounting=mounting, commands=commands)


def said(watching: TwinMonitor, items: Iterable[Any]) -> list[Divergence]:
    found: list[Divergence] = []
    for item in items:
        if isinstance(item, TwinCommand):
            watching.command(item)
        else:
            found += watching.sample(item)
    return found


def rubbing(*, more: float = 0.0, at: float = 0.0) -> Callable[..., np.ndarray]:
    """Torques of the normal friction, and from some time on of more."""

    def torques(_q: np.ndarray, qd: np.ndarray, time: float) -> np.ndarray:
        now = 1.0 + (more if time > at else 0.0)
        return -now * 0.03 * EFFORT * np.clip(qd / 0.02, -1.0, 1.0)

    return torques


def pushed(force: tuple[float, float, float], at: float = 1.0) -> Callable[..., np.ndarray]:
    """Torques of the normal friction, and of a force from some time on."""
    normal = rubbing()

    def torques(q: np.ndarray, qd: np.ndarray, time: float) -> np.ndarray:
        lever = ARM.jacobian(q)[:3].T
        return normal(q, qd, time) + (lever @ np.array(force) if time > at else 0.0)

    return torques


def test_an_arm_in_good_order_is_left_alone() -> None:
    arm, watching = rubbed(), monitor()
    assert said(watching, work(arm, movej2(*THERE), movej2(*READY))) == []
    figures = watching.figures
    assert not figures.blind
    assert figures.path == pytest.approx(0.0, abs=1e-3)
    assert figures.mass == pytest.approx(0.0, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("torques", "cause"),
    [
        (pushed((0.0, 0.0, -4.9)), Cause.PAYLOAD),
        (pushed((8.0, 6.0, 0.0)), Cause.CONTACT),
        (pushed((0.0, 0.0, 8.0)), Cause.CONTACT),
        (rubbing(more=0.3, at=1.0), Cause.FRICTION),
    ],
)
def test_torques_have_a_cause(torques: Any, cause: Cause) -> None:
    arm = PerfectArm()
    arm.torques = torques
    found = said(monitor(), work(arm, movej2(*THERE), movej2(*READY)))
    assert found
    assert {each.quantity for each in found} == {Quantity.TORQUE}
    assert found[0].cause is cause, str(found[0])
    assert found[0].since > 0.9
    assert found[0].at - found[0].since < 0.5


@pytest.mark.parametrize("mounting", ["wall", "ceiling"])
def test_a_payload_hangs_down_wherever_the_arm_is_mounted(
    mounting: Literal["wall", "ceiling"],
) -> None:
    arm = PerfectArm()
    x, y, z = (0.5 * gravity(mounting)).tolist()
    arm.torques = pushed((x, y, z), at=0.5)
    arm.changes["pose"] = None
    found = said(monitor(mounting=base_in_world(mounting, ARM)), work(arm, movej2(*THERE)))
    assert {each.cause for each in found} == {Cause.PAYLOAD}
    assert found[0].estimate["mass [kg]"] == pytest.approx(0.5, abs=0.15)


@pytest.mark.slow
def test_a_part_is_lost_only_if_one_was_carried() -> None:
    arm = PerfectArm()
    arm.torques = pushed((0.0, 0.0, 4.9), at=0.5)
    load = "set_load_data", ([0.5, 0.0, 0.0, 0.0],)
    found = said(monitor(), work(arm, load, movej2(*THERE), movej2(*READY)))
    assert [each.cause for each in found] == [Cause.LOST_PART]
    assert found[0].estimate["mass [kg]"] == pytest.approx(-0.5, abs=0.15)


def test_a_longer_link_shows_at_once() -> None:
    arm = rubbed()
    arm.geometry = arm_of("gcr5_910", a2=0.426)
    found = said(monitor(), work(arm, movej2(*THERE)))
    assert [(each.quantity, each.cause) for each in found] == [(Quantity.GEOMETRY, Cause.GEOMETRY)]
    assert found[0].value == pytest.approx(1e-3, rel=0.05)


def test_a_late_controller_is_named() -> None:
    arm = rubbed()
    arm.late = 0.15
    found = said(monitor(), work(arm, movej2(*THERE)))
    assert [(each.quantity, each.cause) for each in found] == [
        (Quantity.DELAY, Cause.DELAYED_CONTROLLER)
    ]


@pytest.mark.slow
def test_another_program_is_named() -> None:
    arm, watching = rubbed(), monitor()
    assert said(watching, work(arm, movej2(*THERE))) == []
    arm.another(*movej2(*READY))
    found = said(watching, work(arm))
    assert {each.cause for each in found} == {Cause.OTHER_PROGRAM}
    assert said(watching, work(arm, movej2(*THERE))) == [], "it is beside the arm again"
    assert not watching.figures.blind


def test_without_the_commands_nothing_is_said_about_programs() -> None:
    arm, watching = rubbed(), monitor(commands=False)
    arm.another(*movej2(*THERE))
    assert said(watching, work(arm)) == []
    assert watching.figures.path is None


@pytest.mark.slow
def test_a_stop_of_this_program_is_no_divergence() -> None:
    arm, watching = rubbed(), monitor()
    assert said(watching, work(arm, movej2(*THERE))) == []
    before = arm.send(*movej2(*READY))
    items: list[Any] = [before]
    items += [arm.sample() for _ in range(40)]
    watching_stop = arm.send("stop", (False,))
    assert said(watching, [*items, watching_stop]) == []
    assert watching.figures.path is not None
    assert said(watching, work(arm, movej2(*THERE))) == []
    assert not watching.figures.blind


def test_a_stream_is_not_judged_by_its_path() -> None:
    arm, watching = rubbed(), monitor()
    arm.changes["led"] = True
    arm.another(*movej2(*THERE))
    assert said(watching, work(arm)) == []
    assert "stream" in watching.figures.blind


@for_each(
    "function, accepted",
    [("speedj", True), ("teach_mode", True), ("speedj", None), ("movej2", None), ("resume", True)],
)
def test_a_motion_that_is_not_rehearsed_is_still_this_programs(
    function: str, accepted: bool | None
) -> None:
    """The rehearsal began again before the arm moved, as if nothing had been commanded."""
    arm, watching, line = rubbed(), monitor(), Timeline()
    assert said(watching, work(arm)) == []
    _, arguments = movej2(*THERE)
    for _ in range(12):
        line.put(arm.sample())
    line.put(TwinCommand(arm.time, function, arguments, accepted))
    arm.another("movej2", arguments)
    line.put(arm.sample())
    while not arm.stands:
        line.put(arm.sample())
    assert said(watching, line.rest()) == []
    assert said(watching, work(arm)) == []
    assert not watching.figures.blind


def test_a_collision_is_a_contact() -> None:
    arm, watching = rubbed(), monitor()
    assert said(watching, work(arm)) == []
    arm.changes |= {"collision": 3, "safety": int(SafetyState.STOP1)}
    found = said(watching, work(arm))
    assert [(each.quantity, each.cause) for each in found] == [(Quantity.STATE, Cause.CONTACT)]
    assert "joint 3" in found[0].where


@pytest.mark.parametrize("ours", [True, False])
def test_power_off_is_somebody_elses_unless_this_program_asked(ours: bool) -> None:
    arm, watching = PerfectArm(), monitor()
    assert said(watching, work(arm)) == []
    if ours:
        watching.command(TwinCommand(arm.time, "power_off", (False,), True))
    arm.changes["robot"] = int(RobotState.POWER_OFF)
    found = said(watching, work(arm))
    assert [each.cause for each in found] == ([] if ours else [Cause.OTHER_PROGRAM])


@for_each(
    "error, answer, refused",
    [
        ("ControllerError", None, True),
        ("", -1, True),
        ("OutcomeUnknown", None, False),  # perhaps the arm moves, until the robot stops it
        ("NotSent", None, False),
    ],
)
def test_what_the_controller_refuses_and_the_twin_accepts_is_an_outcome(
    error: str, answer: int | None, refused: bool
) -> None:
    arm, watching = PerfectArm(), monitor()
    assert said(watching, work(arm)) == []
    watching.command(TwinCommand.of(arm.time, *movej2(*THERE), error, answer))
    found = said(watching, work(arm))
    assert [each.quantity for each in found] == [Quantity.OUTCOME] * refused


@pytest.mark.slow
def test_a_short_disturbance_is_nothing() -> None:
    arm = PerfectArm()
    normal, push = rubbing(), pushed((0.0, 10.0, 0.0), at=0.0)
    arm.torques = lambda q, qd, t: (push if 1.0 < t < 1.02 else normal)(q, qd, t)
    assert said(monitor(), work(arm, movej2(*THERE), movej2(*READY))) == []


@pytest.mark.slow
@for_each("part", ["joints", "speeds", "expected", "expected_speeds", "pose", "external"])
def test_a_sample_in_which_a_number_is_missing_hides_none_of_the_later_ones(part: str) -> None:
    """After one the twin said no more about torques, with figures that were no numbers."""
    arm, watching = PerfectArm(), monitor()
    arm.torques = pushed((0.0, 0.0, -4.9), at=0.3)
    items = list(work(arm, movej2(*THERE)))
    number = math.inf if part == "external" else math.nan  # a torque may be unknown, as NaN
    items[5] = items[5]._replace(**{part: (number,) * 6})
    found = said(watching, items)
    assert [each.cause for each in found] == [Cause.PAYLOAD]
    assert learn(ARM, deviations(ARM, items * 5, NOWHERE)).learned > 0.0


@pytest.mark.slow
def test_a_divergence_is_said_once() -> None:
    arm = PerfectArm()
    arm.torques = pushed((0.0, 8.0, 0.0))
    found = said(monitor(), work(arm, *[movej2(*THERE), movej2(*READY)] * 2))
    assert len(found) == 1
