"""Checks that the arm is and moves within an envelope: in plain floats, without I/O or clock.

The same code checks the path of a motion before it is sent, each set-point in a stream's worker,
and each sample of the state. For one set-point numpy would be slower, and the worker usually has
not loaded it.

A step of the arm is checked as a sweep: from one configuration to another, straight in joint angles
or straight in the tool's pose. It is fast because a distance to a zone changes by no more than the
body moves, and a body moves by no more than a joint's angle times its distance from the joint's
axis. So `zones` stores for each zone how far a body may move before the zone must be checked again.
The result is the same as if each zone were checked in each sweep.
"""

from __future__ import annotations

import math
from math import cos, hypot, sin
from operator import sub
from typing import TYPE_CHECKING, Any, TypeAlias

from aioduco.envelope.corrected import CorrectedTable
from aioduco.envelope.limits import BODIES, Crossing
from aioduco.envelope.zones import BodyZonePairs, CheckedZone, Point

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


Tip: TypeAlias = "Sequence[float]"
"""The tool's tip in the base frame: its rotation matrix by rows, then x, y, z [m]. Shape (12,)."""
Joints6: TypeAlias = tuple[float, ...]
_Look: TypeAlias = tuple["Sequence[float]", "tuple[Point, ...]", Joints6]

#: depth beyond a limit up to which an arm may stand, because of lag; only deeper it must lead back,
#: and not along the limit [m, rad]
BESIDE = 3e-3
#: share of the speed of a limit with the action "slow" up to which a stream's worker lets the tool
#: go: the arm follows set-points with some overshoot, and the watch of the state stops it above
SLOW_SHARE = 0.9
#: joint deceleration that a stopping arm reaches for certain [rad/s²]
STOPPING = 5.0
_BACK = 1e-5  # least distance by which a path leads back, more than rounding [m, rad]
_SINGULAR = 0.02  # distance from a singularity within which the seed may be on the other branch
_SWING = 1.0  # turn of a joint in one sweep that only a singularity causes [rad]
_HALVINGS = 8  # halvings of a chord before a zone that it passes closely counts as crossed
_NOWHERE = (math.nan, math.nan, math.nan)
_ROUNDING = 1e-9  # upper bound of the rounding error of a summed distance [m]
_UNMARKED: tuple[Sequence[float], float, float] = ((), 0.0, 0.0)
_LONG_WAY = 100.0  # summed distance after which the sum restarts at zero, because of rounding [m]


