"""The result of a demonstration as data: each motion, its outcome, and how well it was tracked."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from aioduco.models.enums import Outcome
    from aioduco.models.state import RobotStatus

SCHEMA = 1
#: number of looks at the box; distance that every arm exceeds when it lifts and carries it [m]
_LOOKS, _MOVED = 3, 0.05


@dataclass(slots=True)
class MotionRecord:
    """One motion of the demonstration.

    Attributes:
        name: purpose of the motion.
        function: the function of the wire protocol that moves the arm.
        expected: the expected outcome.
        outcome: the actual outcome; None while it runs, or if it never began.
        state: the last observed state of its task.
        task_id: the controller's id of the task.
        begin: when the controller accepted it, since the demonstration began [s].
        end: when its end was observed, since the demonstration began [s].
        tracking_error: the greatest difference of commanded and actual joints [rad].
        message: the error message if it did not end as expected.
    """

    name: str
    function: str
    expected: Outcome
    outcome: Outcome | None = None
    state: str = "sent"
    task_id: int | None = None
    begin: float = 0.0
    end: float = 0.0
    tracking_error: float | None = None
    message: str = ""

    @property
    def ok(self) -> bool:
        """Whether it ended as expected."""
        return self.outcome is self.expected

    @property
    def duration(self) -> float:
        """Time from the acceptance to the observed end [s]."""
        return self.end - self.begin

    def as_json(self) -> dict[str, Any]:
        """The record with plain values."""
        plain = asdict(self)
        plain["expected"] = self.expected.value
        plain["outcome"] = self.outcome.value if self.outcome else None
        return plain | {"duration": self.duration, "ok": self.ok}


@dataclass(slots=True)
class Report:
    """Result of one demonstration.

    Attributes:
        model: name of the arm.
        controller: `host:port` that it ran on.
        simulated: whether the demonstration started a simulated controller for itself.
        speed: how many times faster than the wall clock the simulated controller ran.
        motions: the motions in the order in which they were made.
        origin: when it began [s of `time.monotonic`].
        samples: the samples that were taken.
        part: where the simulated box lay, was carried, and lies at the end [m], in the base frame.
        error: the error that ended the demonstration early; empty without one.
    """

    model: str
    controller: str
    simulated: bool
    speed: float = 1.0
    origin: float = field(default_factory=time.monotonic)
    motions: list[MotionRecord] = field(default_factory=list)
    samples: list[RobotStatus] = field(default_factory=list)
    part: list[tuple[float, float, float]] = field(default_factory=list)
    error: str = ""

    def errors(self) -> NDArray[np.float64]:
        """Commanded minus actual joint positions [rad]. Shape (n, 6)."""
        each = [sample.expected_joints.array - sample.joints.array for sample in self.samples]
        return np.array(each, dtype=np.float64).reshape(-1, 6)

    def times(self) -> NDArray[np.float64]:
        """Times of the samples since the demonstration began [s]. Shape (n,)."""
        return np.array([sample.received_at - self.origin for sample in self.samples])

    def error_between(self, begin: float, end: float) -> float | None:
        """Greatest tracking error of a joint between two times [rad]; None without samples."""
        at = self.times()
        within = self.errors()[(begin <= at) & (at <= end)]
        return float(np.abs(within).max()) if len(within) else None

    @property
    def ok(self) -> bool:
        """Whether it ran to its end, each motion ended as expected, and the box was carried."""
        carried = self.carried is not False
        return not self.error and bool(self.motions) and all(m.ok for m in self.motions) and carried

    @property
    def carried(self) -> bool | None:
        """Whether the box was lifted, and put down on the other side; None without all looks."""
        if len(self.part) < _LOOKS:
            return None
        (_, y, z), (_, _, lifted), (_, there, down) = self.part
        return lifted - z > _MOVED and there - y > _MOVED and abs(down - z) < 0.1 * _MOVED

    @property
    def greatest_error(self) -> float | None:
        """The greatest tracking error of all motions [rad]; None if none was measured."""
        seen = [m.tracking_error for m in self.motions if m.tracking_error is not None]
        return max(seen, default=None)

    def as_json(self) -> dict[str, Any]:
        """The report with plain values, without the samples themselves."""
        return {
            "schema": SCHEMA,
            "ok": self.ok,
            "model": self.model,
            "controller": self.controller,
            "simulated": self.simulated,
            "speed": self.speed,
            "error": self.error,
            "samples": len(self.samples),
            "part": [list(place) for place in self.part],
            "carried": self.carried,
            "greatest_tracking_error": self.greatest_error,
            "motions": [motion.as_json() for motion in self.motions],
            "units": {"begin, end, duration": "s", "tracking_error": "rad", "part": "m"},
        }
