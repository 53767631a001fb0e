"""Servo streams (servoj, servoj_pose, servo_tcp, servol; manual 1.3.5)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Unpack

from aioduco.api.streams import StreamMaker
from aioduco.api.streams.arguments import ServoGains, motion_limits, per_group
from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.models.rules import listed
from aioduco.streaming.shared.config import StreamSpec
from aioduco.streaming.shared.options import Feeding, WorkerOptions
from aioduco.streaming.shared.space import POSE_SPACE, Limits
from aioduco.streaming.shared.turning import MotionFrame, into_tool
from aioduco.streaming.stream import Stream

if TYPE_CHECKING:
    from aioduco.api.streams.arguments import FeedingOptions, ServoOptions
    from aioduco.models.rules import Real, VectorLike


_Pair = tuple[float, float]
_NOWHERE = (0.0,) * 6


class OffsetStream(Stream):
    """A stream of offsets of the tool, each relative to the end of the one before."""

    def _placed(self, values: tuple[float, ...]) -> tuple[float, ...]:
        """Add an offset to the earlier ones, relative to the tool at the stream's start.

        The axes are those of the tool at that time, or those of the frame in which offsets are
        given.
        """
        space = POSE_SPACE
        start, offset = space.decode(self._last or _NOWHERE), space.decode(values)
        if self._sent.turning is None:
            return space.encode(space.composed(start, offset))
        none = space.decode(_NOWHERE)
        return space.encode(space.moved(start, space.difference(none, offset)))

    def _checked(self, name: str, given: VectorLike) -> tuple[float, ...]:
        """Check an offset, also its size."""
        values = tuple(self._check(name, given))
        self._check_step(values, _NOWHERE, name)
        return values

    async def send(self, point: VectorLike) -> None:
        """Send one offset.

        Args:
            point: the offset (x, y, z [m], rx, ry, rz [rad]). Shape (6,).

        Raises:
            ParameterError: it is not allowed; nothing was sent, and the stream continues.
            SetPointTooFar: it is larger than the stream allows; nothing was sent.
            StreamError: the stream has ended; the error says why.
        """
        await self._feed((self._checked("point", point),), self._feeding.queued)

    async def play(self, trajectory: Any, times: Any = None) -> None:
        """Send a list of offsets, and wait until the worker has taken them.

        Args:
            trajectory: the offsets. Shape (n, 6).
            times: not accepted: an offset is a distance without a time.

        Raises:
            ParameterError: an offset is not allowed, or times were given; nothing was sent.
            SetPointTooFar: an offset is larger than the stream allows; nothing was sent.
            StreamError: the stream has ended; the error says why.
        """
        if times is not None:
            raise ParameterError("times", times, "left out: an offset says how far, not when")
        given = listed("trajectory", trajectory, "a list of offsets")
        offsets = [self._checked(f"trajectory[{index}]", each) for index, each in enumerate(given)]
        async with self._ended_by_interrupts():
            if offsets:
                await self._feed(offsets, self._feeding.capacity)
            await self._taken()


class Servo(StreamMaker):
    """Streams of positions to follow (servo, manual 1.3.5).

        async with robot.servo.joints(v=1.0, a=5.0, rate=500) as stream:
            async for tick in stream.ticks():
                await stream.send(policy(tick.time))

    All of them move each joint separately to the newest set-point. Only one stream may be open on a
    robot, and no other motion may run at the same time.

    All of them take these keywords for how the program feeds the stream, here with their defaults:

        rate: set-points per second to the controller [Hz]; 500.
        source_rate: targets per second from the program [Hz]; as many as `rate`, or measured.
        latest: whether only the newest target counts, and `send` never waits; False.
        upsample: up-sampling of targets to `rate`: "none", "linear", "cubic" or "ruckig"; "none".
        hold: time without a target after which the stream ends [s]; 0.5.
        ahead: targets queued before `send` waits; those of 50 ms.

    Streams of positions (all but `tcp_offset`) also take chunks of actions, by `Stream.send_chunk`:

        chunks: whether the program sends chunks, `source_rate` actions per second; False. They need
            upsample="ruckig", which keeps the jerk limit, or "cubic".
        blend: time of the transition from an older chunk to a newer one [s]; 0.1.

    Args:
        endpoint: the controller.
    """

    def joints(
        self,
        *,
        v: Real,
        a: Real,
        jerk: Real | None = None,
        max_step: Real = 0.2,
        reach: Real = 0.1,
        gains: ServoGains | None = None,
        options: WorkerOptions | None = None,
        **feeding: Unpack[ServoOptions],
    ) -> Stream:
        """Follow joint positions (servoj, 关节伺服).

        Args:
            v: largest speed of each joint, 0.000175 to 3.926 [rad/s].
            a: largest acceleration of each joint, from 0.000175 [rad/s²].
            jerk: largest jerk of each joint, for upsample="ruckig" [rad/s³]; None: 10 a.
            max_step: largest step of a joint between two targets [rad].
            reach: largest distance of each joint from the first target [rad].
            gains: how closely the controller follows; None: as the manual advises.
            options: how the worker runs; None: in a separate process.
            feeding: how the program feeds it, see above.

        Returns:
            The stream; its set-points are six joint angles [rad], -2π to 2π.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        v_, a_ = ranges.JOINT_SPEED("v", v), ranges.JOINT_ACCELERATION("a", a)
        fed = Feeding(
            **feeding,
            max_step=per_group("max_step", max_step, 6),
            reach=per_group("reach", reach, 6),
        )
        sent = StreamSpec(
            name="servoj",
            in_joints=True,
            limits=motion_limits(v_, a_, jerk, 6),
            arguments=_arguments([v_, a_], gains),
        )
        return Stream(self._endpoint, fed, options, sent, ranges.JOINTS)

    def pose(
        self,
        *,
        v: Real,
        a: Real,
        velocity: _Pair = (0.25, 1.0),
        acceleration: _Pair = (1.0, 4.0),
        jerk: _Pair | None = None,
        q_near: VectorLike | None = None,
        tool: str = "",
        wobj: str = "",
        max_step: _Pair = (0.05, 0.2),
        reach: _Pair = (0.05, 0.1),
        gains: ServoGains | None = None,
        options: WorkerOptions | None = None,
        **feeding: Unpack[ServoOptions],
    ) -> Stream:
        """Follow poses of the tool in the work object (servoj_pose, 位姿伺服).

        Args:
            v: largest speed of each joint, for the controller, 0.000175 to 3.926 [rad/s].
            a: largest acceleration of each joint, for the controller, from 0.000175 [rad/s²].
            velocity: largest speed of the tool [m/s] and its largest turning speed [rad/s].
            acceleration: largest acceleration of the tool [m/s²] and of its turning [rad/s²].
            jerk: largest jerk of the tool [m/s³] and of its turning [rad/s³]; None: 10 times the
                acceleration.
            q_near: joint angles that choose the solution [rad]; None: the present ones.
            tool: name of the tool; empty: the one in use.
            wobj: name of the work object; empty: the one in use.
            max_step: largest step between two targets [m, rad].
            reach: largest distance of the tool from the first target [m, rad].
            gains: how closely the controller follows; None: as the manual advises.
            options: how the worker runs; None: in a separate process.
            feeding: how the program feeds it, see above.

        Returns:
            The stream; its set-points are poses (x, y, z [m], rx, ry, rz [rad]).

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        v_, a_ = ranges.JOINT_SPEED("v", v), ranges.JOINT_ACCELERATION("a", a)
        motion = [v_, a_, ranges.JOINTS_NEAR("q_near", q_near)]
        limits = _limits(velocity, acceleration, jerk)
        sent = _poses("servoj_pose", motion, limits, tool, wobj, gains)
        fed = _fed(max_step, reach, **feeding)
        return Stream(self._endpoint, fed, options, sent, ranges.POSE)

    def linear(
        self,
        *,
        v: Real,
        a: Real,
        velocity: _Pair = (0.25, 1.0),
        acceleration: _Pair = (1.0, 4.0),
        jerk: _Pair | None = None,
        q_near: VectorLike | None = None,
        tool: str = "",
        wobj: str = "",
        max_step: _Pair = (0.05, 0.2),
        reach: _Pair = (0.05, 0.1),
        gains: ServoGains | None = None,
        options: WorkerOptions | None = None,
        **feeding: Unpack[ServoOptions],
    ) -> Stream:
        """Follow poses with Cartesian interpolation in the controller (servol, 直线伺服).

        Manual 3.8 gives `v` and `a` for the joints, manual 4.3 for the tool; the ranges here lie
        within both. The other arguments are those of `pose`.

        Args:
            v: speed for the controller, 0.000175 to 3.926 [rad/s or m/s].
            a: acceleration for the controller, from 0.000175 [rad/s² or m/s²].
            velocity: largest speed of the tool [m/s] and its largest turning speed [rad/s].
            acceleration: largest acceleration of the tool [m/s²] and of its turning [rad/s²].
            jerk: largest jerk of the tool [m/s³] and of its turning [rad/s³].
            q_near: joint angles that choose the solution [rad].
            tool: name of the tool.
            wobj: name of the work object.
            max_step: largest step between two targets [m, rad].
            reach: largest distance of the tool from the first target [m, rad].
            gains: how closely the controller follows.
            options: how the worker runs.
            feeding: how the program feeds it, see above.

        Returns:
            The stream; its set-points are poses (x, y, z [m], rx, ry, rz [rad]).

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        v_, a_ = ranges.SERVO_SPEED("v", v), ranges.SERVO_ACCELERATION("a", a)
        motion = [v_, a_, ranges.JOINTS_NEAR("q_near", q_near)]
        limits = _limits(velocity, acceleration, jerk)
        sent = _poses("servol", motion, limits, tool, wobj, gains)
        fed = _fed(max_step, reach, **feeding)
        return Stream(self._endpoint, fed, options, sent, ranges.POSE)

    def tcp_offset(
        self,
        *,
        v: Real,
        a: Real,
        velocity: _Pair = (0.25, 1.0),
        acceleration: _Pair = (1.0, 4.0),
        jerk: _Pair | None = None,
        tool: str = "",
        frame: MotionFrame = "tool",
        wobj: str = "",
        max_step: _Pair = (0.05, 0.2),
        gains: ServoGains | None = None,
        options: WorkerOptions | None = None,
        rate: float = 500.0,
        **feeding: Unpack[FeedingOptions],
    ) -> OffsetStream:
        """Move by offsets of the tool, in its frame or another (servo_tcp, 工具增量伺服).

        The controller takes offsets in the tool's frame. With another `frame` the worker rotates
        them: it reads the tool's orientation once, when the first offset is due and the arm stands
        still, and computes from there, so that no offset depends on the age of a reading.

        The controller applies an offset to its last target, so offsets add up, and each is executed
        once: when no more offsets come, the arm stops at their sum. The worker spreads them over as
        many ticks as the limits require. With `latest`, offsets that are not sent yet add up.

        Args:
            v: speed for the controller, 0.000175 to 3.926 [rad/s or m/s].
            a: acceleration for the controller, from 0.000175 [rad/s² or m/s²].
            velocity: largest speed of the tool [m/s] and its largest turning speed [rad/s].
            acceleration: largest acceleration of the tool [m/s²] and of its turning [rad/s²].
            jerk: largest jerk of the tool [m/s³] and of its turning [rad/s³]; None: 10 times the
                acceleration.
            tool: name of the tool; empty: the one in use.
            frame: frame whose axes an offset refers to: "tool", "base" (z is up if the arm stands
                on a floor) or "wobj", a work object. An offset turns the tool about its tip.
            wobj: name of the work object; empty: the one in use.
            max_step: largest translation and largest rotation of one offset [m, rad].
            gains: how closely the controller follows; None: as the manual advises.
            options: how the worker runs; None: in a separate process.
            rate: set-points per second to the controller [Hz].
            feeding: how the program feeds it, see above.

        Returns:
            The stream; its set-points are offsets (x, y, z [m], rx, ry, rz [rad]) in `frame`.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        v_, a_ = ranges.SERVO_SPEED("v", v), ranges.SERVO_ACCELERATION("a", a)
        tool_ = ranges.FRAME("tool", tool)
        sent = StreamSpec(
            name="servo_tcp",
            turning=into_tool(frame, wobj, tool_),
            in_joints=False,
            limits=_limits(velocity, acceleration, jerk),
            arguments=_arguments([v_, a_, tool_], gains),
            meaning="step",
            tool=tool_,
        )
        fed = _fed(max_step, max_step, rate=rate, **feeding)
        return OffsetStream(self._endpoint, fed, options, sent, ranges.POSE)


def _arguments(motion: list[Any], gains: ServoGains | None) -> list[Any]:
    """What stands behind each set-point: how it moves first, then `block`, and the gains."""
    gains = ServoGains() if gains is None else gains
    if not isinstance(gains, ServoGains):
        raise ParameterError("gains", gains, "ServoGains, or None")
    return [*motion, False, *gains.wire()]


def _poses(
    function: str,
    motion: list[Any],
    limits: Limits,
    tool: str,
    wobj: str,
    gains: ServoGains | None,
) -> StreamSpec:
    tool_, wobj_ = ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)
    return StreamSpec(
        name=function,
        in_joints=False,
        limits=limits,
        arguments=_arguments([*motion, tool_, wobj_], gains),
        tool=tool_,
        wobj=wobj_,
    )


def _fed(max_step: _Pair, reach: _Pair, **feeding: Unpack[ServoOptions]) -> Feeding:
    return Feeding(
        **feeding,
        max_step=per_group("max_step", max_step, 2),
        reach=per_group("reach", reach, 2),
    )


def _limits(velocity: _Pair, acceleration: _Pair, jerk: _Pair | None) -> Limits:
    return motion_limits(velocity, acceleration, jerk, 2, names=("velocity", "acceleration"))
