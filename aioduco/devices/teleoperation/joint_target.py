"""Integration of speeds to joint angles, for programs that record and learn positions. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from aioduco._process.copying import Uncopied
from aioduco.errors import ParameterError
from aioduco.kinematics.arm import Arm
from aioduco.models.ranges import TIMEOUT
from aioduco.models.rules import Number, Vector

if TYPE_CHECKING:
    from collections.abc import Sequence


_MOVED = 1.5  # multiple of the lead from which on the arm was moved by something else
_AWAY = 0.05  # by which an arm that comes to a standing target is farther away again then [rad]
_Vector = NDArray[np.float64]
_SIX = Vector(Number(source="this package"), length=6, source="this package")
_ABOVE = Number(0.0, open_low=True, source="this package")


class JointTarget(Uncopied):
    """Integrates a speed from the arm's position, one step at a time.

    Near a singularity the step is damped: the tool is then slower than requested, and no joint is
    faster than `fastest`.

    Args:
        arm: the arm's kinematics.
        fastest: largest speed of a joint [rad/s].
        lead: largest distance of the target ahead of the measured joint angles [rad].
        damping: damping factor; a larger factor takes effect further from a singularity.

    Raises:
        ParameterError: a number is out of range.
    """

    def __init__(
        self, arm: Arm, *, fastest: float = 0.5, lead: float = 0.15, damping: float = 0.03
    ) -> None:
        if not isinstance(arm, Arm):
            raise ParameterError("arm", arm, "an Arm, such as aioduco.kinematics.arm gives")
        self._arm = arm
        self._fastest = _ABOVE("fastest", fastest)
        self._lead = _ABOVE("lead", lead)
        self._damping = _ABOVE("damping", damping)
        self._target: _Vector | None = None
        #: least distance of each joint from the target since that stands [rad]; infinite before
        self._nearest: _Vector = np.full(6, np.inf)

    def rest(self, seen: Sequence[float]) -> _Vector:
        """Keep the target, or reset it to the arm if something else has moved the arm away.

        Args:
            seen: joint angles of the arm [rad]. Shape (6,).

        Raises:
            ParameterError: they are not six finite numbers.
        """
        target = self._from(seen)
        away = np.abs(target - np.array(seen, dtype=float))
        if np.any(away > self._nearest + _AWAY):
            target, away = np.array(seen, dtype=float), np.zeros(6)
        self._target, self._nearest = target, np.minimum(self._nearest, away)
        return target.copy()

    def _from(self, seen: Sequence[float]) -> _Vector:
        """The target, or the arm's position if that is farther away than it may lag."""
        actual = np.array(_SIX("seen", seen))
        if self._target is None or np.abs(self._target - actual).max() > _MOVED * self._lead:
            return actual
        return self._target

    def by_twist(
        self, twist: Sequence[float], period: float, seen: Sequence[float], *, in_tool: bool = False
    ) -> _Vector:
        """Advance by a speed of the flange.

        Args:
            twist: the speed [m/s, rad/s], along and about the axes of the base. Shape (6,).
            period: duration of the step [s].
            seen: joint angles of the arm [rad]. Shape (6,).
            in_tool: whether the speed is along and about the axes of the flange instead.

        Returns:
            The joint angles to go to [rad]. Shape (6,).

        Raises:
            ParameterError: the duration is not above 0, or there are not six finite numbers.
        """
        target = self._from(seen)
        wanted = np.array(_SIX("twist", twist))
        if in_tool:
            turn = self._arm.fkine(target)[:3, :3]
            wanted = np.concatenate([turn @ wanted[:3], turn @ wanted[3:]])
        jacobian = self._arm.jacobian(target)
        square = jacobian @ jacobian.T + self._damping**2 * np.eye(6)
        return self.by_joints(jacobian.T @ np.linalg.solve(square, wanted), period, seen)

    def by_joints(
        self, speeds: Sequence[float] | _Vector, period: float, seen: Sequence[float]
    ) -> _Vector:
        """Advance by joint speeds.

        Args:
            speeds: the speeds [rad/s]. Shape (6,).
            period: duration of the step [s].
            seen: joint angles of the arm [rad]. Shape (6,).

        Returns:
            The joint angles to go to [rad]. Shape (6,).

        Raises:
            ParameterError: the duration is not above 0, or there are not six finite numbers.
        """
        period = TIMEOUT("period", period)
        target, found = self._from(seen), np.array(_SIX("speeds", speeds))
        most = float(np.abs(found).max())
        if most > self._fastest:
            found *= self._fastest / most
        new = target + found * period
        actual = np.array(seen, dtype=float)
        new = np.clip(new, actual - self._lead, actual + self._lead)
        self._target = np.clip(new, self._arm.lower, self._arm.upper)
        self._nearest = np.full(6, np.inf)
        return self._target.copy()
