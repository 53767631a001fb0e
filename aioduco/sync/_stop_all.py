"""The stop of several robots, for blocking programs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, cast

from aioduco.errors import DucoError, ParameterError, RobotStateError, StopsUnconfirmed
from aioduco.models.host_port import host_port
from aioduco.sync._robot import RobotLifecycle

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
    interrupts: list[KeyboardInterrupt] = []
    left = list(range(len(chosen)))
    while left:
        robot = chosen[left[0]]
        if not known[left[0]]:  # the others are stopped nevertheless
            errors[left.pop(0)] = RobotStateError(f"{robot!r} is no robot that `connect` returned")
            continue
        try:
            started[left[0]] = robot._runner.start(robot._made.stop())
            left.pop(0)
        except DucoError as exc:
            errors[left.pop(0)] = exc
        except KeyboardInterrupt as interrupt:  # this stop is sent again, which is safe
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
        places = [
            host_port(robot.host, robot.port)
            if isinstance(robot, RobotLifecycle)
            else f"robots[{index}]"
            for index, robot in enumerate(chosen)
        ]
        raise StopsUnconfirmed.of(places, errors) from first


def _waited_for(call: StartedCall[None]) -> list[KeyboardInterrupt]:
    """Wait for the end of a call, and return the interrupts that came in the meantime."""
    interrupts = []
    while not call.over.is_set():
        try:
            call.wait()
        except KeyboardInterrupt as interrupt:
            interrupts.append(interrupt)
    return interrupts
