"""Speed streams with a dead-man time (speedj, speedl, speed_stop; manual 1.3.5)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from aioduco.api.streams import StreamMaker
from aioduco.api.streams.arguments import per_group
from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.streaming.shared.config import StreamSpec
from aioduco.streaming.shared.options import Feeding, WorkerOptions
from aioduco.streaming.shared.space import Limits
from aioduco.streaming.shared.turning import MotionFrame, into_tool
from aioduco.streaming.stream import Stream

if TYPE_CHECKING:
    from aioduco.models.rules import Real


class Speed(StreamMaker):
    """Streams of speeds (speedj, speedl, manual 1.3.5), for example from a joystick.

        async with robot.speed.linear(a=0.5, frame="base", dead_man=0.2) as stream:
            async for tick in stream.ticks():
                await stream.send(joystick())

    Each call carries a time after which the controller ends the motion by itself, so the arm also
    stops when the program dies or the cable is pulled. At its end the stream ramps the speed to
    zero and calls speed_stop.

    Args:
        endpoint: the controller.
    """

    def joints(
        self,
        *,
        a: Real,
        v: Real = 1.0,
        dead_man: float = 0.2,
        rate: float = 50.0,
        latest: bool = True,
        hold: float = 0.1,
        options: WorkerOptions | None = None,
    ) -> Stream:
        """Follow joint speeds (speedj, 关节速度).

        Args:
            a: largest acceleration of each joint, from 0.000175 [rad/s²].
            v: largest speed of each joint, 0.000175 to 3.926 [rad/s]; higher speeds are limited.
            dead_man: time without a call after which the controller ends the motion, up to 10 [s].
            rate: calls per second [Hz].
            latest: whether only the newest speed counts, and `send` never waits.
            hold: time without a speed from the program after which the stream ends [s].
            options: how the worker runs; None: in a separate process.

        Returns:
            The stream; its set-points are six joint speeds [rad/s].

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        a_, v_ = ranges.JOINT_ACCELERATION("a", a), ranges.JOINT_SPEED("v", v)
        feeding = Feeding(rate=rate, latest=latest, hold=hold)
        sent = StreamSpec(
            name="speedj",
            in_joints=True,
            limits=Limits(per_group("v", v_, 6), per_group("a", a_, 6)),
            arguments=_arguments(a_, dead_man, feeding),
            meaning="speed",
            leave=[["speed_stop", False]],
        )
        return Stream(self._endpoint, feeding, options, sent, ranges.JOINT_VELOCITIES)

    def linear(
        self,
        *,
        a: Real,
        turn_a: Real = 2.0,
        v: Real = 0.25,
        turn_v: Real = 1.0,
        frame: MotionFrame = "tool",
        wobj: str = "",
        dead_man: float = 0.2,
        rate: float = 50.0,
        latest: bool = True,
        hold: float = 0.1,
        options: WorkerOptions | None = None,
    ) -> Stream:
        """Follow a speed of the tool (speedl, 末端速度).

        The controller takes the speed in the tool's frame: manual 4.3 says so, manual 3.8 says
        nothing. With another `frame` the worker rotates the speed. The orientation that it uses
        was read from the controller at most 10 ms, plus the time of that call, before the speed is
        sent.

        Args:
            a: largest acceleration of the tool, from 0.00001 [m/s²].
            turn_a: largest change of the turning speed [rad/s²]; the worker keeps this limit.
            v: largest speed, 0.00001 to 5 [m/s]; higher speeds are limited.
            turn_v: largest turning speed, up to 3.926 [rad/s]; higher speeds are limited.
            frame: frame whose axes the speed refers to: "tool", "base" (z is up if the arm stands
                on a floor) or "wobj", a work object.
            wobj: name of the work object; empty: the one in use.
            dead_man: time without a call after which the controller ends the motion, up to 10 [s].
            rate: calls per second [Hz].
            latest: whether only the newest speed counts, and `send` never waits.
            hold: time without a speed from the program after which the stream ends [s].
            options: how the worker runs; None: in a separate process.

        Returns:
            The stream; its set-points are speeds (x, y, z [m/s], rx, ry, rz [rad/s]) in `frame`.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        a_, v_ = ranges.FINE_ACCELERATION("a", a), ranges.FINE_SPEED("v", v)
        turning = ranges.JOINT_SPEED("turn_v", turn_v)
        feeding = Feeding(rate=rate, latest=latest, hold=hold)
        sent = StreamSpec(
            name="speedl",
            turning=into_tool(frame, wobj),
            in_joints=False,
            limits=Limits((v_, turning), (a_, *per_group("turn_a", turn_a, 1))),
            arguments=_arguments(a_, dead_man, feeding),
            meaning="speed",
            leave=[["speed_stop", False]],
        )
        return Stream(self._endpoint, feeding, options, sent, ranges.TWIST)


def _arguments(a: float, dead_man: float, feeding: Feeding) -> list[Any]:
    """What stands behind the speed in each call: acceleration, dead-man time [ms], `block`."""
    seconds = ranges.DEAD_MAN("dead_man", dead_man)
    if seconds < 2 / feeding.rate:
        raise ParameterError("dead_man", dead_man, f"two calls, {2 / feeding.rate:g} s, or more")
    return [a, ranges.RUN_TIME("dead_man", seconds), False]
