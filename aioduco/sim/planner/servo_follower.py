"""The servo follower: each joint moves to its target independently (manual 1.3.5, servoj).

Each joint accelerates by kp times its distance from the target plus kd times the rate of that
distance. It stays within its largest speed and acceleration, and is never so fast that it cannot
brake before the target. Two low-pass filters in series smooth the target. (Names, units and ranges
of the parameters are the manual's. How the controller uses them is not published: all of this is an
assumption.)

kd acts on the rate of the distance, not on the joint's speed, for these reasons. The manual calls
kd a derivative gain. It recommends smoothing where the differences of the points over time are
uneven, so the controller uses their rate. A public driver was tuned to 400 and 80 to follow better
than 200 and 25. If kd only damped the speed, the joint would follow worse, with a lag of kd/kp.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from aioduco.sim.planner.follower import TargetFollower

if TYPE_CHECKING:
    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array
    from aioduco.sim.planner.path import JointSetPoint


_SPEED_SMOOTHING = 1e-3  # time constant for a smooth_vel of 1 [s]
_ACCELERATION_SMOOTHING = 1e-2  # time constant for a smooth_acc of 1 [s]
_UNLIMITED_ACCELERATION = 1e4  # stands for an acceleration without a limit [rad/s²]
_THERE, _STILL = 5e-5, 5e-4  # tolerances for a joint at its target, and at rest [rad, rad/s]
_HOLD = 0.05  # time at the target before the end: a stream of slow targets is one motion [s]


@dataclass(frozen=True, slots=True)
class ServoTuning:
    """Parameters for following a target.

    Attributes:
        v: largest joint speed [rad/s].
        a: largest joint acceleration [rad/s²].
        kp: proportional gain [1/s²].
        kd: derivative gain [1/s].
        smooth_vel: smoothing of the speed, 1 to 100.
        smooth_acc: smoothing of the acceleration, 0 to 1.
    """

    v: float
    a: float
    kp: float
    kd: float
    smooth_vel: float
    smooth_acc: float


class ServoFollower(TargetFollower):
    """Moves to a target that may be replaced at any time.

    Args:
        arm: the arm.
        q: joints at the start [rad]. Shape (6,).
        cycle: time between two ticks [s].
    """

    def __init__(self, arm: Arm, q: Array, cycle: float) -> None:
        super().__init__(arm, q, cycle)
        #: joints to go to [rad]. Shape (6,)
        self.target: Array = np.array(q)
        self._once, self._twice = self.target, self.target  # the target, smoothed
        self._held = 0.0  # time at the target
        self._tuning = ServoTuning(0.0, 0.0, 0.0, 0.0, 1.0, 0.0)

    def aim(self, target: Array, tuning: ServoTuning) -> None:
        """Set other joints as the target [rad], shape (6,), and how to follow it."""
        self.target = target
        self._held = 0.0
        self._tuning = tuning

    def _resumed(self) -> None:
        # The filters restart from the arm's position: targets during the pause do not count.
        self._once = self._twice = self.setpoint.q

    def _next(self, q: Array, qd: Array) -> JointSetPoint:  # noqa: ARG002 - it follows no sensors
        tuning, cycle, last = self._tuning, self._cycle, self.setpoint
        self._once = self._once + (self.target - self._once) * _share(
            tuning.smooth_vel * _SPEED_SMOOTHING, cycle
        )
        before = self._twice
        self._twice = before + (self._once - before) * _share(
            tuning.smooth_acc * _ACCELERATION_SMOOTHING, cycle
        )
        rate = (self._twice - before) / cycle
        error = self._twice - last.q
        if np.abs(last.qd).max() < _STILL and np.abs(self.target - last.q).max() < _THERE:
            self._held += cycle
            if self._held >= _HOLD:
                self._end()
                return self.setpoint
        change = min(tuning.a, _UNLIMITED_ACCELERATION) * cycle
        speed = last.qd + np.clip(
            (tuning.kp * error + tuning.kd * (rate - last.qd)) * cycle, -change, change
        )
        # The speed from which whole cycles of braking end at the target.
        arriving = change * (np.sqrt(0.25 + 2.0 * np.abs(error) / (change * cycle)) - 0.5)
        towards = np.minimum(arriving, tuning.v)
        speed = np.where(error > 0.0, np.minimum(speed, towards), np.maximum(speed, -towards))
        speed = np.clip(speed, -tuning.v, tuning.v)
        return self._step(np.clip(speed, last.qd - change, last.qd + change))


def _share(time: float, cycle: float) -> float:
    return cycle / (time + cycle)
