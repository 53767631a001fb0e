"""Keeps the arm within its operating envelope: checks motions, and sets up the checks of streams.

Everything that moves the arm is checked before it is sent, as far as its path is known: a motion
and a servo set-point by their paths, a motion at a velocity and a jog by where the arm gets until a
stop takes effect, other motions by the points that they name. An arm that is beyond a limit is sent
only what is known to lead back. So a program that goes on commanding comes no closer, however often
it tries.

A stream's worker checks each set-point itself (`streaming/worker/checked.py`), and the watch of the
state (`envelope_watch.py`) stops all other movement.
"""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

from aioduco._process import trial
from aioduco._process.platform import boot_time
from aioduco.envelope.checker import BESIDE
from aioduco.envelope.limits import Crossing, Envelope, ToolForce
from aioduco.errors import ControllerError, EnvelopeViolated, ParameterError
from aioduco.models.samples import joints as joints_of
from aioduco.models.samples import pose as pose_of
from aioduco.supervision.concurrency import every

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from aioduco._wire.rpc import AsyncRpc
    from aioduco.envelope.ways import CutCorner, Leg, Way
    from aioduco.models.pose import Joints, Pose
    from aioduco.models.version import Manual
    from aioduco.supervision.envelope_watch import EnvelopeWatch
    from aioduco.supervision.state_feed import StateFeed
    from aioduco.supervision.stop_coordinator import StopCoordinator
    from aioduco.supervision.task import Task
    from aioduco.supervision.task_command import Command


_NOWHERE = (math.nan, math.nan, math.nan)
#: slowest joint and tool speed that the wire accepts [rad/s, m/s], and percent
_SLOWEST_SERVO = 0.000175
_SLOWEST = {
    "movej2": 0.000175,
    "movej2_eaxis": 0.000175,
    "movej_pose2": 0.000175,
    "movej": 0.01,
    "movej_pose": 0.01,
}
_SLOWEST_LINE = 0.01
#: seconds between two looks whether what was resumed is over
_LOOK_EVERY = 0.05
#: motions of external axes alone
_NOT_THE_ARM = ("move_eaxis", "move_jog_eaxis")


class _Frames(NamedTuple):
    """The frames of a motion, and their names; an empty name stands for the one in use."""

    tool: Pose
    wobj: Pose
    names: tuple[str, str]


@dataclass(slots=True)
class _Checked:
    """The last motion that was checked, and found to be within the envelope.

    Attributes:
        way: its path, at its speed; a servo set-point's leads to its target.
        tool: its tool in the flange's frame.
        newest: the newest motion when it was checked: if there is a newer one, it was accepted.
        servo: function of the wire, if it is a servo set-point.
        frames: the frames of a servo set-point.
        a: the acceleration of a servo set-point [rad/s²].
    """

    way: Way
    tool: Pose
    newest: Task | None
    servo: str = ""
    frames: _Frames | None = None
    a: float = math.inf


async def fits(rpc: AsyncRpc, of_arm: Callable[[Joints, Pose], bool]) -> bool:
    """Whether an arm may be the one that stands there, by the place of its flange.

    Args:
        rpc: the functions of the controller.
        of_arm: `Arm.fits` of the arm.
    """
    try:
        flange = pose_of(await rpc.get_flange_pose())
    except ControllerError:
        return True  # this controller does not report it
    return of_arm(joints_of(await rpc.get_actual_joints_position()), flange)


