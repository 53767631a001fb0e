"""Teleoperation for blocking programs."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.streaming.directions import MotionFrame
    from aioduco.streaming.options import LaneOptions
    from aioduco.sync._robot import Robot
    from aioduco.teleoperation import InputDevice, Reading, TeleopReport, TeleopScale

__all__ = ["teleoperate"]


def teleoperate(
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
    """Move the arm by a device until the person ends it: see `aioduco.teleoperation.teleoperate`.

    An interrupt (Ctrl-C) brings the arm to rest before it is raised. `on_reading` is called on the
    robot's thread.
    """
    from aioduco import teleoperation  # noqa: PLC0415 - it loads numpy, so only when it is used

    work = teleoperation.teleoperate(
        robot._robot,
        device,
        scale,
        frame=frame,
        wobj=wobj,
        joints=joints,
        acceleration=acceleration,
        turn_acceleration=turn_acceleration,
        hold=hold,
        options=options,
        on_reading=on_reading,
    )
    return robot._runner.call(work)
