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

import sys
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.envelope.ways import WAYS
from aioduco.errors import EnvelopeViolated, TaskFailed, TaskParameterMismatch, Unreachable
from aioduco.sim.controller.monitoring import CollisionDetector
from aioduco.sim.handlers.paths import DEFAULT_JOINT_ACCELERATION, PathSection
from aioduco.sim.planner.path import PlanError
from aioduco.sim.planner.segments import joint_move
from aioduco.supervision.command import MotionCommand
from aioduco.supervision.envelope_keeper import EnvelopeKeeper
from aioduco.supervision.envelope_watch import EnvelopeWatch
from aioduco.sync._tasks import MotionCommand as BlockingMotionCommand
from aioduco.testing.preflight import lines
from aioduco.testing.preflight.handlers import handled
from aioduco.testing.preflight.run_recorder import CHECKED, CheckedMotion

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.sim.controller.motion_queue import Plan
    from aioduco.sim.planner.segments import Segment
    from aioduco.testing.preflight.run_recorder import ProgramCall, RunRecorder

    Vector = NDArray[np.float64]

__all__ = ["install", "last_reachable"]

#: shares of a motion's way at which the last point that the arm reaches is looked for
_STEPS = 200
_SAME = 1e-6  # joints that differ by less are the same [rad]
_TO_ITS_END = "the run goes on as if the arm had got there"
_PART_OF_THE_WAY = "the run goes on from the last point that the arm reaches"


def install(recorder: RunRecorder, served: Callable[[], ProgramCall | None]) -> None:
    """Replace the functions that refuse a motion, for the rest of this process.

    Args:
        recorder: records the calls.
        served: returns the call that the simulator answers on this thread.
    """
    _plans(served)
    _contacts(recorder)
    _envelopes()
    _starts()


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


def _plans(served: Callable[[], ProgramCall | None]) -> None:
    """Plan another motion in place of one that cannot be planned."""
    section: Any = PathSection
    motion = section._motion
    passed = _Passed()

    def passing(
        self: Any, name: str, plan: Callable[[], Plan], op: Any, block: bool, **options: Any
    ) -> int:
        record = served()
        # external axes would have to be placed, too
        if record is None or record.where is None or record.of_vendor or name.endswith("_eaxis"):
            return int(motion(self, name, plan, op, block, **options))
        arm = self._arm

        def planned() -> Plan:
            made = plan()
            return lambda start: passed.plan(record, arm, made, start)

        return int(motion(self, name, planned, op, block, **options))

    section._motion = passing


class _Passed:
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
                record.impossible = f"{error}; {_TO_ITS_END if whole else _PART_OF_THE_WAY}"
            if not whole:
                self._broken_off = end
            return joint_move(arm, start, end, min(arm.velocity), DEFAULT_JOINT_ACCELERATION)


def _contacts(recorder: RunRecorder) -> None:
    """Detect no collision on the way of a motion that replaces another."""
    detector: Any = CollisionDetector
    update = detector.update

    def updated(self: Any, time: float, external: Vector) -> int:
        joint = int(update(self, time, external))
        return 0 if joint and recorder.passing_over else joint

    detector.update = updated


def _envelopes() -> None:
    """Send what the envelope refuses, and note what it slows down."""
    keeper: Any = EnvelopeKeeper
    watch: Any = EnvelopeWatch
    check, refuse, slower, stop = keeper.check, keeper._refuse, keeper._slower, watch._stop
    #: watches of robots with a motion that was sent although it leaves the envelope
    passed: set[int] = set()

    async def checked(self: Any, command: Any) -> Any:
        CHECKED.set(CheckedMotion(command.name))
        return await check(self, command)

    async def refused(self: Any, name: str, found: Any, *why: str) -> None:
        origin, motion = lines.current(), CHECKED.get()
        known = motion is not None and motion.name == name and name in WAYS
        if origin is None or not known or handled(origin.waiting, EnvelopeViolated):
            await refuse(self, name, found, *why)
        elif motion is not None:
            motion.impossible = f"it would lead beyond the envelope: {found}; {_TO_ITS_END}"
            passed.add(id(self._watch))

    async def slowed(self: Any, command: Any, share: float) -> Any:
        slow = await slower(self, command, share)
        if (motion := CHECKED.get()) is not None:
            motion.slowed *= share
        return slow

    async def stopped(self: Any, found: Any, fastest: float) -> None:
        # Only what was checked before it was sent has been found, and may go on.
        if id(self) not in passed or self.unchecked:
            await stop(self, found, fastest)

    keeper.check, keeper._refuse, keeper._slower = checked, refused, slowed
    watch._stop = stopped


def _starts() -> None:
    """Note for motions that the program starts that it waits for them by another line."""
    motion: Any = MotionCommand
    blocking: Any = BlockingMotionCommand
    start, start_blocking = motion.start, blocking.start

    def started(self: Any, **options: Any) -> Any:
        if not lines.is_program(sys._getframe(1).f_code.co_filename):
            return start(self, **options)

        async def run() -> Any:
            token = lines.LATER.set(True)
            try:
                return await start(self, **options)
            finally:
                lines.LATER.reset(token)

        return run()

    def started_blocking(self: Any, **options: Any) -> Any:
        token = lines.LATER.set(True)
        try:
            return start_blocking(self, **options)
        finally:
            lines.LATER.reset(token)

    motion.start, blocking.start = started, started_blocking
