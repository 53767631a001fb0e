"""State of a monitor at a moment: all data that its screen shows."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from aioduco.kinematics.arm import POSITION_LIMIT
from aioduco.models.enums import ProgramState
from aioduco.models.state import alarm_of, standing

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.supervision.state_feed import Snapshot


#: seconds without a sample after which the screen says that the controller does not answer
_SILENT: Final = 1.0

#: severity of an event: "info", "good", "warning" or "alarm"
Severity = str


@dataclass(frozen=True, slots=True)
class EventLine:
    """An event, as a line of the screen.

    Attributes:
        at: time of day, such as "14:03:07".
        text: description.
        severity: severity of the event.
    """

    at: str
    text: str
    severity: Severity = "info"


@dataclass(frozen=True, slots=True, eq=False)
class MonitorState:
    """All data that is shown.

    Attributes:
        robot: name and address of the robot.
        arm: type of the arm and version of the software, as the controller reports them.
        sample: the newest sample; None before the first.
        age: age of the sample [s].
        rate: requested samples per second [Hz].
        measured_rate: received samples per second [Hz].
        answer_time: time in which the last sample was answered [s]; None before the first.
        project: the controller's current project; empty if it has none or reports none.
        speed: the controller's speed override [%]; None if it reports none.
        errors: the controller's error list.
        events: the events, the newest last.
        notice: result of the last key.
        busy: commands of keys that are running, such as "stop"; empty for none.
        lower: lower joint limits [rad].
        upper: upper joint limits [rad].
        history: of the samples of the last minute: the tool's speed [mm/s], the force at the tool
            [N], and how far a joint is behind at most [°]; NaN for what was not read.
    """

    robot: str
    arm: str = ""
    sample: Snapshot | None = None
    age: float = math.inf
    rate: float = 10.0
    measured_rate: float = 0.0
    answer_time: float | None = None
    project: str = ""
    speed: float | None = None
    errors: tuple[str, ...] = ()
    events: tuple[EventLine, ...] = ()
    notice: EventLine | None = None
    busy: str = ""
    lower: Sequence[float] = field(default=(-POSITION_LIMIT,) * 6)
    upper: Sequence[float] = field(default=(POSITION_LIMIT,) * 6)
    history: Sequence[tuple[float, float, float]] = ()

    @property
    def history_length(self) -> int:
        """Number of samples of a minute."""
        return max(1, round(60.0 * self.rate))

    @property
    def silent(self) -> bool:
        """Whether the controller does not answer, so that the shown data is old."""
        return self.sample is not None and self.age > max(_SILENT, 3.0 / self.rate)

    @property
    def alarm(self) -> str:
        """The alarm, in capitals; empty if there is none."""
        if self.sample is None:
            return ""
        if self.silent:
            return f"NO ANSWER FOR {self.age:.0f} s: WHAT IS SHOWN IS OLD"
        return alarm_of(self.sample.status, self.sample.states)

    @property
    def doing(self) -> str:
        """What the arm does. The controller does not report task ids to an observer."""
        if self.sample is None:
            return "waiting for the first answer"
        program = self.sample.states.program
        stands = standing(self.sample.status)
        motion = "no speeds are told" if stands is None else "standing" if stands else "moving"
        running = program not in {ProgramState.STOPPED}
        task = f"task {program.name}" if running else "no task"
        return ", ".join((motion, task, *((f"project {self.project}",) if self.project else ())))


def history_point(sample: Snapshot) -> tuple[float, float, float]:
    """What `MonitorState.history` keeps of a sample."""
    status, forces = sample.status, sample.read_forces
    force = math.nan if forces is None else math.hypot(*forces.tool.tolist()[:3])
    behind = max(
        abs(told - actual)
        for told, actual in zip(status.expected_joints, status.joints, strict=True)
    )
    return math.hypot(*status.tool_speed.tolist()[:3]) * 1e3, force, math.degrees(behind)
