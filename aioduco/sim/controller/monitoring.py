"""Monitors that the controller runs in each cycle, without clock or physics.

They detect whether the arm stands, whether it has hit something, and whether the heartbeat is lost.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.models.rotation import Array
    from aioduco.sim.cycle import SensedState


#: joint speed above which an arm counts as moving [rad/s]
_SPEED = 2e-3
#: joint speed above which an arm does more than swing at the end of a motion [rad/s]
_TURNING = 0.1
#: time at low speed that counts as standing: a swinging joint is slow at its turning points [s]
_REST = 0.02
#: time after the last motion of the set-points at which an arm counts as standing in any case [s]
_PATIENCE = 0.5
#: by level of detection: external torque that is a collision, as a share of a joint's largest.
#: That a higher level is more sensitive, and the shares, are assumptions.
LEVELS = {0: math.inf, 1: 0.5, 2: 0.4, 3: 0.3, 4: 0.2, 5: 0.12}
#: time over which a torque is smoothed, as an observer of momentum does [s]; an assumption
SMOOTHING = 0.008
#: range of heartbeat times that a controller accepts [ms]; other times are limited to it
SHORTEST, LONGEST = 200, 60_000
#: heartbeat time of a beat that gives none [ms] (manual 1.3.1)
AGREED = 1000
_NONE = (0.0,) * 6


class Standstill:
    """Detects in each cycle whether the arm stands.

    Attributes:
        turning: whether a joint is faster than one that swings at the end of a motion.
    """

    def __init__(self) -> None:
        self._commanded = 0.0
        self._last_motion = -math.inf
        self.turning: bool = False

    def tick(self, sensed: SensedState, *, commanded: bool) -> bool:
        """Whether the arm stands, or has trembled for so long that it counts as standing.

        Args:
            sensed: measurements of the arm.
            commanded: whether its set-points move.
        """
        if commanded:
            self._commanded = sensed.time
        speeds = sensed.qd.tolist()
        # Plain floats: for six values they are several times as fast as arrays. The length of the
        # vector decides clear cases: it is 1 to 2.45 times the largest of the six speeds.
        fastest = math.hypot(*speeds)
        if _SPEED < fastest <= 2.5 * _TURNING:
            fastest = max(map(abs, speeds))
        self.turning = fastest > _TURNING
        if fastest > _SPEED:
            self._last_motion = sensed.time
        # A tolerance of less than a cycle: the cycle must not depend on rounding.
        if sensed.time - self._last_motion >= _REST - 1e-9:
            return True
        return sensed.time - self._commanded > _PATIENCE


class CollisionDetector:
    """Watches the external torques, joint by joint.

    Args:
        effort: largest torques of the joints [N m]. Shape (6,).
        ignored: whether a collision that is detected now does not count; None: each counts.

    Attributes:
        level: level of detection: 0 for none, or 1 to 5, each more sensitive than the one before.
        axis: joint of a collision that was not reset, 1 to 6, or 0.
        torque: smoothed external torques of the six joints [N m]; never changed in place.
    """

    def __init__(self, effort: Array, ignored: Callable[[], bool] | None = None) -> None:
        self.level: int = 3
        self.axis: int = 0
        self.torque: Sequence[float] = _NONE
        self._effort: list[float] = effort.tolist()
        self._weakest = min(self._effort)
        self._ignored = ignored
        self._time: float | None = None

    def reset(self) -> None:
        """Restart, for instance after brakes have held the arm."""
        self.torque = _NONE
        self._time = None

    def update(self, time: float, external: Array) -> int:
        """Process the torques of one cycle.

        Args:
            time: simulated time [s].
            external: torques that the motion needed beyond those of the drives [N m]. Shape (6,).

        Returns:
            The joint at which a collision is detected, 1 to 6, or 0.
        """
        passed = 0.0 if self._time is None else time - self._time
        self._time = time
        gain = passed / (passed + SMOOTHING)
        # Written out: this takes half the time of a loop over six, and a quarter of an array's.
        a, b, c, d, e, f = self.torque
        u, v, w, x, y, z = external.tolist()
        self.torque = smooth = (
            a + gain * (u - a),
            b + gain * (v - b),
            c + gain * (w - c),
            d + gain * (x - d),
            e + gain * (y - e),
            f + gain * (z - f),
        )
        if not self.level or math.hypot(*smooth) <= LEVELS[self.level] * self._weakest:
            return 0  # even all torques together would be no collision at the weakest joint
        shares = [abs(torque) / most for torque, most in zip(smooth, self._effort, strict=True)]
        largest = max(shares)
        if largest <= LEVELS[self.level] or (self._ignored is not None and self._ignored()):
            return 0
        return shares.index(largest) + 1


class HeartbeatWatchdog:
    """The watchdog behind rpc_heartbeat (manual 1.3.1). The first beat arms it, a loss disarms it.

    Times are real, not simulated: a client sends beats by its own clock, however fast simulated
    time runs.

    Attributes:
        time: time within which the next beat is due [ms].
        slack: delay after that with which the beat may still come [s].
    """

    def __init__(self) -> None:
        self._due: float | None = None
        self.time: int = 0
        self.slack: float = 0.0

    def beat(self, now: float, time: int) -> float:
        """Take a beat; the next is due within `time` milliseconds, 0 for the default time.

        Returns:
            The delay of the beat after its due time [s]; 0 if it is in time.
        """
        late = 0.0 if self._due is None else max(0.0, now - self._due)
        self.time = min(max(time, SHORTEST), LONGEST) if time else AGREED
        self._due = now + self.time / 1000.0
        return late

    def disarm(self) -> None:
        """Expect no further beat."""
        self._due = None

    def lost(self, now: float) -> bool:
        """Whether a beat is overdue; true once for each loss."""
        if self._due is None or now <= self._due + self.slack:
            return False
        self._due = None
        return True
