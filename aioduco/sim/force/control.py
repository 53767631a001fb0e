"""Force control of the tool: how the arm responds to the force on its flange.

It has no clock, no physics and no tasks. Each `tick` is one cycle of the controller; it takes the
set-point of the motions and returns that of the drives.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

import numpy as np

from aioduco.kinematics.rates import ArmRates
from aioduco.models.rotation import Array, rpy_from_matrix
from aioduco.sim.force.conditions import Conditions, Quantity
from aioduco.sim.force.offset import FlangeOffset, OutOfReach
from aioduco.sim.force.sensor import DOWN, ForceAxes, ForceSensor

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.kinematics import Arm
    from aioduco.sim.cycle import SensedState
    from aioduco.sim.planner.path import JointSetPoint


#: time constant with which the arm reaches the speed that a force demands [s]; an assumption
_LAG = 0.01
#: largest accelerations of motions that a force causes [m/s², rad/s²]; an assumption
_ACCELERATION = (5.0, 25.0)
#: speed below which a decaying motion has ended [m/s, rad/s]
_FADED = 1e-4
_NOTHING = (0.0,) * 6
_PLAIN = ForceAxes(np.eye(4), np.eye(4))
_NAMES = ("along x", "along y", "along z", "about x", "about y", "about z")

Verdict: TypeAlias = Literal["guard", "failed", "met", "late"]


class ForceOutcome(NamedTuple):
    """Result of a cycle, besides its set-point.

    Attributes:
        verdict: "guard": a watched force is too large. "failed": the joints cannot follow.
            "met": the conditions of fc_wait_* hold. "late": they can no longer hold in time.
        message: text for people.
    """

    verdict: Verdict
    message: str


@dataclass(frozen=True, slots=True, eq=False)
class AdmittanceLaw:
    """Compliance of the tool (fc_config): it moves at (force - target) / damping.

    Attributes:
        direction: for each direction, whether the tool is compliant.
        target: force to hold, as the sensor measures it [N, N m].
        damping: damping, above 0 in compliant directions [N/(m/s), N m/(rad/s)].
        cap: largest speed [m/s, rad/s].
        band: dead band: difference from the target up to which the tool does not move [N, N m].
        axes: axes of these directions.
    """

    direction: tuple[bool, ...]
    target: tuple[float, ...]
    damping: tuple[float, ...]
    cap: tuple[float, ...]
    band: tuple[float, ...]
    axes: ForceAxes
    _compliant: tuple[tuple[int, float, float, float, float], ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        each = zip(range(6), self.target, self.damping, self.cap, self.band, strict=True)
        compliant = tuple(one for one in each if self.direction[one[0]])
        object.__setattr__(self, "_compliant", compliant)

    def speed(self, force: Sequence[float]) -> list[float]:
        """Give the speed of the tip along the axes [m/s, rad/s] for the force on it [N, N m]."""
        speeds = [0.0] * 6
        for i, target, damping, cap, band in self._compliant:
            difference = force[i] - target
            if abs(difference) > band:
                speeds[i] = max(-cap, min(difference / damping, cap))
        return speeds


@dataclass(frozen=True, slots=True, eq=False)
class ForceGuard:
    """Limits of the forces (fc_guard_act).

    Attributes:
        direction: for each direction, whether its force is monitored.
        limit: largest force of either sign [N, N m].
        axes: axes of these directions.
        with_load: whether the load's weight is included.
    """

    direction: tuple[bool, ...]
    limit: tuple[float, ...]
    axes: ForceAxes
    with_load: bool = True

    def exceeded(self, force: Sequence[float]) -> str:
        """Say which limit a force exceeds; empty if none."""
        for i, (on, limit) in enumerate(zip(self.direction, self.limit, strict=True)):
            if on and not abs(force[i]) <= limit:
                unit = "N" if i < 3 else "N m"
                return (
                    f"force guard: {force[i]:.1f} {unit} {_NAMES[i]}, but at most {limit:g} {unit}"
                )
        return ""


class ForceControl:
    """Makes the arm compliant while motions run, monitors forces, and checks the conditions.

    Args:
        arm: the arm.
        cycle: time between two ticks [s].
        gravity: gravity along the base's axes [m/s²].
    """

    def __init__(
        self, arm: Arm, cycle: float = 0.001, gravity: Sequence[float] | Array = DOWN
    ) -> None:
        self.active: bool = False
        self.sensor: ForceSensor = ForceSensor(gravity=tuple(map(float, gravity)))
        self.law: AdmittanceLaw | None = None
        self.guard: ForceGuard | None = None
        self.conditions: Conditions = Conditions()
        self._arm = arm
        self._cycle = cycle
        self.offset: FlangeOffset = FlangeOffset(arm, cycle)
        self._twist: Sequence[float] = _NOTHING
        #: whether the joints could not follow: they then slow down and stand until a new start
        self.failed: bool = False

    @property
    def moving(self) -> bool:
        """Whether a force moves the drives' set-points, or the joints slow down after a failure."""
        if self.failed:
            return bool(self.offset.setpoint.qd.any())
        return self._twist is not _NOTHING

    @property
    def axes(self) -> ForceAxes:
        """The axes of fc_config; before it was called, those of the flange and the base."""
        return _PLAIN if self.law is None else self.law.axes

    def turn(self, sensed: SensedState) -> Array:
        """Give the flange's rotation in the base frame. Shape (3, 3)."""
        return np.array(ArmRates(self._arm.geometry, sensed.q.tolist()).rotation)

    def start(self, setpoint: JointSetPoint) -> None:
        """Begin at the set-point of the motions."""
        self.active, self.failed = True, False
        self._twist = _NOTHING
        self.offset.begin(setpoint)

    def end(self) -> None:
        """End; the motions have to restart from where the arm is."""
        self.active = self.failed = False
        self._twist = _NOTHING
        self.conditions.end()

    def drop_offset(self) -> None:
        """Drop the offset, as the motions restart where the arm is; a decaying motion continues."""
        self.failed = False
        self.offset.drop_offset()

    def tick(
        self, setpoint: JointSetPoint, sensed: SensedState, *, compliant: bool
    ) -> tuple[JointSetPoint, ForceOutcome | None]:
        """Advance by one cycle.

        Args:
            setpoint: set-point of the motions.
            sensed: state of the arm as the controller measures it.
            compliant: whether the arm gives way to forces, which it does only while a motion runs.
        """
        flange = self.offset.flange
        external = self.sensor.external(sensed.wrench, flange)
        if message := self._guarded(sensed, external):
            return self.offset.setpoint, ForceOutcome("guard", message)
        if self.failed:
            return self.offset.slow_down(), None
        self._give_way(external, compliant=compliant)
        try:
            drives = self.offset.apply(setpoint)
        except OutOfReach as exc:
            self.failed = True
            self._twist = _NOTHING
            return self.offset.slow_down(), ForceOutcome("failed", str(exc))
        return drives, self._judge(sensed, running=compliant)

    def measure(self, quantity: Quantity, sensed: SensedState) -> list[float]:
        """Give the numbers for a condition: the tip in the work object, its speed, the force on it.

        Position and speed are along the work object's axes, the force along those of fc_config.
        """
        axes = self.axes
        rates = ArmRates(self._arm.geometry, sensed.q.tolist())
        flange = np.array(rates.rotation)
        if quantity == "ft":
            return axes.seen(self.sensor.external(sensed.wrench, flange), flange)
        into = axes.wobj[:3, :3].T
        arm = flange.dot(axes.tip[:3, 3])
        if quantity == "pos":
            place: list[float] = into.dot(arm + rates.position - axes.wobj[:3, 3]).tolist()
            angles: list[float] = rpy_from_matrix(into @ flange @ axes.tip[:3, :3]).tolist()
            return place + angles
        twist = rates.of_flange(sensed.qd.tolist())
        angular = twist[3:]
        speeds: list[float] = into.dot(twist[:3] + np.cross(angular, arm)).tolist()
        turning: list[float] = into.dot(angular).tolist()
        return speeds + turning

    def _guarded(self, sensed: SensedState, external: list[float]) -> str:
        guard = self.guard
        if guard is None:
            return ""
        force = self.sensor.felt(sensed.wrench) if guard.with_load else external
        return guard.exceeded(guard.axes.seen(force, self.offset.flange))

    def _judge(self, sensed: SensedState, *, running: bool) -> ForceOutcome | None:
        if not running or self.conditions.verdict is not None:
            self.conditions.restart_durations()
            return None
        verdict = self.conditions.tick(sensed.time, lambda what: self.measure(what, sensed))
        if verdict is None:
            return None
        how = "hold" if verdict == "met" else "did not hold in time"
        return ForceOutcome(verdict, f"the conditions of fc_wait_logic {how}")

    def _give_way(self, external: list[float], *, compliant: bool) -> None:
        """Move the offset at the speed that the force demands, with the lag of a light mass."""
        law, flange = self.law, self.offset.flange
        wanted: Sequence[float] = _NOTHING
        if compliant and law is not None:
            speeds = law.speed(law.axes.seen(external, flange))
            if any(speeds):
                turn = law.axes.turn(flange)
                linear, angular = speeds[:3], speeds[3:]
                wanted = [
                    *(turn.dot(linear).tolist() if any(linear) else linear),
                    *(turn.dot(angular).tolist() if any(angular) else angular),
                ]
        if wanted is _NOTHING:
            if self._twist is _NOTHING:
                return
            if max(map(abs, self._twist)) < _FADED:
                self._twist = _NOTHING
                return
        self._twist = self._approach(wanted)
        self.offset.move(self._twist, self.axes.tip)

    def _approach(self, wanted: Sequence[float]) -> list[float]:
        share = self._cycle / (self._cycle + _LAG)
        now: list[float] = []
        for start, most in ((0, _ACCELERATION[0]), (3, _ACCELERATION[1])):
            a, b, c = self._twist[start : start + 3]
            u, v, w = wanted[start : start + 3]
            u, v, w = share * (u - a), share * (v - b), share * (w - c)
            length = math.sqrt(u * u + v * v + w * w)
            if length > most * self._cycle:
                scale = most * self._cycle / length
                u, v, w = scale * u, scale * v, scale * w
            now += (a + u, b + v, c + w)
        return now
