"""The tasks of force control, and its effects on the queue of motions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.models.enums import TaskState
from aioduco.sim.controller.tasks import MotionPhase, TaskTable
from aioduco.sim.refusal import illegal

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.sim.controller.motion_queue import MotionQueue
    from aioduco.sim.cycle import SensedState
    from aioduco.sim.force.control import ForceControl, ForceOutcome
    from aioduco.sim.planner.path import JointSetPoint


#: the motion without a path of its own, which ends successfully when its conditions hold
FC_MOVE = "fc_move"
#: in hand guiding the set-points follow the arm's position, so an offset would grow without end
_GUIDING = "teach_mode"


class ForceTasks:
    """Force control between the motions and the drives.

    Invariants: without force control the drives get the set-points of the motions; with force
    control a motion that begins at rest is planned from where forces have moved the arm; the arm
    gives way only while a motion runs.

    Args:
        tasks: the table that holds the tasks' states.
        motion: the queue of motions.
        control: reaction of the arm to forces.
        sensed: measurements of the arm at the start.

    Attributes:
        control: reaction of the arm to forces.
        sensed: measurements of the arm in this cycle.
    """

    def __init__(
        self, tasks: TaskTable, motion: MotionQueue, control: ForceControl, sensed: SensedState
    ) -> None:
        self.control: ForceControl = control
        self._tasks = tasks
        self._motion = motion
        self.sensed: SensedState = sensed
        self._closing: list[int] = []
        self._unfelt = 0  # loads that were set, and that the sensor does not feel yet
        self._tares: list[tuple[Sequence[bool], Sequence[float]]] = []  # that wait for them
        self._disturbed = False
        self._alarm = ""

    @property
    def moving(self) -> bool:
        """Whether a force moves the set-points of the drives."""
        return self.control.active and self.control.moving

    # -- commands ----------------------------------------------------------------------------

    def start(self) -> int:
        """Start force control (fc_start)."""
        if self._closing:
            raise illegal("fc_stop is under way")
        if not self.control.active:
            self.control.start(self._motion.setpoint)
        return self._tasks.ended("fc_start", TaskState.FINISHED)

    def stop(self) -> int:
        """End force control (fc_stop) when the arm stands; a running motion is a fault."""
        if not self.control.active:
            return self._tasks.ended("fc_stop", TaskState.FINISHED)
        if self._motion.phase is not MotionPhase.IDLE:
            message = "fc_stop while motions run: the robot is stopped"
            self._motion.faults.append(message)
            self._disturbed = True
            return self._tasks.ended("fc_stop", TaskState.ERROR, message)
        id_ = self._tasks.new("fc_stop")
        self._tasks.set(id_, TaskState.RUNNING)
        self._closing.append(id_)
        return id_

    def combine(self, logic: Sequence[int]) -> int:
        """Combine the conditions, and restart them (fc_wait_logic)."""
        sensed = self.sensed
        self.control.conditions.begin(
            logic, sensed.time, lambda what: self.control.measure(what, sensed)
        )
        return self._tasks.ended("fc_wait_logic", TaskState.FINISHED)

    def tare(self, direction: Sequence[bool], value: Sequence[float]) -> int:
        """Set the present reading of the sensor (fc_force_set_value)."""
        self._tares.append((direction, value))
        self._tare()
        return self._tasks.ended("fc_force_set_value", TaskState.FINISHED)

    def _tare(self) -> None:
        """Set the readings of the sensor, unless it is about to feel another load."""
        if self._unfelt:
            return
        control, sensed = self.control, self.sensed
        for tare in self._tares:
            turn = control.turn(sensed)
            control.sensor = control.sensor.tared(sensed.wrench, turn, *tare)
        self._tares.clear()

    def carry(self, mass: float, centre: Sequence[float]) -> Callable[[], None]:
        """Prepare for a load [kg], with its centre in the flange's frame [m].

        Returns:
            To be called before the first cycle in which the sensor feels the load.
        """
        self._unfelt += 1

        def felt() -> None:
            self._unfelt -= 1
            self.control.sensor = self.control.sensor.carrying(mass, centre)

        return felt

    @property
    def closing(self) -> bool:
        """Whether fc_stop is under way."""
        return bool(self._closing)

    def admit(self) -> tuple[TaskState, str] | None:
        """Prepare for a motion; give its final state and the reason if it is skipped."""
        control = self.control
        if not control.active:
            return None
        verdict = control.conditions.verdict
        if verdict is not None:
            late = verdict == "late"
            why = "timed out" if late else "hold"
            return (
                TaskState.ERROR if late else TaskState.INTERRUPT,
                f"skipped: the conditions of fc_wait_logic {why}",
            )
        if self._motion.phase is MotionPhase.IDLE and control.offset.shifted:
            self._motion.reset(control.offset.setpoint.q)
            control.drop_offset()
        return None

    # -- the cycle ---------------------------------------------------------------------------

    def sense(self, sensed: SensedState) -> None:
        """Take the measurements of a cycle."""
        self.sensed = sensed
        if self._tares:
            self._tare()

    def tick(self, setpoint: JointSetPoint) -> JointSetPoint:
        """Give the drives' set-point for the motions' set-point, while force control is active."""
        control, motion, sensed = self.control, self._motion, self.sensed
        guiding = motion.following is not None and motion.following.kind == _GUIDING
        setpoint, outcome = control.tick(setpoint, sensed, compliant=motion.moving and not guiding)
        if outcome is not None:
            self._conclude(outcome)
        if motion.phase is MotionPhase.IDLE and not control.moving:
            if self._closing or self._disturbed or control.failed:
                motion.reset(setpoint.q)
                control.drop_offset()
            if self._closing or self._disturbed:
                self._end()
        return setpoint

    def take_alarm(self) -> str:
        """Text about a watched force that was too large since the last call; empty if none was."""
        alarm, self._alarm = self._alarm, ""
        return alarm

    def powered(self) -> None:
        """Tare the sensor, because the arm was enabled or disabled."""
        control, sensed = self.control, self.sensed
        control.sensor = control.sensor.tared(sensed.wrench, control.turn(sensed))

    def cut(self) -> None:
        """End force control, because the drives have no power."""
        if self.control.active:
            self._end(TaskState.INTERRUPT)

    def _end(self, state: TaskState = TaskState.FINISHED) -> None:
        self.control.end()
        self._disturbed = False
        closing, self._closing = self._closing, []
        for id_ in closing:
            self._tasks.set(id_, state)

    def _conclude(self, outcome: ForceOutcome) -> None:
        verdict, message = outcome
        if verdict == "guard":
            self._alarm = message
        elif verdict == "met":
            self._motion.curtail(message)
        else:
            self._motion.failures.append(message)
            self._motion.stop(TaskState.ERROR, message)
