"""Moves an arm by an input device, until the person or the device ends it."""

from __future__ import annotations

import time
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

from aioduco.devices.teleoperation.reading import FLAG, STANDING, Reading, ReadingSource
from aioduco.devices.teleoperation.scale import TeleopScale
from aioduco.errors import ParameterError
from aioduco.models.ranges import FINE_SPEED, JOINT_SPEED
from aioduco.supervision.permits import asked_at_call

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.robot import Robot
    from aioduco.streaming.report import StreamStatistics
    from aioduco.streaming.shared.options import WorkerOptions
    from aioduco.streaming.shared.turning import MotionFrame


_RATE = 50.0
_DEAD_MAN = 0.2  # s without a call after which the controller ends the motion by itself


class TeleopReport(NamedTuple):
    """The report of a teleoperation.

    Attributes:
        held: how often the dead-man switch was pressed.
        seconds: total time for which it was held [s].
        stream: statistics of the stream of speeds.
    """

    held: int
    seconds: float
    stream: StreamStatistics


@asked_at_call
async def teleoperate(
    robot: Robot,
    device: ReadingSource,
    scale: TeleopScale | None = None,
    *,
    frame: MotionFrame = "base",
    wobj: str = "",
    joints: bool = False,
    acceleration: float = 0.5,
    turn_acceleration: float = 2.0,
    hold: float = 0.2,
    options: WorkerOptions | None = None,
    on_reading: Callable[[Reading], None] | None = None,
) -> TeleopReport:
    """Move the arm by a device, with a stream of speeds, until the person ends it.

    The arm comes to rest within the accelerations when the dead-man switch is released, when the
    device is gone or stops sending while its cap or key is held, and when the caller is cancelled.
    When the program dies or the network is lost, the controller ends the motion by itself after
    0.2 s. `robot.envelope` applies: the stream ends before the arm crosses a limit. To record the
    motion, put the call into `async with robot.record("run.mcap")`.

    Args:
        robot: the robot; it must be brought up, and nothing else may move it.
        device: the device, open.
        scale: speeds at full deflection; None: low speeds.
        frame: frame whose axes the motion refers to: "base", "tool" or "wobj".
        wobj: name of the work object; empty: the one in use.
        joints: whether the six axes of the device turn joints 1 to 6 instead.
        acceleration: acceleration of the tool [m/s²], or of each joint [rad/s²].
        turn_acceleration: acceleration of the tool's turning [rad/s²].
        hold: time without a speed from this program after which the arm is brought to rest and the
            call raises [s].
        options: how the stream's worker runs; None: in a separate process.
        on_reading: callback with each reading, for example to open a gripper by a button; it must
            not block.

    Returns:
        The report.

    Raises:
        ParameterError: an argument is out of range, or the device's `read` gave no `Reading`,
            or one whose `held` or `done` is neither True nor False.
        StreamError: the stream ended for another reason; the error says why.
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
            v=min(FINE_SPEED.high, found.speed * 3**0.5),
            turn_v=min(JOINT_SPEED.high, found.turn_speed * 3**0.5),
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
            reading = _checked(device.read(now))
            if on_reading is not None:
                on_reading(reading)
            if reading.held and not before:
                held, began = held + 1, now
            elif before and not reading.held:
                seconds += now - began
            before = reading.held
            if reading.done:
                if before:
                    seconds += now - began
                break
            await stream.send(found.joints(reading) if joints else found.twist(reading))
    return TeleopReport(held, seconds, stream.statistics())


def _checked(reading: object) -> Reading:
    """What a device gave, if it is a reading."""
    if isinstance(reading, Reading):
        FLAG("the reading's held", reading.held)
        FLAG("the reading's done", reading.done)
        with suppress(TypeError):
            if len(reading.axes) == len(STANDING):
                return reading
    raise ParameterError(
        "the device's reading",
        reading,
        "a Reading with six axes (the stream ends, and the arm comes to rest)",
    )
