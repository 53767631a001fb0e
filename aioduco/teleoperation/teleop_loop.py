"""An arm that is led by an input device, until the person or the device ends it."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, NamedTuple

from aioduco.errors import ParameterError
from aioduco.teleoperation.reading import STANDING
from aioduco.teleoperation.scale import TeleopScale

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.robot import Robot
    from aioduco.streaming.directions import MotionFrame
    from aioduco.streaming.options import LaneOptions
    from aioduco.streaming.report import StreamStatistics
    from aioduco.teleoperation.devices import InputDevice
    from aioduco.teleoperation.reading import Reading

__all__ = ["TeleopReport", "teleoperate"]

_RATE = 50.0
_DEAD_MAN = 0.2  # s without a call after which the controller ends the motion by itself


class TeleopReport(NamedTuple):
    """How a teleoperation went.

    Attributes:
        held: how often the dead-man was pressed.
        seconds: for how long it was held, in all [s].
        stream: figures of the stream of speeds.
    """

    held: int
    seconds: float
    stream: StreamStatistics


async def teleoperate(
    robot: Robot,
    device: InputDevice,
    scale: TeleopScale | None = None,
    *,
    frame: MotionFrame = "base",
    wobj: str = "",
    joints: bool = False,
    acceleration: float = 0.5,
    turn_acceleration: float = 2.0,
    hold: float = 0.2,
    options: LaneOptions | None = None,
    on_reading: Callable[[Reading], None] | None = None,
) -> TeleopReport:
    """Lead the arm by a device, by a stream of speeds, until the person ends it.

    The arm comes to rest within the accelerations when the dead-man is let go, when the device is
    gone or falls silent while it should not, and when this is cancelled. When the program dies or
    the network is lost, the controller ends the motion 0.2 s later by itself. `robot.envelope`
    holds: the state is watched. To keep what was done, `async with robot.record("run.mcap")`
    around this.

    Args:
        robot: the robot; it is brought up, and nothing else moves it.
        device: the device, open.
        scale: speeds at its full deflection; None: slow ones.
        frame: along and about whose axes the tool moves: "base", "tool" or "wobj".
        wobj: name of the work object; empty: the one in use.
        joints: whether the six axes of the device turn joints 1 to 6 instead.
        acceleration: of the tool [m/s²], or of each joint [rad/s²].
        turn_acceleration: of the tool's turning [rad/s²].
        hold: time for which this program may not get to run before the arm is brought to rest,
            and this ends [s].
        options: how the stream's worker runs; None: in a process of its own.
        on_reading: told each reading, such as to open a gripper by a button; it must not wait.

    Returns:
        How it went.

    Raises:
        ParameterError: an argument is out of range.
        StreamError: the stream ended by something else; says why.
    """
    found = TeleopScale() if scale is None else scale
    if not isinstance(found, TeleopScale):
        raise ParameterError("scale", found, "a TeleopScale, or None")
    if joints:
        stream = robot.speed.joints(
            a=acceleration,
            v=found.joint_speed,
            dead_man=_DEAD_MAN,
            rate=_RATE,
            hold=hold,
            options=options,
        )
    else:
        stream = robot.speed.linear(
            a=acceleration,
            turn_a=turn_acceleration,
            v=found.speed * 3**0.5,
            turn_v=min(3.93, found.turn_speed * 3**0.5),
            frame=frame,
            wobj=wobj,
            dead_man=_DEAD_MAN,
            rate=_RATE,
            hold=hold,
            options=options,
        )
    held, began, seconds, before = 0, 0.0, 0.0, False
    async with stream:
        await stream.send(STANDING)
        async for _ in stream.ticks():
            now = time.monotonic()
            reading = device.read(now)
            if on_reading is not None:
                on_reading(reading)
            if reading.held and not before:
                held, began = held + 1, now
            elif before and not reading.held:
                seconds += now - began
            before = reading.held
            if reading.done:
                break
            await stream.send(found.joints(reading) if joints else found.twist(reading))
    return TeleopReport(held, seconds, stream.statistics())
