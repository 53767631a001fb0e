"""Servo streams (servoj, servoj_pose, servo_tcp, servol; manual 1.3.5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from aioduco.api import ranges
from aioduco.errors import ParameterError
from aioduco.streaming.settings import Endpoint, Feeding, LaneOptions, Upsampling, per_group
from aioduco.streaming.space import JOINT_SPACE, POSE_SPACE
from aioduco.streaming.stream import Stream

if TYPE_CHECKING:
    from aioduco.models.rules import VectorLike

__all__ = ["OffsetStream", "Servo", "ServoGains"]

_JERK = 10.0  # of the acceleration, per second: full acceleration after 0.1 s


@dataclass(frozen=True, slots=True, kw_only=True)
class ServoGains:
    """How closely the controller follows a servo's set-points (manual 1.3.5, servoj).

    Attributes:
        kp: proportional gain, from 0; the manual advises its default.
        kd: derivative gain, from 0; the manual advises its default.
        smooth_vel: smoothing of the velocity, 1 to 100; more is smoother and lags more.
        smooth_acc: smoothing of the acceleration, 0 to 1; more is smoother and lags more.
    """

    kp: float = 200.0
    kd: float = 25.0
    smooth_vel: float = 10.0
    smooth_acc: float = 1.0

    def wire(self) -> list[float]:
        """The four numbers as they stand at the end of a servo call, checked.

        Raises:
            ParameterError: one is out of range.
        """
        return [
            ranges.SERVO_KP("kp", self.kp),
            ranges.SERVO_KD("kd", self.kd),
            ranges.SERVO_SMOOTH_VELOCITY("smooth_vel", self.smooth_vel),
            ranges.SERVO_SMOOTH_ACCELERATION("smooth_acc", self.smooth_acc),
        ]


class OffsetStream(Stream):
    """A stream of offsets in the tool's frame, each from where the one before led to."""

    def _placed(self, values: tuple[float, ...]) -> tuple[float, ...]:
        """Where an offset leads to, in the tool's frame at the stream's start."""
        space = POSE_SPACE
        start = space.decode(self._last or (0.0,) * 6)
        return space.encode(space.composed(start, space.decode(values)))

    async def send(self, point: VectorLike) -> None:
        """Send one offset.

        Args:
            point: the offset (x, y, z [m], rx, ry, rz [rad]). Shape (6,).

        Raises:
            ParameterError: it is not allowed; nothing was sent, and the stream goes on.
            SetPointTooFar: it is larger than the stream allows; nothing was sent.
            StreamError: the stream has ended; says why.
        """
        await super().send(self._placed(tuple(self._check("point", point))))

    async def play(self, trajectory: Any, times: Any = None) -> None:
        """Send a list of offsets, and wait until the lane has taken them.

        Args:
            trajectory: the offsets. Shape (n, 6).
            times: not taken: an offset says how far, not when.

        Raises:
            ParameterError: an offset is not allowed, or times were given.
            StreamError: the stream has ended; says why.
        """
        if times is not None:
            raise ParameterError("times", times, "left out: an offset says how far, not when")
        for offset in trajectory:
            await self.send(offset)


