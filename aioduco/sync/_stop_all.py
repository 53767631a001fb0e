"""The stop of several robots, for blocking programs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, cast

from aioduco.errors import DucoError, ParameterError, RobotStateError, StopsUnconfirmed
from aioduco.models.host_port import host_port
from aioduco.sync._robot import RobotLifecycle
from aioduco.sync._runner import uninterrupted

if TYPE_CHECKING:
    from aioduco.sync._generated import Robot
    from aioduco.sync._runner import StartedCall


def stop_all(robots: Iterable[Robot]) -> None:
    """Stop several arms (停止所有机械臂), and wait until all stand.

    All stops are sent before any of them is waited for. Each stop runs to its end, as `Robot.stop`
    does, whatever happens to the others, and even if this is interrupted.

    Args:
        robots: the robots.

    Raises:
        ParameterError: this is no list of robots; no stop was sent.
        StopsUnconfirmed: some arms are not known to stand, or their robots were not open, or are no
            robots; the others stand. Press the emergency stops of the former.

    Manual section 1.3.3.
    """
    if isinstance(robots, RobotLifecycle):  # in place of a list: what is meant as a stop stops
        robots = (cast("Robot", robots),)
    if not isinstance(robots, Iterable):
        raise ParameterError("robots", robots, "a list of robots")
    chosen = tuple(robots)
    known = [isinstance(robot, RobotLifecycle) for robot in chosen]
    errors: list[DucoError | None] = [None] * len(chosen)
    started: dict[int, StartedCall[None]] = {}
    left = list(range(len(chosen)))

    def send() -> None:
        while left:
            index, robot = left[0], chosen[left[0]]
            if not known[index]:  # the others are stopped nevertheless
                errors[index] = RobotStateError(f"{robot!r} is no robot that `connect` returned")
            else:
                try:
                    started[index] = robot._runner.start(robot._made.stop())
                except DucoError as exc:
                    errors[index] = exc
            left.pop(0)

    def wait() -> None:
        for call in started.values():
            call.wait()

    # a stop during which an interrupt came is sent again, which is safe
    interrupts = uninterrupted(send) + uninterrupted(wait)
    for index, call in started.items():
        if isinstance(call.error, DucoError):
            errors[index] = call.error
        elif call.error is not None:
            raise call.error
    if interrupts:
        raise interrupts[0]
    if (first := next(filter(None, errors), None)) is not None:
        places = [
            host_port(robot.host, robot.port)
            if isinstance(robot, RobotLifecycle)
            else f"robots[{index}]"
            for index, robot in enumerate(chosen)
        ]
        raise StopsUnconfirmed.of(places, errors) from first
