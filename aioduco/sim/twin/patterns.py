"""Which cause explains external torques: a payload, a contact, or friction.

Each is fitted to the torques (and to the force at the tool) of the last moments, by least squares
with weights that fade: a mass at the flange, a force at the flange, and a share of the friction.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from aioduco.models.rotation import Array
    from aioduco.sim.twin.predictor import Deviation


#: time over which the weight of a sample fades to 37 % [s]
_FADING = 0.15
#: speed below which a joint may stick, so that its friction has any size [rad/s]
_STICKING = 0.02
#: share of the dry friction by which the torque of a joint that may stick is uncertain
_STUCK = 1.3
#: standard deviations that are taken for granted before there is data [kg, N, 1]
_MASS, _FORCE, _SHARE = 1.0, 20.0, 0.5
#: standard deviation of the force at the tool, alone and beside torques [N]: its zero is that of
#: the first sample, at which something may have pushed already
_SENSOR, _BESIDE = 0.5, 5.0
#: share of a force's explanation from which a mass, the simpler one, is preferred
_SIMPLER = 0.85
#: the same share where the mass is about the one that may have been lost
_LIKELY = 0.6
#: largest share of the carried mass that a loss may seem to be
_LOST = 1.4


class Friction(NamedTuple):
    """Friction of the joints as the observed external torques show it, with their offsets.

    Attributes:
        dry: dry friction [N m]. Shape (6,).
        viscous: friction that grows with the speed [N m s/rad]. Shape (6,).
        offset: torque without motion [N m]. Shape (6,).
    """

    dry: Array
    viscous: Array
    offset: Array

    def torque(self, speeds: Array) -> Array:
        """External torques that friction shows at these speeds [N m]. Shape (6,)."""
        felt: Array = -(self.dry * np.clip(speeds / _STICKING, -1.0, 1.0) + self.viscous * speeds)
        return felt

    def residual(self, external: Array, speeds: Array) -> Array:
        """What remains of external torques [N m]. Shape (6,)."""
        rest = external - self.offset - self.torque(speeds)
        stuck = np.where(np.abs(speeds) < _STICKING, _STUCK * self.dry, 0.0)
        found: Array = np.sign(rest) * np.maximum(np.abs(rest) - stuck, 0.0)
        return found


class Patterns(NamedTuple):
    """The best fit of each cause, and how much of the torques it explains.

    Attributes:
        mass: additional mass at the flange [kg].
        force: force at the flange, along the base's axes [N]. Shape (3,).
        friction: additional share of the friction.
        by_mass, by_force, by_friction: explained squares, in units of the variance.
    """

    mass: float
    force: Array
    friction: float
    by_mass: float
    by_force: float
    by_friction: float

    @property
    def pushed(self) -> float:
        """Size of the force [N]."""
        return float(np.linalg.norm(self.force))

    @property
    def is_friction(self) -> bool:
        """Whether friction explains most."""
        return self.by_friction > max(self.by_mass, self.by_force)

    def is_mass(self, carried: float | None) -> bool:
        """Whether a mass explains the torques about as well as any force.

        Args:
            carried: mass that the program has set [kg]; None if it is not known. No more than this
                can be lost, and all of it is what usually is.
        """
        needed = _SIMPLER
        if self.mass < 0.0 and carried is not None:
            if -self.mass > _LOST * carried + 0.1:
                return False
            needed = _LIKELY if -self.mass > 0.5 * carried else _SIMPLER
        return self.by_mass > needed * self.by_force


class PatternFit:
    """Fits the causes to a sequence of samples.

    Args:
        friction: friction of the arm in good order.
        noise: standard deviations of the torques [N m]. Shape (6,).
    """

    def __init__(self, friction: Friction, noise: Array) -> None:
        self._friction = friction
        self._weight = 1.0 / noise**2
        self._a = np.zeros((5, 5))
        self._b = np.zeros(5)
        self._prior = 1.0 / np.array([_MASS, _FORCE, _FORCE, _FORCE, _SHARE]) ** 2

    def update(self, deviation: Deviation) -> tuple[Array, Patterns] | None:
        """Take a sample; return the residual torques [N m] and the fits.

        Returns:
            None if the sample has neither torques nor a force.
        """
        force, external = deviation.force, deviation.external
        if external is None and force is None:
            return None
        friction, speeds = self._friction, deviation.speeds
        rest = np.zeros(6) if external is None else friction.residual(external, speeds)
        lever = deviation.jacobian.T  # torques for a force at the flange
        weight = deviation.weight
        columns = np.column_stack((lever @ weight, lever, friction.torque(speeds)))
        weighted = columns.T * self._weight
        a, b = weighted @ columns, weighted @ rest
        if external is None:
            a[:], b[:] = 0.0, 0.0
        if force is not None:
            sensed = (_SENSOR if external is None else _BESIDE) ** -2
            a[0, 0] += sensed * (weight @ weight)
            b[0] += sensed * (weight @ force)
            a[[1, 2, 3], [1, 2, 3]] += sensed
            b[1:4] += sensed * force
        keep = math.exp(-deviation.step / _FADING)
        self._a = keep * self._a + (1.0 - keep) * a
        self._b = keep * self._b + (1.0 - keep) * b
        return rest, self._fits()

    def _fits(self) -> Patterns:
        a, b = self._a + np.diag(self._prior), self._b
        force: Array = np.asarray(np.linalg.solve(a[1:4, 1:4], b[1:4]), dtype=np.float64)
        mass, friction = b[0] / a[0, 0], b[4] / a[4, 4]
        return Patterns(
            float(mass), force, float(friction),
            float(mass * b[0]), float(force @ b[1:4]), float(friction * b[4]),
        )  # fmt: skip
