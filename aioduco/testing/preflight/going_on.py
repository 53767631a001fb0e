"""Go on past a motion that cannot be carried out, so that one run finds the next mistakes, too.

The motion is a finding, and for the program it succeeds: as if the arm had got there. One that the
controller cannot plan is replaced by a joint motion to its end, or to the last point before it that
the arm reaches. A motion from such a point has another path than on a real arm: it is a finding
only if its own end is out of reach. Contacts on both ways are not findings. A motion that leaves
the envelope is carried out.

A program that handles the error gets it, as with a real arm. So does one that uses the vendor's
class, whose functions return the state of a motion.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from aioduco.errors import TaskFailed, TaskParameterMismatch, Unreachable
from aioduco.sim.handlers.paths import DEFAULT_JOINT_ACCELERATION
from aioduco.sim.planner.path import PlanError
from aioduco.sim.planner.segments import Segment, joint_move
from aioduco.testing.preflight.handlers import handled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.sim.controller.motion_queue import Plan
    from aioduco.testing.preflight.run_recorder import ProgramCall

    Vector = NDArray[np.float64]


GOES_ON = "the run goes on as if the arm had got there"
"""What a finding says of a motion that counts as carried out."""

#: shares of a motion's way at which the last point that the arm reaches is looked for
_STEPS = 200
_SAME = 1e-6  # joints that differ by less are the same [rad]
_PART_OF_THE_WAY = "the run goes on from the last point that the arm reaches"


def last_reachable(arm: Arm, start: Vector, error: PlanError) -> tuple[Vector, bool] | None:
    """Where the arm is after a motion that cannot be planned.

    Args:
        arm: the arm.
        start: joints at which the motion begins [rad]. Shape (6,).
        error: why it cannot be planned.

    Returns:
        Joints at its end, or at the last point before it that the arm reaches [rad], shape (6,);
        and whether that is its end. None if it is not known where the motion leads.
    """
    if error.joints is not None:
        inside = np.clip(error.joints, arm.lower, arm.upper)
        return inside, bool(np.array_equal(inside, error.joints))
    if error.flange is None:
        return None
    for step in range(_STEPS, 0, -1):
        try:
            return arm.ikine(error.flange(step / _STEPS), start), step == _STEPS
        except Unreachable:
            continue
    return start, False


class MotionPlans:
    """Plans motions, and others in place of those that cannot be planned."""

    def __init__(self) -> None:
        #: the last point of the motion that was broken off last: joints [rad]
        self._broken_off: Vector | None = None

    def plan(self, record: ProgramCall, arm: Arm, plan: Plan, start: Vector) -> Segment:
        """Plan a motion from a start [rad], or another one to its end.

        Raises:
            PlanError: it cannot be planned, and the run cannot go on past it.
        """
        off = self._broken_off
        record.elsewhere = off is not None and bool(np.abs(start - off).max() < _SAME)
        try:
            return plan(start)
        except PlanError as error:
            kind = TaskParameterMismatch if error.code == "parameter" else TaskFailed
            goal = None if handled(record.waiting, kind) else last_reachable(arm, start, error)
            if goal is None:
                raise
            end, whole = goal
            record.replaced = True
            if not (whole and record.elsewhere):
                record.impossible = f"{error}; {GOES_ON if whole else _PART_OF_THE_WAY}"
            if not whole:
                self._broken_off = end
            return joint_move(arm, start, end, min(arm.velocity), DEFAULT_JOINT_ACCELERATION)
