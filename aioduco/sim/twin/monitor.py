"""Watches an arm beside its twin: finds where they part, since when, and the probable cause.

A state machine without I/O and clock. Each difference has a cumulative sum that grows while the
difference is beyond its limit and shrinks while it is not: a large excess is found at once, a small
one a little later, a short disturbance not at all.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from aioduco.models.enums import RobotState
from aioduco.sim.twin.data import Cause, Divergence, Quantity, TwinCommand, TwinSample
from aioduco.sim.twin.patterns import PatternFit, Patterns
from aioduco.sim.twin.predictor import Deviation, Predictor

if TYPE_CHECKING:
    from collections.abc import Mapping

    from aioduco.kinematics import Arm
    from aioduco.models.pose import Pose
    from aioduco.sim.twin.limits import TwinLimits


#: time for which a difference of twice its limit must last [s]
_HOLD = 0.06
#: time after the first sign in which the evidence for the cause is gathered [s]
_EVIDENCE = 0.15
#: time within limits after which a quantity is watched anew [s]
_QUIET = 1.0
#: time after a command of this program during which its effect on the states is expected [s]
_EXPECTED = 2.0
#: time for which a movement without a command explains what parts [s]
_UNCOMMANDED = 0.5
#: functions after which the states of the controller change
_STATE_CHANGES = frozenset(
    (
        *("power_on", "power_off", "enable", "disable", "shutdown", "restart", "switch_mode"),
        *("simulation", "collision_detection_reset", "stop", "abort", "pause", "resume"),
        "run_program",
    )
)


class TwinFigures(NamedTuple):
    """The present differences between an arm and its twin; None for those that are not known.

    Attributes:
        mass: additional mass at the flange [kg].
        force: force at the flange [N].
        friction: additional share of the joints' friction.
        torque: largest residual torque of a joint, as a share of its limit.
        tracking: largest tracking error of a joint, as a share of its limit.
        position: difference of the tool's position for its joints [m].
        path: distance of the set-points from the rehearsed path [rad].
        delay: time by which the set-points come later than rehearsed [s].
        blind: why the commands are not rehearsed now; empty if they are.
    """

    mass: float | None = None
    force: float | None = None
    friction: float | None = None
    torque: float | None = None
    tracking: float | None = None
    position: float | None = None
    path: float | None = None
    delay: float | None = None
    blind: str = ""


class _Excess:
    """Cumulative sum of a difference in units of its limit.

    Attributes:
        since: when it last began to grow [s].
        worst: largest difference since then.
    """

    def __init__(self) -> None:
        self._sum = 0.0
        self.since = 0.0
        self.worst = 0.0

    @property
    def over(self) -> bool:
        """Whether nothing of it is left."""
        return self._sum == 0.0

    def update(self, share: float, at: float, step: float) -> bool:
        """Take a difference as a share of its limit; return whether it has lasted."""
        if self._sum == 0.0:
            self.since, self.worst = at - step, 0.0
        self.worst = max(self.worst, share)
        # at most as fast as for three times the limit: a single sample is never enough
        self._sum = max(0.0, self._sum + (min(share, 3.0) - 1.0) * step)
        self._sum = min(self._sum, 2.0 * _HOLD)
        return self._sum > _HOLD


class TwinMonitor:
    """Compares an arm with its twin.

    Args:
        arm: the arm.
        limits: the limits of differences.
        tool: tip of the tool in the flange's frame [m, rad]; None to take it from the first sample.
        mounting: pose of the base in the world [m, rad].
        commands: whether the program's commands are known: without them, nothing is said about
            paths, delays, and other programs.

    Attributes:
        figures: the present differences.
        joints: where the arm should be [rad]: behind the rehearsed set-points, or while these are
            not known behind the controller's, by the normal lag of each joint.
    """

    def __init__(
        self,
        arm: Arm,
        limits: TwinLimits,
        *,
        tool: Pose | None = None,
        mounting: Pose | None = None,
        commands: bool = True,
    ) -> None:
        self.limits: TwinLimits = limits
        self._predictor = Predictor(arm, tool, mounting)
        self._commands = commands
        self._fit = PatternFit(limits.normal_friction, np.array(limits.noise))
        self._lag = np.array(limits.lag)
        self._torque_limit = np.array(limits.torque)
        self._tracking_limit = np.array(limits.tracking)
        self._excess: dict[tuple[Quantity, str], _Excess] = {}
        #: differences that were reported, with the time at which they were last beyond a limit
        self._reported: dict[Quantity, float] = {}
        #: differences that have lasted, before their causes are named
        self._signs: list[Divergence] = []
        self._changed_at = -math.inf
        #: whether arm and rehearsal stood at one place, and the rehearsal still does
        self._in_step = False
        self._uncommanded_at = -math.inf
        self._was: TwinSample | None = None
        self._patterns: Patterns | None = None
        #: masses that the program has set: of the tool, and of the load [kg]
        self._masses = {"set_tool_data": 0.0, "set_load_data": 0.0}
        self._outcomes: list[Divergence] = []
        self.figures: TwinFigures = TwinFigures()
        self.joints: tuple[float, ...] = ()

    def command(self, command: TwinCommand) -> None:
        """Take a command of the program, `predictor.AHEAD` before the samples of its time."""
        if command.function in _STATE_CHANGES:
            self._changed_at = command.time
        if command.function in self._masses and command.accepted:
            load = command.arguments[2 if command.function == "set_tool_data" else 0]
            self._masses[command.function] = float(load[0]) if load else 0.0
        if self._predictor.command(command) and command.accepted is False:
            self._outcomes.append(
                Divergence(
                    Quantity.OUTCOME, f"{command.function}, refused by the arm", command.time,
                    command.time, 1.0, 0.0, "", Cause.UNKNOWN, {},
                )
            )  # fmt: skip

    def sample(self, sample: TwinSample) -> list[Divergence]:
        """Take a sample; return what has parted.

        One in which a number is missing is left out.
        """
        if not sample.whole:
            self.figures = TwinFigures(blind="the controller did not send all numbers")
            return []
        deviation = self._predictor.deviation(sample)
        found, self._outcomes = self._outcomes, []
        at = sample.time
        rehearsed = self._predictor.rehearsal.setpoint if self._commands else None
        q, speeds = rehearsed or (np.array(sample.expected), deviation.expected_speeds)
        self.joints = tuple((q - self._lag * speeds).tolist())
        figures: dict[str, Any] = {"blind": self._predictor.rehearsal.blind}
        self._torques(deviation, figures)
        self._geometry(deviation, figures)
        if self._commands:
            self._path(sample, deviation, figures)
        found += self._states(sample)
        self.figures = TwinFigures(**figures)
        found += self._named(at, deviation)
        self._was = sample
        return found

    # -- the differences -----------------------------------------------------------------------

    def _torques(self, deviation: Deviation, figures: dict[str, Any]) -> None:
        limits = self.limits
        if (fits := self._fit.update(deviation)) is not None:
            rest, patterns = fits
            self._patterns = patterns
            shares = np.abs(rest) / self._torque_limit
            for joint, share in enumerate(shares.tolist()):
                self._watch(Quantity.TORQUE, f"joint {joint + 1}", share, limits.torque[joint],
                            "N m", deviation)  # fmt: skip
            mass, force = patterns.mass, patterns.pushed
            self._watch(Quantity.TORQUE, "flange", abs(mass) / limits.mass, limits.mass, "kg",
                        deviation)  # fmt: skip
            self._watch(Quantity.TORQUE, "tool", force / limits.force, limits.force, "N",
                        deviation)  # fmt: skip
            rubs = abs(patterns.friction) / limits.friction
            self._watch(Quantity.TORQUE, "joints", rubs, limits.friction, "of the friction",
                        deviation)  # fmt: skip
            figures |= {"mass": mass, "force": force, "friction": patterns.friction}
            figures["torque"] = float(shares.max())
        behind = np.abs(deviation.tracking - self._lag * deviation.expected_speeds)
        shares = behind / self._tracking_limit
        figures["tracking"] = float(shares.max())
        for joint, share in enumerate(shares.tolist()):
            self._watch(Quantity.TRACKING, f"joint {joint + 1}", share, limits.tracking[joint],
                        "rad", deviation)  # fmt: skip

    def _geometry(self, deviation: Deviation, figures: dict[str, Any]) -> None:
        if deviation.position is None or deviation.angle is None:
            return
        figures["position"] = deviation.position
        for where, value, limit, unit in (
            ("tool's position", deviation.position, self.limits.position, "m"),
            ("tool's angle", deviation.angle, self.limits.angle, "rad"),
        ):
            self._watch(Quantity.GEOMETRY, where, value / limit, limit, unit, deviation)

    def _path(self, sample: TwinSample, deviation: Deviation, figures: dict[str, Any]) -> None:
        match, limits = deviation.match, self.limits
        if match is None or sample.robot != RobotState.ENABLE:
            return
        delay = match.delay - limits.usual_delay
        figures["path"], figures["delay"] = match.distance, match.delay
        rehearsal = self._predictor.rehearsal
        if not rehearsal.idle:
            self._in_step = False
        elif not deviation.moving and rehearsal.rests_at(sample.expected):
            self._in_step = True
        if self._in_step and deviation.moving:
            # both stood at one place, this program has commanded nothing since, and the arm moves
            self._uncommanded_at = deviation.time
            self._watch(Quantity.PATH, f"joint {match.joint}",
                        max(2.0, match.distance / limits.path), limits.path, "rad",
                        deviation)  # fmt: skip
            return
        self._watch(Quantity.PATH, f"joint {match.joint}", match.distance / limits.path,
                    limits.path, "rad", deviation)  # fmt: skip
        self._watch(Quantity.DELAY, "set-points", delay / limits.delay, limits.delay, "s",
                    deviation)  # fmt: skip

    def _states(self, sample: TwinSample) -> list[Divergence]:
        """States that no command of this program explains."""
        was, at = self._was, sample.time
        if was is None or sample.led:
            return []
        fault = sample.collision or (was.robot == RobotState.ENABLE != sample.robot)
        if not fault or was.collision or at - self._changed_at < _EXPECTED:
            return []
        if Quantity.STATE in self._reported and at - self._reported[Quantity.STATE] < _QUIET:
            return []
        self._reported[Quantity.STATE] = at
        where = (
            f"collision at joint {sample.collision}" if sample.collision
            else f"robot {RobotState(sample.robot).name}"
        )  # fmt: skip
        cause = Cause.UNKNOWN
        if sample.collision:
            cause = Cause.CONTACT
        elif self._commands and sample.safety == was.safety:
            cause = Cause.OTHER_PROGRAM
        return [Divergence(Quantity.STATE, where, at, at, 1.0, 0.0, "", cause, {})]

    # -- from a difference to a divergence -----------------------------------------------------

    def _watch(
        self,
        quantity: Quantity,
        where: str,
        share: float,
        limit: float,
        unit: str,
        deviation: Deviation,
    ) -> None:
        excess = self._excess.get((quantity, where))
        if excess is None:
            if share <= 1.0:
                return  # almost always
            excess = self._excess[quantity, where] = _Excess()
        at = deviation.time
        lasted = excess.update(share, at, deviation.step)
        if not lasted:
            if excess.over:
                del self._excess[quantity, where]
            return
        if quantity in self._reported:
            self._reported[quantity] = at
        elif all(sign.quantity is not quantity for sign in self._signs):
            since, value = excess.since, excess.worst * limit
            self._signs.append(
                Divergence(quantity, where, at, since, value, limit, unit, Cause.UNKNOWN, {})
            )

    def _named(self, at: float, deviation: Deviation) -> list[Divergence]:
        """The divergences whose evidence is complete, with their causes."""
        for quantity, last in tuple(self._reported.items()):
            if at - last > _QUIET:
                del self._reported[quantity]
        if not self._signs or at - self._signs[0].at < _EVIDENCE:
            return []
        signs, self._signs = self._signs, []
        kinds = {sign.quantity for sign in signs}
        found = []
        for sign in signs:
            self._reported[sign.quantity] = at
            cause, estimate = self._cause(sign, kinds, deviation)
            found.append(sign._replace(at=at, cause=cause, estimate=estimate))
        if kinds & {Quantity.PATH, Quantity.DELAY}:
            self._predictor.rehearsal.hide("the arm left the rehearsed path")
            for key in [key for key in self._excess if key[0] in (Quantity.PATH, Quantity.DELAY)]:
                del self._excess[key]
        return found

    def _cause(
        self, sign: Divergence, kinds: set[Quantity], deviation: Deviation
    ) -> tuple[Cause, Mapping[str, float]]:
        if Quantity.GEOMETRY in kinds and sign.quantity in (Quantity.GEOMETRY, Quantity.PATH):
            return Cause.GEOMETRY, {}
        if sign.quantity in (Quantity.PATH, Quantity.DELAY):
            match = deviation.match
            if deviation.time - self._uncommanded_at < _UNCOMMANDED:
                return Cause.OTHER_PROGRAM, {}
            if Quantity.PATH in kinds and match is not None and deviation.moving:
                return Cause.OTHER_PROGRAM, {}
            # the arm is where it should have been earlier, or stands where it should move
            late = 0.0 if match is None else match.delay - self.limits.usual_delay
            return Cause.DELAYED_CONTROLLER, {"delay [s]": late}
        return self._force_cause()

    def _force_cause(self) -> tuple[Cause, Mapping[str, float]]:
        """The cause of external torques, and of tracking errors, which come from these."""
        patterns = self._patterns
        if patterns is None:
            return Cause.UNKNOWN, {}
        if patterns.is_friction:
            return Cause.FRICTION, {"additional share": patterns.friction}
        if patterns.is_mass(sum(self._masses.values()) if self._commands else None):
            cause = Cause.PAYLOAD if patterns.mass > 0.0 else Cause.LOST_PART
            return cause, {"mass [kg]": patterns.mass}
        return Cause.CONTACT, {"force [N]": patterns.pushed}