class EnvelopeChecker:
    """Checks configurations, and sweeps from one to another, against an envelope.

    A configuration is six joint angles [rad], or the pose of the tool's tip (`Tip`). If a limit
    needs the joints of a tip, the checker computes them by inverse kinematics, near those of the
    last configuration.

    Args:
        packed: the result of `Envelope.packed`.
        by_tip: whether configurations are poses of the tip.

    Attributes:
        by_tip: the same.
        seed: joint angles; for a tip, the nearest solution of the inverse kinematics is used [rad].
        deviation: largest deviation of a sweep's path from the straight line, as a share of its
            length.
        slow_share: share of the speed of a limit with the action "slow" up to which it is kept, for
            what follows the arm's speed with less precision.
    """

    def __init__(self, packed: Mapping[str, Any], *, by_tip: bool = False) -> None:
        self._geometry = tuple(packed["geometry"])
        self._corrections: Sequence[Sequence[float]] = packed["corrections"] or ()
        self._lower, self._upper = packed["lower"], packed["upper"]
        self._turn, self._offset = packed["tool"][:9], tuple(packed["tool"][9:])
        self.by_tip: bool = by_tip
        self._zones: list[CheckedZone] = []
        #: name, action, speed and limit value
        self._speeds: list[tuple[str, str, float, float]] = []
        self._joints: list[tuple[str, str, float, float]] = []
        self._singular: list[tuple[str, str, float, float]] = []
        for name, action, speed, kind, *rest in packed["limits"]:
            if kind == "speed":
                self._speeds.append((name, action, speed, *rest))
            elif kind == "joints":
                self._joints.append((name, action, speed, *rest))
            elif kind == "singular":
                self._singular.append((name, action, speed, *rest))
            else:
                self._zones.append(CheckedZone(name, action, speed, kind, *rest))
        self._by_joints = bool(self._joints or self._singular)
        #: whether any limit depends on the speed of the tool
        self.times: bool = bool(self._speeds) or any(
            action == "slow"
            for action in [
                *(zone.action for zone in self._zones),
                *(each[1] for each in self._joints + self._singular),
            ]
        )
        self._needs_joints = self._by_joints or any(1 in zone.bodies for zone in self._zones)
        _, d2, a2, a3, d5, d6 = self._geometry
        tip = hypot(*self._offset)
        forearm = abs(d5) + abs(d6) + tip
        #: largest distance of the tip from the axis of each joint [m]
        self._reaches: Joints6 = (
            abs(d2) + a2 + a3 + forearm,
            a2 + a3 + forearm,
            a3 + forearm,
            forearm,
            abs(d6) + tip,
            hypot(self._offset[0], self._offset[1]),
        )
        #: distance of the elbow from the axes of joints 1 and 2, which alone move it [m]
        self._elbow_reaches = hypot(a2, d2), abs(a2)
        self._table: CorrectedTable | None = None
        if self._corrections:
            self._table = CorrectedTable(self._geometry, self._corrections)
            self._reaches, self._elbow_reaches = self._table.reaches(tip)
        self._lever = tip
        self._elbow = BodyZonePairs(self._zones, (1,))
        self._wrist = BodyZonePairs(self._zones, (0, 2))
        self._solve: Any = None
        self._nearest: Any = None
        self.seed: Joints6 = ()
        self.deviation: float = 0.0
        self.slow_share: float = 1.0
        self._at: Sequence[float] = ()
        #: limits that the arm was beyond when it began to leave them, and its margins there
        self._beyond: dict[str, float] = {}
        self._slack = _ROUNDING
        #: sum of the joints' turns, and the sum at which their margins must be computed next [rad]
        self._turned = self._joints_due = 0.0
        #: start for which `clear` found near zones, and the distances that it checked [m]
        self._marked = _UNMARKED
        self._kept: _Look = ((), (), ())
        self._ahead: _Look = ((), (), ())

    # -- positions of the bodies ---------------------------------------------------------------

    def places(self, config: Sequence[float]) -> tuple[Point, ...]:
        """Positions of tool, elbow and flange [m]; the elbow is NaN if it is not known."""
        return self._look(config)[1]

    def places_ahead(self, config: Sequence[float]) -> tuple[Point, ...]:
        """The same positions for a configuration at which the next sweep ends."""
        return self._look_ahead(config)[1]

    def _look(self, config: Sequence[float]) -> _Look:
        """Positions and joints of the configuration at which a sweep starts (cached)."""
        if self._kept[0] is not config:
            self._kept = self._ahead if self._ahead[0] is config else self._seen(config)
            if self._kept[2]:
                self.seed = self._kept[2]
        return self._kept

    def _look_ahead(self, config: Sequence[float]) -> _Look:
        """Positions and joints of the configuration at which a sweep ends (cached)."""
        if self._kept[0] is config:
            return self._kept
        if self._ahead[0] is not config:
            self._ahead = self._seen(config)
        return self._ahead

    def _seen(self, config: Sequence[float]) -> _Look:
        if self.by_tip:
            return (config, *self._from_tip(config))
        q = tuple(config)
        return config, self._from_joints(q), q

    def _from_joints(self, q: Joints6) -> tuple[Point, ...]:
        if self._table is not None:
            return self._table.places(q, self._offset)
        q1, q2, q3, q4, q5, q6 = q
        d1, d2, a2, a3, d5, d6 = self._geometry
        q23 = q2 + q3
        q234 = q23 + q4
        c1, s1, c, s = cos(q1), sin(q1), cos(q234), sin(q234)
        c5, s5 = cos(q5), sin(q5)
        # Along the horizontal of the arm's plane, its normal, and up.
        eh, eu = a2 * sin(q2), d1 + a2 * cos(q2)
        zh, za, zu = -s5 * c, c5, s5 * s
        fh = eh + a3 * sin(q23) + d5 * s + d6 * zh
        fa = d2 + d6 * za
        fu = eu + a3 * cos(q23) + d5 * c + d6 * zu
        flange = (c1 * fh - s1 * fa, s1 * fh + c1 * fa, fu)
        elbow = (c1 * eh - s1 * d2, s1 * eh + c1 * d2, eu)
        x, y, z = self._offset
        th, ta, tu = fh + z * zh, fa + z * za, fu + z * zu
        if x or y:
            c6, s6 = cos(q6), sin(q6)
            # x and y along the axes of the wrist
            u, v = c6 * x - s6 * y, s6 * x + c6 * y
            th += u * c5 * c - v * s
            ta += u * s5
            tu += -u * c5 * s - v * c
        return (c1 * th - s1 * ta, s1 * th + c1 * ta, tu), elbow, flange

    def _from_tip(self, tip: Tip) -> tuple[tuple[Point, ...], Joints6]:
        r00, r01, r02, r10, r11, r12, r20, r21, r22, x, y, z = tip
        t00, t01, t02, t10, t11, t12, t20, t21, t22 = self._turn
        # The flange's axes: those of the tip, times the inverse rotation of the tool.
        f00, f01, f02 = (
            r00 * t00 + r01 * t01 + r02 * t02,
            r00 * t10 + r01 * t11 + r02 * t12,
            r00 * t20 + r01 * t21 + r02 * t22,
        )
        f10, f11, f12 = (
            r10 * t00 + r11 * t01 + r12 * t02,
            r10 * t10 + r11 * t11 + r12 * t12,
            r10 * t20 + r11 * t21 + r12 * t22,
        )
        f20, f21, f22 = (
            r20 * t00 + r21 * t01 + r22 * t02,
            r20 * t10 + r21 * t11 + r22 * t12,
            r20 * t20 + r21 * t21 + r22 * t22,
        )
        u, v, w = self._offset
        flange = (
            x - (f00 * u + f01 * v + f02 * w),
            y - (f10 * u + f11 * v + f12 * w),
            z - (f20 * u + f21 * v + f22 * w),
        )
        q: Joints6 = ()
        elbow = _NOWHERE
        if self._needs_joints and self.seed:
            rows = (
                (f00, f01, f02, flange[0]),
                (f10, f11, f12, flange[1]),
                (f20, f21, f22, flange[2]),
            )
            q = self._inverse(rows)
            if q:
                elbow = self._from_joints(q)[1]
        return ((x, y, z), elbow, flange), q

    def _inverse(self, rows: Sequence[Sequence[float]]) -> Joints6:
        """The joints for a pose of the flange, nearest to the last ones; empty if it has none."""
        if self._solve is None:
            # Imported here: it imports numpy, and only poses of the tool need it.
            from aioduco.kinematics.geometry import DhCorrections, Geometry  # noqa: PLC0415
            from aioduco.kinematics.single import nearest_turns, solutions  # noqa: PLC0415

            own = DhCorrections(*map(tuple, self._corrections)) if self._corrections else None
            d1, d2, a2, a3, d5, d6 = self._geometry
            geometry = Geometry(d1, d2, a2, a3, d5, d6, own)
            self._solve = lambda flange, q6: solutions(geometry, flange, q6)
            self._nearest = nearest_turns
        seed = self.seed
        turned = [
            self._nearest(found, seed, self._lower, self._upper)
            for found in self._solve(rows, seed[5])
        ]
        inside = sorted((q for q in turned if q is not None), key=lambda q: math.dist(q, seed))
        if not inside:
            return ()
        # Beside a singularity another branch may be nearer, to which the arm does not get.
        here = self._distances(seed)
        for q in inside:
            there = self._distances(q)
            pairs = zip(here, there, strict=True)
            if all(a * b >= 0.0 or max(abs(a), abs(b)) < _SINGULAR for a, b in pairs):
                return tuple(q)
        return tuple(inside[0])

    # -- checks against the limits -------------------------------------------------------------

    def begin(
        self, config: Sequence[float], *, leaving: bool = False, slack: float = 0.0
    ) -> Crossing | None:
        """Set the arm's position. It may be slightly beyond a zone, because of lag or rounding.

        Args:
            config: the position.
            leaving: whether the arm may leave the limits that it is beyond, however far: sweeps
                then may not lead deeper beyond these limits than here, until it has `arrived`.
            slack: how much deeper they may lead all the same [m, rad].

        Returns:
            The limit that the arm is beyond, if any; with `leaving`, none. A limit that slows is
            none of these: an arm that stands is slow enough.
        """
        self._at = config
        self._elbow.begin()
        self._wrist.begin()
        self._turned = self._joints_due = 0.0
        beyond = {each.limit: each for each in self.margins(config) if each.margin < 0.0}
        self._beyond, self._slack = {}, slack + _ROUNDING
        if leaving:
            self._beyond = {
                limit: each.margin for limit, each in beyond.items() if each.action != "slow"
            }
        for zone in self._zones:
            zone.leaving = zone.name in self._beyond
            depth = -beyond[zone.name].margin if zone.name in beyond else 0.0
            zone.tolerance = depth if depth <= BESIDE and not zone.leaving else 0.0
        return self.sweep(config, config, 0.0)

    @property
    def leaving(self) -> bool:
        """Whether the arm leaves limits that it was beyond when it began."""
        return bool(self._beyond)

    @property
    def begun(self) -> bool:
        """Whether the arm's position was set."""
        return bool(self._at)

    def arrived(self, config: Sequence[float]) -> None:
        """Note that the arm gets to a position: once it has left all limits, they hold again."""
        if self._beyond and all(
            each.margin >= 0.0 for each in self.margins(config) if each.limit in self._beyond
        ):
            self.begin(config)

    def not_left(self, config: Sequence[float]) -> Crossing | None:
        """Return a limit that the arm is clearly beyond, if a path to `config` leads not back.

        Args:
            config: the end of a path whose steps `sweep` has allowed.
        """
        for each in self.margins(config) if self._beyond else ():
            start = self._beyond.get(each.limit, 0.0)
            if start < -BESIDE and each.margin < start + _BACK:
                return each
        return None

    def moved(self, config: Sequence[float]) -> None:
        """Set the arm's next position without a check: it is known to be within the limits."""
        elbow, tip, _ = self._travel(self._at, config)
        self._went(config, elbow, tip)
        self._joints_due = 0.0

    def _went(self, config: Sequence[float], bend: float, tip: float) -> None:
        self._at = config
        self._elbow.way += bend
        self._wrist.way += tip
        if self._wrist.way > _LONG_WAY:
            self._elbow.begin()
            self._wrist.begin()
            self._turned = self._joints_due = 0.0

    def clear(self, start: Sequence[float], more: float) -> bool:
        """Set the arm's next position, and decide whether it is safe without a sweep.

        Args:
            start: joint angles of the next position [rad].
            more: length of the braking path after it, as a multiple of the step to it.

        Returns:
            Whether a `sweep` of that path would certainly find nothing: no limit is in reach.
        """
        if self.by_tip or start is self._at:
            return False
        # The sums of `_travel_joints`, written out: a call would take half as long as all of this.
        a1, a2, a3, a4, a5, a6 = self._at
        b1, b2, b3, b4, b5, b6 = start
        r1, r2, r3, r4, r5, r6 = self._reaches
        e1, e2 = self._elbow_reaches
        t1, t2, t3 = abs(b1 - a1), abs(b2 - a2), abs(b3 - a3)
        t4, t5, t6 = abs(b4 - a4), abs(b5 - a5), abs(b6 - a6)
        bend = e1 * t1 + e2 * t2
        tip = r1 * t1 + r2 * t2 + r3 * t3 + r4 * t4 + r5 * t5 + r6 * t6
        turn = t1 + t2 + t3 + t4 + t5 + t6
        self._went(start, bend, tip)
        self._turned += turn
        # Upper bound of the distance of the bodies from their chords during the sweep
        turn *= more
        off = tip * more * (turn / 4 + self.deviation) + _ROUNDING
        elbow, wrist = bend * more + off, tip * more + off
        if self._near(start, elbow, wrist):
            self._marked = start, elbow, wrist
            return False
        return not self._by_joints or self._joints_clear(start, turn + _ROUNDING)

    def may_reach(self, start: Sequence[float], *others: Sequence[float]) -> bool:
        """Whether a limit may be in reach on the way from joint angles to others [rad].

        The way may be any on which each joint turns only towards the next of these angles.
        """
        if start is not self._at:
            self.moved(start)
        elbow = tip = turned = _ROUNDING
        here = start
        for there in others:
            bend, most, _ = self._travel_joints(here, there)
            elbow, tip = elbow + bend, tip + most
            turned += sum(map(abs, map(sub, there, here)))
            here = there
        if self._near(start, elbow, tip):
            return True
        return self._by_joints and not self._joints_clear(start, turned)

    def _joints_clear(self, start: Sequence[float], room: float) -> bool:
        """Whether every joint margin is larger than `room`, the sum of the joints' turns [rad].

        A distance from a joint limit or from a singularity changes by at most that sum.
        """
        if self._turned + room < self._joints_due:
            return True
        _, places, q = self._look(start)
        least = min(each.margin for each in self._joint_margins(q, places[0]))
        if least <= room:
            return False
        self._joints_due = self._turned + least
        return True

    def _near(self, start: Sequence[float], elbow: float, wrist: float) -> bool:
        """Whether a zone may be in reach of the bodies, which move up to these distances [m]."""
        near = False
        if self._wrist.way + wrist >= self._wrist.soonest:
            near = self._wrist.look(self._look(start)[1], wrist)
        if self._elbow.way + elbow >= self._elbow.soonest:
            near = self._elbow.look(self._look(start)[1], elbow) or near
        return near

    def sweep(
        self, start: Sequence[float], end: Sequence[float], speed: float = math.inf
    ) -> Crossing | None:
        """Check the straight path from one configuration to another, both included.

        Args:
            start: the first configuration, at or near the last one.
            end: the configuration at the end.
            speed: speed of the tool meanwhile [m/s]; limits with the action "slow" allow motions
                up to their speed.

        Returns:
            The limit that would be crossed, if any.
        """
        if start is not self._at:
            self.moved(start)
        elbow = tip = sag = 0.0
        if end is not start:
            elbow, tip, sag = self._travel(start, end)
            if self.deviation:
                sag += self.deviation * tip
        elbow += sag + _ROUNDING
        tip += sag + _ROUNDING
        marked, most_elbow, most_tip = self._marked
        # `clear` has just marked the near zones, so they are not searched again
        if (marked is start and elbow <= most_elbow and tip <= most_tip) or self._near(
            start, elbow, tip
        ):
            self._marked = _UNMARKED
            # Compute how far the bodies really move; it is usually much less than the bound.
            places = self._look(start)[1]
            further = places if end is start else self._look_ahead(end)[1]
            chords = [math.dist(a, b) for a, b in zip(places, further, strict=True)]
            found = None
            for zone in self._zones:
                near, zone.near = zone.near, False
                slow = zone.action == "slow" and speed <= zone.speed * self.slow_share
                if not near or found or slow:
                    continue
                if zone.leaving:
                    continue
                found = self._sweep_zone(zone, places, further, chords, sag)
            if found is not None:
                return found
        if self._by_joints and (found := self._sweep_joints(start, end, speed)):
            return found
        return self._deeper(end) if self._beyond else None

    def _deeper(self, end: Sequence[float]) -> Crossing | None:
        """Return a limit that the arm leaves, if it is deeper beyond it at `end` than it was."""
        _, places, q = self._look_ahead(end)
        for each in self._margins(places, q):
            if each.margin < self._beyond.get(each.limit, -math.inf) - self._slack:
                return each
        return None

    def too_fast(self, speed: float) -> Crossing | None:
        """Check a speed of the tool [m/s], NaN if it is not known; the margin is in m/s."""
        for name, action, _, most in self._speeds:
            if not speed <= most * (self.slow_share if action == "slow" else 1.0):
                return Crossing(name, "tool", self._tool_place(), most - speed, "m/s", action)
        return None

    def _tool_place(self) -> Point:
        return self._kept[1][0] if self._kept[1] else _NOWHERE

    def slow_speed(self, name: str) -> float:
        """The speed up to which a limit with the action "slow" is kept [m/s]."""
        speeds = {zone.name: zone.speed for zone in self._zones}
        speeds |= {title: most for title, _, _, most in self._speeds}
        speeds |= {each[0]: each[2] for each in self._joints + self._singular}
        return speeds[name] * self.slow_share

    def margins(self, config: Sequence[float]) -> list[Crossing]:
        """Margins of a configuration: to zones (nearest body), joint limits and singularities.

        If no joints reach the configuration, limits that need them are left out, as is a zone for
        the elbow alone.
        """
        _, places, q = self._look(config)
        return self._margins(places, q)

    def _margins(self, places: Sequence[Point], q: Joints6) -> list[Crossing]:
        found = []
        for zone in self._zones:
            bodies = [body for body in zone.bodies if _known(places[body])]
            if not bodies:
                continue
            margin, body = min((zone.margin(*places[body]), body) for body in bodies)
            found.append(Crossing(zone.name, BODIES[body], places[body], margin, "m", zone.action))
        return found + (self._joint_margins(q, places[0]) if q else [])

    def _sweep_zone(
        self,
        zone: CheckedZone,
        places: Sequence[Point],
        further: Sequence[Point],
        chords: Sequence[float],
        sag: float,
    ) -> Crossing | None:
        for body in zone.bodies:
            a, b = places[body], further[body]
            if a[0] != a[0] or b[0] != b[0]:
                continue  # not known, because no joints reach it
            first = zone.margin(*a) + zone.tolerance
            last = first if a is b else zone.margin(*b) + zone.tolerance
            low = first if first < last else last
            # The margin is at least low - sag - chord; the path is checked only if that is below 0.
            if 0.0 <= low < sag + chords[body]:
                low = self._lowest(zone, a, b, first, last, sag)
            if low < 0.0:
                place = a if first < last else b
                return Crossing(zone.name, BODIES[body], place, low, "m", zone.action)
        return None

    def _lowest(
        self, zone: CheckedZone, a: Point, b: Point, first: float, last: float, sag: float
    ) -> float:
        """A lower bound of the margin on the path between two positions; only its sign is exact."""
        low = first if first < last else last
        if not zone.keep_out:
            # The margin is at least the linear interpolation of both margins, minus the arc's sag.
            rise = last - first
            if sag <= 0.0 or abs(rise) >= 4 * sag:
                return low
            return first - (4 * sag - rise) ** 2 / (16 * sag)
        todo = [(a, b, first, last, 0.0, 1.0, _HALVINGS)]
        while todo:
            a, b, first, last, begin, end, left = todo.pop()
            # The arc's distance from its chord is largest half-way, and zero at its ends.
            half = min(max(0.5, begin), end)
            off = 4 * sag * half * (1 - half)
            bound = (first + last - math.dist(a, b)) / 2 - off
            if bound >= 0.0:
                continue
            middle = (begin + end) / 2
            mid = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2)
            between = zone.margin(*mid) + zone.tolerance
            if left == 0 or between < 4 * sag * middle * (1 - middle):
                return min(bound, between)
            todo.append((a, mid, first, between, begin, middle, left - 1))
            todo.append((mid, b, between, last, middle, end, left - 1))
        return low

    def _travel(self, start: Sequence[float], end: Sequence[float]) -> tuple[float, float, float]:
        """Upper bounds of the bodies' motion between two configurations [m].

        Returns:
            Distance of the elbow; of tool and flange; and deviation of their paths from the chords.
        """
        if not self.by_tip:
            return self._travel_joints(start, end)
        turn = _turned(start, end)
        sag = self._lever * turn * turn / 8
        if not self._needs_joints:
            return 0.0, math.dist(start[9:], end[9:]) + self._lever * turn, sag
        a, b = self._look(start)[2], self._look_ahead(end)[2]
        if not a or not b:
            return math.inf, math.inf, sag
        elbow, tip, bend = self._travel_joints(a, b)
        return elbow, tip, sag + bend

    def _travel_joints(self, a: Sequence[float], b: Sequence[float]) -> tuple[float, float, float]:
        a1, a2, a3, a4, a5, a6 = a
        b1, b2, b3, b4, b5, b6 = b
        r1, r2, r3, r4, r5, r6 = self._reaches
        e1, e2 = self._elbow_reaches
        t1, t2, t3 = abs(b1 - a1), abs(b2 - a2), abs(b3 - a3)
        t4, t5, t6 = abs(b4 - a4), abs(b5 - a5), abs(b6 - a6)
        l1, l2, l3, l4, l5, l6 = r1 * t1, r2 * t2, r3 * t3, r4 * t4, r5 * t5, r6 * t6
        # The second derivative of a point by two joint angles is no longer than the point's
        # distance from the axis of the joint nearer to the tool.
        t12 = t1 + t2
        t13 = t12 + t3
        t14 = t13 + t4
        bend = (
            l1 * t1
            + l2 * (t2 + 2 * t1)
            + l3 * (t3 + 2 * t12)
            + l4 * (t4 + 2 * t13)
            + l5 * (t5 + 2 * t14)
            + l6 * (t6 + 2 * (t14 + t5))
        )
        return e1 * t1 + e2 * t2, l1 + l2 + l3 + l4 + l5 + l6, bend / 8

    def _sweep_joints(
        self, start: Sequence[float], end: Sequence[float], speed: float
    ) -> Crossing | None:
        q = self._look(start)[2]
        places = self._kept[1]
        found = self._joint_margins(q, places[0]) if q else []
        passed: list[Crossing] = []
        if end is not start:
            _, further, ahead = self._look_ahead(end)
            if ahead:
                found += self._joint_margins(ahead, further[0])
                if q:
                    passed = self._passed(q, ahead, further[0])
        if self._beyond:
            found = [each for each in found if each.limit not in self._beyond]
        found += passed
        for crossing in found:
            if crossing.margin < 0.0 and not (
                crossing.action == "slow" and speed <= self.slow_speed(crossing.limit)
            ):
                return crossing
        return None

    def _joint_margins(self, q: Joints6, place: Point) -> list[Crossing]:
        found = []
        for name, action, _, least in self._joints:
            inside = [
                min(angle - low, high - angle)
                for angle, low, high in zip(q, self._lower, self._upper, strict=True)
            ]
            nearest = min(inside)
            joint = f"joint {inside.index(nearest) + 1}"
            found.append(Crossing(name, joint, _NOWHERE, nearest - least, "rad", action))
        if self._singular:
            distance = min(map(abs, self._distances(q)))
            found += [
                Crossing(name, "arm", place, distance - least, "", action)
                for name, action, _, least in self._singular
            ]
        return found

    def _passed(self, q: Joints6, ahead: Joints6, place: Point) -> list[Crossing]:
        """The limits that a sweep through a singularity, or closely beside one, crosses."""
        if not self._singular:
            return []
        # The tool passes closely beside one while joints swing round, and keeps its branch.
        swings = self.by_tip and max(map(abs, map(sub, ahead, q))) > _SWING
        pairs = zip(self._distances(q), self._distances(ahead), strict=True)
        if not swings and all(a * b >= 0.0 for a, b in pairs):
            return []
        return [
            Crossing(name, "arm", place, -least, "", action)
            for name, action, _, least in self._singular
        ]

    def _distances(self, q: Joints6) -> tuple[float, float, float]:
        """Signed distances from the singularities of shoulder, elbow and wrist."""
        _, _, a2, a3, d5, _ = self._geometry
        q23 = q[1] + q[2]
        ahead = a2 * sin(q[1]) + a3 * sin(q23) + d5 * sin(q23 + q[3])
        return ahead / (a2 + a3 + d5), sin(q[2]), sin(q[4])


def _known(place: Point) -> bool:
    return place[0] == place[0]


def _turned(start: Tip, end: Tip) -> float:
    """The angle between two orientations [rad]."""
    trace = sum(a * b for a, b in zip(start[:9], end[:9], strict=True))
    return math.acos(max(-1.0, min(1.0, (trace - 1) / 2)))
