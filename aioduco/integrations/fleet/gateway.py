"""A gateway: supervise the arms of one computer, and offer their state and stop to the fleet."""

from __future__ import annotations

import time
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Final, Self

import anyio
import anyio.abc

from aioduco import HeartbeatState, events
from aioduco._process.copying import Uncopied
from aioduco._process.reporting import BackgroundLogger
from aioduco.errors import DucoError, StopsUnconfirmed
from aioduco.integrations.fleet.gateway_state import GatewayState
from aioduco.integrations.fleet.link import FleetLink
from aioduco.integrations.fleet.proof import read_keys
from aioduco.integrations.fleet.reports import ArmReport
from aioduco.integrations.fleet.settings import FleetFileError, settings_given
from aioduco.robot import Robot, connect, stop_all
from aioduco.supervision.concurrency import every, first_error

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.integrations.fleet.settings import ArmSettings, FleetSettings


_log = BackgroundLogger(__name__)

#: least time between two attempts to connect to a controller [s]
_AGAIN: Final = 1.0


class FleetGateway(Uncopied):
    """Supervises arms; an asynchronous context manager.

    It opens its robots in the background, and retries until they answer. When it ends in order, it
    stops the arms whose heartbeat it sends. When it dies, their controllers or its guard stop them.

    Args:
        settings: settings of the fleet, with a gateway's name and its arms.
        reach: makes a robot from an arm's settings; None for `aioduco.connect` with these settings.
            A program that also moves the arms passes a function of its own.

    Raises:
        FleetFileError: it has no name, or the file of keys is wrong or lacks its key.
    """

    def __init__(
        self, settings: FleetSettings, reach: Callable[[ArmSettings], Robot] | None = None
    ) -> None:
        if not settings_given(settings).gateway:
            raise FleetFileError("a gateway needs a name: gateway = ... in [fleet]")
        self._settings = settings
        keys = read_keys(settings.keys) if settings.keys else {}
        if keys and settings.gateway not in keys:
            raise FleetFileError(f"{settings.keys} has no key of this gateway, {settings.gateway}")
        self._key = keys.get(settings.gateway)
        self._reach = reach or partial(_reach, rate=settings.rate)
        self._state = GatewayState(settings.gateway, [arm.name for arm in settings.arms])
        self._link = FleetLink(settings, listens=True)
        self._tasks: anyio.abc.TaskGroup | None = None
        self._has_namesake = False
        #: open robots, by the name of their arm
        self.robots: dict[str, Robot] = {}

    def __repr__(self) -> str:
        return f"<FleetGateway {self._settings.gateway} {len(self.robots)} arms>"

    async def __aenter__(self) -> Self:
        """Start the gateway.

        Raises:
            MissingExtra: the extra `fleet` is not installed.
            FleetFileError: an address is none, or Zenoh's own file is wrong.
            ConnectError: an address cannot be listened on.
        """
        await self._link.__aenter__()
        try:
            self._link.answer_stops(self._settings.gateway, self._stop, self._key)
            self._link.watch_namesakes(self._settings.gateway, self._namesake_seen)
            self._link.declare_alive(self._settings.gateway)
        except BaseException:  # also a panic of Zenoh, which is no Exception
            await self._link.__aexit__(None, None, None)
            raise
        # Begun last: a gateway that fails to start must not leave tasks behind.
        self._tasks = anyio.create_task_group()
        await self._tasks.__aenter__()
        for arm in self._settings.arms:
            self._tasks.start_soon(self._supervise, arm)
        self._tasks.start_soon(self._publish_reports)
        return self

    async def __aexit__(self, *exc: object) -> None:
        assert self._tasks is not None
        try:
            self._tasks.cancel_scope.cancel()
            # without the error of the block, which it would put into a group
            await self._tasks.__aexit__(None, None, None)
        finally:
            await self._link.__aexit__(*exc)

    async def _supervise(self, arm: ArmSettings) -> None:
        """Keep one robot open: reopen it whenever it fails. Each reason is logged once in a row."""
        said = ""
        async for _ in every(_AGAIN):
            try:
                async with self._reach(arm) as robot:
                    said = ""
                    self.robots[arm.name] = robot
                    self._state.opened(arm.name)
                    try:
                        await self._follow(arm.name, robot)
                    finally:
                        if arm.heartbeat:
                            with anyio.CancelScope(shield=True), suppress(DucoError):
                                await robot.stop()
                        del self.robots[arm.name]
            except* DucoError as group:
                why = str(first_error(group))
                if why != said:
                    _log.warning("the arm %s is not supervised for now: %s", arm.name, why)
                said = why
                self._state.closed(arm.name, why)
            except* Exception as group:
                # The failure of one arm does not end the supervision of the others.
                why = f"the gateway failed: {first_error(group)!r}"
                if why != said:
                    _log.exception("the gateway failed at the arm %s", arm.name)
                said = why
                self._state.closed(arm.name, why)

    async def _follow(self, name: str, robot: Robot) -> None:
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._follow_events, name, robot)
            with robot.feed.subscribe("latest") as samples:
                async for sample in samples:
                    states, joints = sample.states, sample.status.joints
                    report = ArmReport(
                        name,
                        robot=states.robot.name,
                        program=states.program.name,
                        safety=states.safety.name,
                        mode=states.mode.name,
                        joints=tuple(float(joint) for joint in joints),
                    )
                    self._state.sampled(name, report, sample.received_at)

    async def _follow_events(self, name: str, robot: Robot) -> None:
        with robot.events.subscribe() as subscribed:
            async for event in subscribed:
                if isinstance(event, events.ConnectionGone):
                    self._state.connection_lost(name, event.reason)
                elif isinstance(event, events.ConnectionBack):
                    self._state.connection_restored(name)
                elif isinstance(event, events.HeartbeatChanged):
                    withheld = event.after is HeartbeatState.STALLED
                    self._state.heartbeat_withheld(name, withheld=withheld)

    async def _publish_reports(self) -> None:
        async for _ in every(1.0 / self._settings.rate):
            report = self._state.report(time.monotonic())
            self._link.publish_state(self._settings.gateway, report.encode())

    def _namesake_seen(self) -> None:
        if not self._has_namesake:
            self._has_namesake = True
            _log.error(
                "another gateway is named %s, too: the view of the fleet shows one of them, and a "
                "stop may not wait for the other. Give each computer's gateway a name of its own",
                self._settings.gateway,
            )

    async def _stop(self, data: bytes) -> bytes:
        """Carry out a stop that a client of the fleet requested."""
        order = self._state.stop(data)
        robots = [(name, self.robots[name]) for name in order.arms if name in self.robots]
        errors: tuple[DucoError | None, ...] = (None,) * len(robots)
        try:
            await stop_all(robot for _, robot in robots)
        except StopsUnconfirmed as unconfirmed:
            errors = unconfirmed.errors
        said = dict.fromkeys(order.arms, "not connected")
        for (name, _), error in zip(robots, errors, strict=True):
            said[name] = "" if error is None else f"{type(error).__name__}: {error}"
        report = order.report(said)
        for arm in report.arms:
            if arm.error:
                _log.warning("the fleet's stop of %s is not confirmed: %s", arm.name, arm.error)
            else:
                _log.warning("the fleet stopped %s", arm.name)
        return report.encode()


def _reach(arm: ArmSettings, rate: float) -> Robot:
    return connect(
        arm.host,
        arm.port,
        heartbeat=arm.heartbeat or None,
        guard="process" if arm.guard else None,
        state_rate=rate,
    )
