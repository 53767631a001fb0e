"""Joint positions with times, and values that describe how the arm follows them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

import numpy as np

from aioduco._process.copying import Frozen
from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.models.numpy_on_use import number_array
from aioduco.models.rules import Number, Vector, stored
from aioduco.models.words import one_of
from aioduco.streaming.sampling import Spline

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from aioduco.streaming.report import StreamStatistics


Through = Literal["auto", "realtime", "servoj"]
"""How set-points reach the controller."""

_DISTANCE = Number(0.0, unit="rad", source="this package")
_DISTANCES = Vector(_DISTANCE, length=6)


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerances:
    """Largest allowed distances of the arm from its trajectory.

    Attributes:
        path: distance of each joint from the path during the motion [rad]; 0: not checked.
        goal: distance of each joint from the last point at the end [rad].
        goal_time: time after the trajectory's end within which the goal must be reached [s].

    Raises:
        ParameterError: a number is below 0, or not finite.
    """

    path: float | tuple[float, ...] = 0.1
    goal: float | tuple[float, ...] = 0.01
    goal_time: float = 1.0

    def __post_init__(self) -> None:
        stored(self, goal_time=ranges.WAIT)
        for name in ("path", "goal"):
            given = getattr(self, name)
            if np.ndim(given) == 0:
                stored(self, **{name: _DISTANCE})
            else:
                object.__setattr__(self, name, tuple(_DISTANCES(name, given)))


class Feedback(NamedTuple):
    """The arm's progress on its trajectory.

    Attributes:
        time: time on the trajectory of the last set-point sent [s].
        desired: the point of the path closest to the arm, within the last 0.3 s
            [rad]. Shape (6,).
        actual: joint angles of the arm [rad]. Shape (6,).
        error: `actual` minus `desired` [rad]. Shape (6,).
    """

    time: float
    desired: NDArray[np.float64]
    actual: NDArray[np.float64]
    error: NDArray[np.float64]


class TrajectoryResult(NamedTuple):
    """The result of following a trajectory.

    Attributes:
        duration: time from the first set-point until the arm is within its goal tolerance [s].
        path_error: largest measured distance of each joint from the path [rad].
        goal_error: distance of each joint from the last point at the end [rad].
        statistics: statistics of the stream.
    """

    duration: float
    path_error: NDArray[np.float64]
    goal_error: NDArray[np.float64]
    statistics: StreamStatistics


class JointTrajectory(Frozen):
    """Joint positions at given times, optionally with velocities and accelerations.

    Positions alone are joined by a monotone cubic that rests at both ends. Positions with
    velocities are joined by a cubic that has these velocities; if accelerations are given too, by a
    curve of fifth order that has both.

    Args:
        positions: joint positions [rad], -2π to 2π. Shape (n, 6).
        times: time of each point from the start, rising, the first at least 0 [s]. Shape (n,).
        velocities: joint velocities, to be followed zero at the last point [rad/s]. Shape (n, 6).
        accelerations: joint accelerations, only with velocities [rad/s²]. Shape (n, 6).

    Raises:
        ParameterError: the shapes do not match, or a number is not allowed.
    """

    def __init__(
        self, positions: Any, times: Any, velocities: Any = None, accelerations: Any = None
    ) -> None:
        rows = _matrix("positions", positions).tolist()
        self.positions: NDArray[np.float64] = _matrix(
            "positions", [ranges.JOINTS(f"positions[{i}]", row) for i, row in enumerate(rows)]
        )
        count = len(rows)
        self.times: NDArray[np.float64] = _fixed("times", times)
        if self.times.shape != (count,):
            raise ParameterError("times", times, f"{count} numbers")
        if self.times[0] < 0 or np.any(np.diff(self.times) <= 0):
            raise ParameterError("times", times, "rising, the first at least 0")
        ranges.WAIT("times[-1]", self.duration)
        self.velocities: NDArray[np.float64] | None = (
            None if velocities is None else _matrix("velocities", velocities, count)
        )
        if accelerations is not None and velocities is None:
            raise ParameterError("accelerations", "given", "left out when velocities are")
        self.accelerations: NDArray[np.float64] | None = (
            None if accelerations is None else _matrix("accelerations", accelerations, count)
        )

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {len(self.times)} points in {self.duration:g} s>"

    @property
    def duration(self) -> float:
        """Time of the last point [s]."""
        return float(self.times[-1])

    def curve(self, actual: Sequence[float]) -> Spline:
        """The curve through the points; it starts at the arm if the first point's time is not 0.

        Args:
            actual: joint angles of the arm [rad]. Shape (6,).
        """
        if self.times[0] == 0:
            return Spline(self.times, self.positions, self.velocities, self.accelerations)

        def led(first: NDArray[np.float64], part: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.vstack([first, part])

        still = np.zeros(6)
        return Spline(
            np.concatenate([[0.0], self.times]),
            led(np.asarray(actual, dtype=np.float64), self.positions),
            None if self.velocities is None else led(still, self.velocities),
            None if self.accelerations is None else led(still, self.accelerations),
        )


def check_following(through: object, tolerances: object, feedback: object) -> None:
    """Check how a trajectory is to be followed.

    Raises:
        ParameterError: an argument has another type or value.
    """
    one_of("through", through, get_args(Through))
    if tolerances is not None and not isinstance(tolerances, Tolerances):
        raise ParameterError("tolerances", tolerances, "Tolerances, or None")
    if feedback is not None and not callable(feedback):
        raise ParameterError("feedback", feedback, "a function, or None")


def _fixed(name: str, value: Any) -> NDArray[np.float64]:
    """A copy that cannot be changed, so that the checks of it stay valid."""
    found = number_array(name, value)
    found.setflags(write=False)
    return found


def _matrix(name: str, value: Any, count: int | None = None) -> NDArray[np.float64]:
    found = _fixed(name, value)
    wanted = "n" if count is None else count
    if found.ndim != 2 or found.shape[1] != 6 or not len(found) or count not in (None, len(found)):
        raise ParameterError(name, found.shape, f"of the shape ({wanted}, 6)")
    return found
