"""The stop of several robots, for programs that wait."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.errors import DucoError, StopsUnconfirmed

if TYPE_CHECKING:
    from collections.abc import Iterable

    from aioduco.sync._robot import Robot
    from aioduco.sync._runner import StartedCall

__all__ = ["stop_all"]


def stop_all(robots: Iterable[Robot]) -> None:
    """Stop several arms (停止所有机械臂), and wait until all stand.

    All are told before any is waited for, and each stop goes on to its end, as `Robot.stop`,
    whatever becomes of the others, and even if this is interrupted.

    Args:
        robots: the robots.

    Raises:
        StopsUnconfirmed: of some it is not known that they stand, or they were not open; the
            others stand. Press their emergency stops.

    Manual section 1.3.3.
    """
    chosen = tuple(robots)
    errors: list[DucoError | None] = [None] * len(chosen)
    started: dict[int, StartedCall[None]] = {}
    interrupts: list[KeyboardInterrupt] = []
    left = list(range(len(chosen)))
    while left:
        robot = chosen[left[0]]
        try:
            started[left[0]] = robot._runner.start(robot._robot.stop())
            left.pop(0)
        except DucoError as exc:
            errors[left.pop(0)] = exc
        except KeyboardInterrupt as interrupt:  # told once more, which is safe, and so are the rest
            interrupts.append(interrupt)
    for call in started.values():
        interrupts += _waited_for(call)
    for index, call in started.items():
        if isinstance(call.error, DucoError):
            errors[index] = call.error
        elif call.error is not None:
            raise call.error
    if interrupts:
        raise interrupts[0]
    if (first := next(filter(None, errors), None)) is not None:
        places = [f"{robot.host}:{robot.port}" for robot in chosen]
        raise StopsUnconfirmed.of(places, errors) from first


def _waited_for(call: StartedCall[None]) -> list[KeyboardInterrupt]:
    """Wait for the end of a call; the interrupts that came meanwhile."""
    interrupts = []
    while not call.over.is_set():
        try:
            call.wait()
        except KeyboardInterrupt as interrupt:
            interrupts.append(interrupt)
    return interrupts