class EnvelopeKeeper:
    """Keeps one arm within its envelope, if there is one.

    Args:
        coordinator: brings the arm to rest.
        rpc: reads the position of the arm, its tool and its work object.
        feed: samples of the state; they have forces if the envelope needs them.
        watch: watches the state, and has the envelope.

    Attributes:
        manual: the manual that the controller follows; None if that is not known.
    """

    def __init__(
        self,
        coordinator: StopCoordinator,
        rpc: AsyncRpc,
        feed: StateFeed,
        watch: EnvelopeWatch,
    ) -> None:
        self._coordinator = coordinator
        self._rpc = rpc
        self._feed = feed
        self._watch = watch
        self.manual: Manual | None = None
        self._open = False
        #: whether something was asked for that may move the arm, and may not be sent yet
        self._asked = False
        #: the envelope whose arm was found to be the one that is there
        self._fitting: Envelope | None = None
        self._last: _Checked | None = None
        #: tools and work objects by name, as they were read while the arm stood, and those in use
        #: then
        self._named: dict[tuple[tuple[str, str], Pose, Pose], _Frames] = {}

    # -- which envelope ------------------------------------------------------------------------

    @property
    def envelope(self) -> Envelope | None:
        """The envelope; None for none."""
        return self._watch.envelope

    def use(self, envelope: Envelope | None) -> None:
        """Keep the arm within another envelope from now on; None for none."""
        if envelope is not None and not isinstance(envelope, Envelope):
            raise ParameterError("envelope", envelope, "an Envelope, or None")
        if self._open:
            self._coordinator.check_loop("envelope")
        if envelope is not None:
            # Loaded now, with numpy, and not by the first check while the arm moves.
            from aioduco.envelope import servo, velocities  # noqa: F401, PLC0415
        # counted, so that the program cannot switch off what the limit needs
        self._feed.force_readers += _needs_forces(envelope) - _needs_forces(self.envelope)
        self._watch.use(envelope)
        self._last = None
        moves = self._asked or self._live or self._coordinator.streams
        if self._open and envelope is not None and moves:
            self._watch.moves_unchecked()  # by another envelope, or by none
        self.begin(opened=self._open)

    def begin(self, *, opened: bool = True) -> None:
        """Start to watch the state, once the robot is open and has an envelope."""
        self._open = opened
        if opened and self.envelope is not None:
            self._watch.begin()

    def strays(self, name: str, *, on: bool = True) -> None:
        """Note whether motions may leave their paths, or be faster than asked.

        Args:
            name: the function of the wire that makes them do so.
            on: whether they may from now on.
        """
        if on:
            self._watch.strays.add(name)
        else:
            self._watch.strays.discard(name)

    # -- motions -------------------------------------------------------------------------------

    @property
    def _live(self) -> bool:
        """Whether something of this program moves the arm, or is about to."""
        coordinator = self._coordinator
        # what was resumed, and the rest of a blocking call that was answered early, have no task
        taskless = coordinator.gate.resumed or coordinator.modes.moving
        return bool(taskless or coordinator.follower.motions or coordinator.pending)

    async def _resumed_over(self) -> None:
        """Wait until what was resumed, and has no task here, is over, unless it moves or is paused.

        Until the arm has stood for a while, it may begin to move by that, on an unknown path.
        """
        coordinator = self._coordinator
        async for _ in every(_LOOK_EVERY):
            if not coordinator.gate.resumed or coordinator.busy:
                return
            if not await coordinator.stands() or await coordinator.paused():
                return
            coordinator.gate.seen(boot_time(), standing=True)

    async def check(self, command: Command) -> Command:
        """Check that a motion stays within the envelope; return it, slowed down if necessary."""
        envelope, watch, name = self.envelope, self._watch, command.name
        self._asked = True
        if trial.current is not None:
            trial.current.checked(name)
        if envelope is None or name in _NOT_THE_ARM:
            return command
        await self._resumed_over()
        if not self._live:
            watch.unchecked, watch.velocity = False, None
        await self._check_arm(name, envelope)
        from aioduco.envelope import servo, velocities, ways  # noqa: PLC0415  # loads numpy

        before, self._last = self._last, None
        newest = next(reversed(self._coordinator.follower.motions), None)
        if before is not None and (newest is None or newest is before.newest):
            before = None  # it has ended, or the controller refused it
        try:
            if name in servo.SERVO:
                return await self._servo(envelope, command, before, newest)
            if name in velocities.VELOCITIES and not velocities.is_step(name, command.args):
                return await self._velocity(envelope, command, before)
            if name in ways.WAYS or name in velocities.VELOCITIES:
                return await self._motion(envelope, command, before, newest)
            return await self._unknown(envelope, command)
        except EnvelopeViolated:
            self._last = before  # it goes on, since this one is refused
            raise

    async def _motion(
        self, envelope: Envelope, command: Command, before: _Checked | None, newest: Task | None
    ) -> Command:
        """Check a motion whose whole path is known."""
        from aioduco.envelope import velocities, ways  # noqa: PLC0415  # loads numpy

        name, args, live = command.name, command.args, self._live
        _, _, tool, wobj, _ = ways.WAYS.get(name, (0, 0, None, None, False))
        names = ("" if tool is None else args[tool], "" if wobj is None else args[wobj])
        frames = await self._frames(*names, standing=not live)
        if frames is None:
            return await self._unknown(envelope, command)
        q = await self._joints() if before is None else before.way.end
        start = ways.Start(q, frames.tool, frames.wobj)
        if name in ways.WAYS:
            way = ways.way_of(envelope.arm, name, args, start)
        else:
            step = velocities.Ahead(name, args, command.sense)
            way = velocities.velocity_way(envelope.arm, step, start, 0.0)
        if way is None:
            return await self._unknown(envelope, command)
        checker = self._watch.checker(envelope, frames.tool, by_tip=way.by_tip)
        checker.seed = q
        found, share = ways.check_way(checker, way)
        if found is None and before is not None:
            following = ways.Leg(replace(way, v=share * way.v), frames.tool)
            corner = self._corner(envelope, before, following)
            found, share = corner.crossing, corner.share * share
            if corner.watched:
                self._watch.moves_unchecked()
        if found is not None:
            await self._refuse(command.name, found)
        command = await self._slower(envelope, command, share)
        if live and before is None:
            self._watch.moves_unchecked()  # it begins where something unknown ends
        else:
            self._last = _Checked(replace(way, v=share * way.v), frames.tool, newest)
        return command

    def _corner(self, envelope: Envelope, before: _Checked, after: Leg) -> CutCorner:
        """Check the corner between two motions, for the tool of each."""
        from aioduco.envelope import ways  # noqa: PLC0415  # loads numpy

        legs = ways.Leg(before.way, before.tool), after
        tools = {leg.tool for leg in legs}
        by_tip = len(tools) == 1 and all(leg.way.by_tip for leg in legs)
        corner = ways.CutCorner(None)
        for tool in tools:
            checker = self._watch.checker(envelope, tool, by_tip=by_tip)
            corner = ways.cut_corner(checker, envelope.arm, *legs).stricter(corner)
        return corner

    async def _servo(
        self, envelope: Envelope, command: Command, before: _Checked | None, newest: Task | None
    ) -> Command:
        """Check a servo set-point; this asks the controller for nothing while they follow fast."""
        from aioduco.envelope import servo, ways  # noqa: PLC0415  # loads numpy

        name, args = command.name, command.args
        tool, wobj = servo.SERVO[name]
        names = ("" if tool is None else args[tool], "" if wobj is None else args[wobj])
        chain = before if before is not None and before.servo == name else None
        frames = None if chain is None else self._still_used(chain.frames, names)
        if frames is None:
            frames = await self._frames(*names, standing=not self._live)
        if frames is None:
            return await self._unknown(envelope, command)
        sample = None if chain is None else self._watch.fresh()
        if sample is not None:
            here = tuple(sample.status.joints)
        else:
            here = await self._joints() if before is None or chain else before.way.end
        last = before.way.end if before is not None else here
        start = ways.Start(here, frames.tool, frames.wobj)
        target = servo.servo_target(envelope.arm, name, args, start, last)
        if target is None:
            return await self._unknown(envelope, command)
        v, a = float(args[1]), float(args[2])
        slowing = None
        if chain is not None and a < chain.a and sample is not None:
            slowing = servo.braking(here, sample.status.joint_speeds.tolist(), a)
        checker = self._watch.checker(envelope, frames.tool)
        of_tool = name in servo.BY_TOOL and self.manual != "3.8"
        of_joints = not of_tool or self.manual is None  # which of the two is not known
        found, share = servo.check_servo(
            checker, here, last, target, v * of_joints, slowing, v * of_tool
        )
        if found is not None:
            await self._refuse(name, found)
        command = await self._slower(envelope, command, share)
        if before is None and any(task.name != name for task in self._coordinator.follower.motions):
            self._watch.moves_unchecked()  # it begins where something unknown ends
        else:
            self._watch.wobj = frames.wobj if wobj is not None and not names[1] else None
            way = ways.polyline([last, target], v)
            self._last = _Checked(way, frames.tool, newest, name, frames, a)
        return command

    async def _velocity(
        self, envelope: Envelope, command: Command, before: _Checked | None
    ) -> Command:
        """Check a motion at a velocity, or a jog that a command ends, until a stop takes effect."""
        from aioduco.envelope import velocities, ways  # noqa: PLC0415  # loads numpy

        motion = velocities.Ahead(command.name, command.args, command.sense)
        if motion.stands:
            self._watch.velocity = None
            return command
        frames = await self._frames("", "", standing=not self._live)
        assert frames is not None
        starts = [await self._joints()]
        if before is not None:
            starts.append(before.way.end)  # if it begins there
        share = 1.0
        for q in starts:
            start = ways.Start(q, frames.tool, frames.wobj)
            way = velocities.velocity_way(envelope.arm, motion, start, self._watch.reaction)
            if way is None:
                return await self._unknown(envelope, command)
            checker = self._watch.checker(envelope, frames.tool, by_tip=way.by_tip)
            checker.seed = q
            found, slowed = ways.check_way(checker, way)
            if found is not None:
                await self._refuse(command.name, found)
            share = min(share, slowed)
        command = await self._slower(envelope, command, share)
        self._watch.velocity = motion._replace(args=command.args), frames.wobj
        self._watch.moves_unchecked()
        return command

    async def _unknown(self, envelope: Envelope, command: Command) -> Command:
        """Check a motion whose path the controller chooses: by the points that it names."""
        from aioduco.envelope import ways  # noqa: PLC0415  # loads numpy

        name, args = command.name, command.args
        points: Sequence[Sequence[float]] | None = None
        tool = None
        if name in ways.POINTS:
            _, tool_at, wobj_at = ways.POINTS[name]
            frames = await self._frames(args[tool_at], args[wobj_at], standing=not self._live)
            if frames is not None:
                start = ways.Start(await self._joints(), frames.tool, frames.wobj)
                points = ways.points_of(envelope.arm, name, args, start)
                tool = frames.tool
        await self._check_unknown(envelope, name, [[point] for point in points or ()], tool)
        return command

    async def admit(self, name: str, joints: Sequence[Sequence[float]], *, moves: bool) -> None:
        """Check positions that the controller is given outside of a motion, to follow them.

        Args:
            name: the function of the wire.
            joints: the positions, between which the arm goes straight [rad]; empty if they are
                not known in joints.
            moves: whether the arm may follow them at once.

        Raises:
            EnvelopeViolated: the way between them is beyond a limit, or the arm is; nothing was
                sent.
        """
        envelope = self.envelope
        if envelope is not None and (joints or moves):
            await self._check_arm(name, envelope)
            paths = [joints] if joints else []
            await self._check_unknown(envelope, name, paths, moves=moves)

    async def _check_unknown(
        self,
        envelope: Envelope,
        name: str,
        paths: Sequence[Sequence[Sequence[float]]] = (),
        tool: Pose | None = None,
        *,
        moves: bool = True,
    ) -> None:
        """Check that the arm is within the limits, and what is known of its path, too.

        Args:
            envelope: the envelope.
            name: the function of the wire.
            paths: parts of the path: positions between which it is straight [rad].
            tool: the tool at these positions; None for the one in use.
            moves: whether the arm is about to move.
        """
        from aioduco.envelope import ways  # noqa: PLC0415  # loads numpy

        used = pose_of(await self._rpc.get_tcp_offset())
        if moves:
            for each in self._watch.checker(envelope, used).margins(await self._joints()):
                if each.margin < -BESIDE and each.action != "slow":
                    await self._refuse(name, each, "it is not known to lead back from")
        checker = self._watch.checker(envelope, tool or used)
        for path in paths:
            configs = ways.polyline([tuple(point) for point in path], 0.0).configs
            checker.begin(configs[0])
            for here, there in pairwise([configs[0], *configs]):
                # The controller chooses the speed: limits that slow do not apply.
                if (found := checker.sweep(here, there, 0.0)) is not None:
                    await self._refuse(name, found)
        if moves:
            self._watch.moves_unchecked()

    async def _slower(self, envelope: Envelope, command: Command, share: float) -> Command:
        """Return a motion with a share of its speed; as it is if it may have all of it."""
        if share >= 1.0:
            return command
        if trial.current is not None:
            trial.current.slowed(share)
        from aioduco.envelope import servo, velocities, ways  # noqa: PLC0415  # loads numpy

        name, args = command.name, command.args
        if name in velocities.VELOCITIES:
            ahead = velocities.Ahead(name, args, command.sense)
            return replace(command, args=velocities.slower_velocity(ahead, share))
        at = 1 if name in servo.SERVO else ways.WAYS[name][0]
        least = _SLOWEST_SERVO if name in servo.SERVO else _SLOWEST.get(name, _SLOWEST_LINE)
        speed = args[at] * share
        if speed < least:
            limits = zip(envelope.titles, envelope.limits, strict=True)
            slow = " or ".join(title for title, limit in limits if limit.action == "slow")
            found = Crossing(slow, "tool", _NOWHERE, speed - least, "", "refuse")
            why = f"its envelope wants a speed of {speed:.2g}, below the least one, {least:g}"
            await self._refuse(name, found, why)
        return replace(command, args=(*args[:at], speed, *args[at + 1 :]))

    async def _refuse(
        self, name: str, found: Crossing, why: str = "it would lead beyond the envelope"
    ) -> None:
        """Raise the error for what leads beyond a limit; only in a trial it may be sent."""
        if trial.current is not None and trial.current.beyond(name, found):
            self._watch.only_unchecked = True
            return
        done = "was not sent"
        if found.action == "stop":
            await self._coordinator.halt()
            done = "was not sent, and the arm was stopped"
        raise EnvelopeViolated(
            f"{name} {done}: {why}: {found}. Choose another "
            "way or target, or change robot.envelope",
            *found[:4],
        )

    async def _check_arm(self, name: str, envelope: Envelope) -> None:
        """Check that it is watched; and once, while it stands, that the envelope was made for it.

        Raises:
            StaleState: no samples come; nothing was sent.
            ParameterError: it was made for another arm; nothing was sent.
        """
        self._watch.require_samples(name)
        if envelope is self._fitting or self._live:
            return
        if not await fits(self._rpc, envelope.arm.fits):
            expected = (
                f"one of the arm that is there, whose flange is not where a {envelope.arm.name}"
            )
            raise ParameterError("robot.envelope", envelope, f"{expected} has it")
        self._fitting = envelope

    async def _joints(self) -> tuple[float, ...]:
        return tuple(joints_of(await self._rpc.get_actual_joints_position()))

    async def _frames(self, tool: str, wobj: str, *, standing: bool) -> _Frames | None:
        """Return the tip of a tool in the flange's frame, and a work object in the base frame.

        The wire has these poses only for the tool and work object in use. For others it has the
        pose of a tool in a work object, from which both are computed while the arm stands.

        Args:
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            standing: whether the arm stands.

        Returns:
            Both; None if they cannot be known now.
        """
        rpc, names = self._rpc, (tool, wobj)
        self._watch.tool = used = pose_of(await rpc.get_tcp_offset())
        base = pose_of(await rpc.get_wobj())
        if not tool and not wobj:
            return _Frames(used, base, names)
        key = names, used, base
        if not standing:
            return self._named.get(key)
        flange = pose_of(await rpc.get_flange_pose())
        if wobj:
            seen = await rpc.get_tcp_pose_coord("", wobj)
            if not seen:
                return None  # no work object has this name: the controller refuses the motion
            other = flange @ used @ pose_of(seen).inverse()
        else:
            other = base
        if tool:
            seen = await rpc.get_tcp_pose_coord(tool, "")
            if not seen:
                return None
            used = flange.inverse() @ base @ pose_of(seen)
        self._named[key] = found = _Frames(used, other, names)
        return found

    @contextlib.contextmanager
    def redefining(self) -> Iterator[None]:
        """Forget tools and work objects, of which one is defined anew within the block."""
        self._forget_frames()
        if self._coordinator.streams:
            self._watch.moves_unchecked()  # its worker goes on with the frame as it was
        try:
            yield
        finally:
            self._forget_frames()

    def _forget_frames(self) -> None:
        self._named.clear()
        if self._last is not None:
            self._last.frames = None

    def _still_used(self, frames: _Frames | None, names: tuple[str, str]) -> _Frames | None:
        """Return frames if they have these names, and no sample showed others in use."""
        watch = self._watch
        if frames is None or frames.names != names:
            return None
        if not names[0] and watch.tool != frames.tool:
            return None
        if not names[1] and watch.wobj is not None and watch.wobj != frames.wobj:
            return None
        return frames

    # -- streams -------------------------------------------------------------------------------

    async def of_stream(
        self, name: str, tool: str, wobj: str, *, speeds: bool
    ) -> tuple[dict[str, Any], list[float], float] | None:
        """Return the limits against which a stream's worker checks its set-points.

        Args:
            name: name of the stream.
            tool: name of the tool of the set-points; empty for the one in use.
            wobj: name of the work object of the set-points; empty for the one in use.
            speeds: whether the set-points are speeds. Then the state is watched as well.

        Returns:
            The packed envelope; the pose of the work object; and the time within which the watch of
            the state stops the arm [s]. None if nothing is checked.
        """
        self._asked = True
        # before, the arm and what moved it would be looked at too early
        await self._coordinator.permits.stops_ended()
        if (envelope := self.envelope) is None:
            return None
        await self._resumed_over()
        if not self._live:  # else the stream is not opened
            self._watch.unchecked, self._watch.velocity, self._last = False, None, None
        await self._check_arm(name, envelope)
        frames = await self._frames(tool, wobj, standing=True)
        if frames is None:
            await self._check_unknown(envelope, name)
            return None
        if speeds:
            self._watch.moves_unchecked()
        return envelope.packed(frames.tool), list(frames.wobj), self._watch.reaction


def _needs_forces(envelope: Envelope | None) -> bool:
    """Whether samples must have forces."""
    limits = () if envelope is None else envelope.limits
    return any(isinstance(each, ToolForce) for each in limits)