class Servo:
    """Streams of positions to follow (servo, manual 1.3.5).

        async with robot.servo.joints(v=1.0, a=5.0, rate=500) as stream:
            async for tick in stream.ticks():
                await stream.send(policy(tick.time))

    All of them move each joint by itself to the newest set-point. Only one kind may run at a
    time, and only one stream per robot.

    Args:
        endpoint: the controller.
    """

    def __init__(self, endpoint: Endpoint) -> None:
        self._endpoint = endpoint

    def joints(
        self,
        *,
        v: float,
        a: float,
        jerk: float | None = None,
        rate: float = 500.0,
        source_rate: float | None = None,
        latest: bool = False,
        upsample: Upsampling = "none",
        hold: float = 0.5,
        ahead: int | None = None,
        max_step: float = 0.2,
        reach: float = 0.1,
        gains: ServoGains | None = None,
        options: LaneOptions | None = None,
    ) -> Stream:
        """Follow joint positions (servoj, 关节伺服).

        Args:
            v: largest speed of each joint, 0.000175 to 3.93 [rad/s].
            a: largest acceleration of each joint, from 0.000175 [rad/s²].
            jerk: largest jerk of each joint, for upsample="ruckig" [rad/s³]; None: 10 a.
            rate: set-points per second to the controller [Hz].
            source_rate: targets per second from the program [Hz], see `Feeding`.
            latest: only the newest target counts, and `send` never waits.
            upsample: "none", "linear", "cubic" or "ruckig".
            hold: time without a target after which the stream ends [s].
            ahead: targets queued before `send` waits.
            max_step: largest step of a joint between two targets [rad].
            reach: how far each joint may be from the first target [rad].
            gains: how closely the controller follows; None: as the manual advises.
            options: how the lane runs; None: in a process of its own.

        Returns:
            The stream; its set-points are six joint angles [rad], -2π to 2π.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        v_, a_ = ranges.JOINT_SPEED("v", v), ranges.JOINT_ACCELERATION("a", a)
        feeding = Feeding(
            rate=rate,
            source_rate=source_rate,
            latest=latest,
            upsample=upsample,
            hold=hold,
            ahead=ahead,
            max_step=per_group("max_step", max_step, 6),
            reach=per_group("reach", reach, 6),
        )
        config = {
            "space": "joints",
            "limits": [
                per_group("v", v_, 6),
                per_group("a", a_, 6),
                per_group("jerk", _JERK * a_ if jerk is None else jerk, 6),
            ],
            "read": ["get_actual_joints_position"],
            "function": "servoj",
            "arguments": [None, v_, a_, False, *(gains or ServoGains()).wire()],
        }
        return Stream(
            self._endpoint,
            feeding,
            options,
            space=JOINT_SPACE,
            check=ranges.JOINTS,
            config=_single(config, rate),
            name="servoj",
        )

    def pose(
        self,
        *,
        v: float,
        a: float,
        velocity: tuple[float, float] = (0.25, 1.0),
        acceleration: tuple[float, float] = (1.0, 4.0),
        jerk: tuple[float, float] | None = None,
        q_near: VectorLike | None = None,
        tool: str = "",
        wobj: str = "",
        rate: float = 500.0,
        source_rate: float | None = None,
        latest: bool = False,
        upsample: Upsampling = "none",
        hold: float = 0.5,
        ahead: int | None = None,
        max_step: tuple[float, float] = (0.05, 0.2),
        reach: tuple[float, float] = (0.05, 0.1),
        gains: ServoGains | None = None,
        options: LaneOptions | None = None,
    ) -> Stream:
        """Follow poses of the tool in the work object (servoj_pose, 位姿伺服).

        Args:
            v: largest speed of each joint, for the controller, 0.000175 to 3.93 [rad/s].
            a: largest acceleration of each joint, for the controller, from 0.000175 [rad/s²].
            velocity: largest speed of the tool [m/s] and its largest turning speed [rad/s].
            acceleration: of the tool [m/s²] and of its turning [rad/s²].
            jerk: of the tool [m/s³] and of its turning [rad/s³]; None: 10 times the
                acceleration.
            q_near: joint angles that choose the solution [rad]; None: the present ones.
            tool: name of the tool; empty: the one in use.
            wobj: name of the work object; empty: the one in use.
            rate: set-points per second to the controller [Hz].
            source_rate: targets per second from the program [Hz], see `Feeding`.
            latest: only the newest target counts, and `send` never waits.
            upsample: "none", "linear", "cubic" or "ruckig".
            hold: time without a target after which the stream ends [s].
            ahead: targets queued before `send` waits.
            max_step: largest step between two targets [m, rad].
            reach: how far the tool may be from the first target [m, rad].
            gains: how closely the controller follows; None: as the manual advises.
            options: how the lane runs; None: in a process of its own.

        Returns:
            The stream; its set-points are poses (x, y, z [m], rx, ry, rz [rad]).

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        feeding = Feeding(
            rate=rate,
            source_rate=source_rate,
            latest=latest,
            upsample=upsample,
            hold=hold,
            ahead=ahead,
            max_step=per_group("max_step", max_step, 2),
            reach=per_group("reach", reach, 2),
        )
        v_, a_ = ranges.JOINT_SPEED("v", v), ranges.JOINT_ACCELERATION("a", a)
        near = ranges.JOINTS_NEAR("q_near", q_near)
        frames = [ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)]
        config = {
            **_cartesian(velocity, acceleration, jerk, frames),
            "function": "servoj_pose",
            "arguments": [None, v_, a_, near, *frames, False, *(gains or ServoGains()).wire()],
        }
        return self._poses(feeding, options, config, rate, "servoj_pose")

    def linear(
        self,
        *,
        v: float,
        a: float,
        velocity: tuple[float, float] = (0.25, 1.0),
        acceleration: tuple[float, float] = (1.0, 4.0),
        jerk: tuple[float, float] | None = None,
        q_near: VectorLike | None = None,
        tool: str = "",
        wobj: str = "",
        rate: float = 500.0,
        source_rate: float | None = None,
        latest: bool = False,
        upsample: Upsampling = "none",
        hold: float = 0.5,
        ahead: int | None = None,
        max_step: tuple[float, float] = (0.05, 0.2),
        reach: tuple[float, float] = (0.05, 0.1),
        gains: ServoGains | None = None,
        options: LaneOptions | None = None,
    ) -> Stream:
        """Follow poses with Cartesian interpolation in the controller (servol, 直线伺服).

        Manual 3.8 gives `v` and `a` as joint speeds, manual 4.3 as those of the tool; what is
        allowed here lies within both.

        Args:
            v: speed for the controller, 0.000175 to 3.93 [rad/s or m/s].
            a: acceleration for the controller, from 0.000175 [rad/s² or m/s²].
            velocity: largest speed of the tool [m/s] and its largest turning speed [rad/s].
            acceleration: of the tool [m/s²] and of its turning [rad/s²].
            jerk: of the tool [m/s³] and of its turning [rad/s³]; None: 10 times the
                acceleration.
            q_near: joint angles that choose the solution [rad]; None: the present ones.
            tool: name of the tool; empty: the one in use.
            wobj: name of the work object; empty: the one in use.
            rate: set-points per second to the controller [Hz].
            source_rate: targets per second from the program [Hz], see `Feeding`.
            latest: only the newest target counts, and `send` never waits.
            upsample: "none", "linear", "cubic" or "ruckig".
            hold: time without a target after which the stream ends [s].
            ahead: targets queued before `send` waits.
            max_step: largest step between two targets [m, rad].
            reach: how far the tool may be from the first target [m, rad].
            gains: how closely the controller follows; None: as the manual advises.
            options: how the lane runs; None: in a process of its own.

        Returns:
            The stream; its set-points are poses (x, y, z [m], rx, ry, rz [rad]).

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        feeding = Feeding(
            rate=rate,
            source_rate=source_rate,
            latest=latest,
            upsample=upsample,
            hold=hold,
            ahead=ahead,
            max_step=per_group("max_step", max_step, 2),
            reach=per_group("reach", reach, 2),
        )
        v_, a_ = ranges.SERVO_SPEED("v", v), ranges.SERVO_ACCELERATION("a", a)
        near = ranges.JOINTS_NEAR("q_near", q_near)
        frames = [ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)]
        config = {
            **_cartesian(velocity, acceleration, jerk, frames),
            "function": "servol",
            "arguments": [None, v_, a_, near, *frames, False, *(gains or ServoGains()).wire()],
        }
        return self._poses(feeding, options, config, rate, "servol")

    def tcp_offset(
        self,
        *,
        v: float,
        a: float,
        velocity: tuple[float, float] = (0.25, 1.0),
        acceleration: tuple[float, float] = (1.0, 4.0),
        jerk: tuple[float, float] | None = None,
        tool: str = "",
        rate: float = 500.0,
        source_rate: float | None = None,
        latest: bool = False,
        upsample: Upsampling = "none",
        hold: float = 0.5,
        ahead: int | None = None,
        max_step: tuple[float, float] = (0.05, 0.2),
        gains: ServoGains | None = None,
        options: LaneOptions | None = None,
    ) -> OffsetStream:
        """Move by offsets in the tool's frame (servo_tcp, 工具增量伺服).

        The controller counts an offset from its last target, so offsets add up, and each is
        carried out once: when no more of them come, the arm stands where they led to. The lane
        spreads them over the ticks that the limits ask for.

        Args:
            v: speed for the controller, 0.000175 to 3.93 [rad/s or m/s].
            a: acceleration for the controller, from 0.000175 [rad/s² or m/s²].
            velocity: largest speed of the tool [m/s] and its largest turning speed [rad/s].
            acceleration: of the tool [m/s²] and of its turning [rad/s²].
            jerk: of the tool [m/s³] and of its turning [rad/s³]; None: 10 times the
                acceleration.
            tool: name of the tool; empty: the one in use.
            rate: calls per second to the controller [Hz].
            source_rate: offsets per second from the program [Hz], see `Feeding`.
            latest: `send` never waits; offsets that are not sent yet add up.
            upsample: "none", "linear", "cubic" or "ruckig".
            hold: time without an offset after which the stream ends [s].
            ahead: offsets queued before `send` waits.
            max_step: largest offset, and largest turn of one [m, rad].
            gains: how closely the controller follows; None: as the manual advises.
            options: how the lane runs; None: in a process of its own.

        Returns:
            The stream; its set-points are offsets (x, y, z [m], rx, ry, rz [rad]).

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        steps = per_group("max_step", max_step, 2)
        feeding = Feeding(
            rate=rate,
            source_rate=source_rate,
            latest=latest,
            upsample=upsample,
            hold=hold,
            ahead=ahead,
            max_step=steps,
            reach=steps,
        )
        v_, a_ = ranges.SERVO_SPEED("v", v), ranges.SERVO_ACCELERATION("a", a)
        frame = ranges.FRAME("tool", tool)
        config = {
            **_cartesian(velocity, acceleration, jerk, []),
            "read": [],
            "offsets": True,
            "function": "servo_tcp",
            "arguments": [None, v_, a_, frame, False, *(gains or ServoGains()).wire()],
        }
        return OffsetStream(
            self._endpoint,
            feeding,
            options,
            space=POSE_SPACE,
            check=ranges.POSE,
            config=_single(config, rate),
            name="servo_tcp",
        )

    def _poses(
        self,
        feeding: Feeding,
        options: LaneOptions | None,
        config: dict[str, Any],
        rate: float,
        name: str,
    ) -> Stream:
        return Stream(
            self._endpoint,
            feeding,
            options,
            space=POSE_SPACE,
            check=ranges.POSE,
            config=_single(config, rate),
            name=name,
        )


def _cartesian(
    velocity: tuple[float, float],
    acceleration: tuple[float, float],
    jerk: tuple[float, float] | None,
    frames: list[str],
) -> dict[str, Any]:
    """The part of a configuration that streams of poses share."""
    accelerations = per_group("acceleration", acceleration, 2)
    jerks = tuple(_JERK * a for a in accelerations) if jerk is None else jerk
    return {
        "space": "pose",
        "limits": [
            per_group("velocity", velocity, 2),
            accelerations,
            per_group("jerk", jerks, 2),
        ],
        "read": ["get_tcp_pose_coord", *frames],
    }


def _single(config: dict[str, Any], rate: float) -> dict[str, Any]:
    """A configuration of a lane with one call per tick."""
    return {
        "driver": "each",
        "rates": False,
        "offsets": False,
        "read": [],
        "slot": 0,
        "leave": [],
        "period": 1 / rate,
        "point_period": 1 / rate,
        **config,
    }
