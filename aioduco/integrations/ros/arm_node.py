"""The driver of one arm, for any middleware: state for a sink, goals, services."""

from __future__ import annotations

import re
import time
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, Protocol, get_args

import anyio
import numpy as np

from aioduco import connect
from aioduco._process.reporting import BackgroundLogger
from aioduco.errors import DucoError, ParameterError
from aioduco.integrations.ros.arm_readings import (
    diagnosis,
    joint_reading,
    placed_frames,
    tool_data_fields,
)
from aioduco.integrations.ros.arm_services import ArmServices
from aioduco.integrations.ros.joint_commands import JointCommands
from aioduco.integrations.ros.streamed_commands import Freedrive
from aioduco.integrations.ros.trajectory_goals import GoalRules, NamedLimits
from aioduco.integrations.ros.trajectory_server import GoalProgress, Through, TrajectoryServer
from aioduco.integrations.ros.twist_commands import TwistCommands
from aioduco.kinematics.catalogue import arm_named, model_named, same_arm
from aioduco.models.rules import Number, stored
from aioduco.models.words import one_of
from aioduco.supervision.concurrency import every

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from aioduco import Pose, Robot, Snapshot, WorkerOptions
    from aioduco.integrations.ros.arm_readings import ArmReading, Diagnosis, PlacedFrame


_log = BackgroundLogger(__name__)
#: topics and services begin with it, whose names ROS limits
_PREFIX = re.compile(r"(?:[A-Za-z/][A-Za-z0-9_/]*)?")
_PREFIXES = 'a letter, then letters, digits, "_" and "/", such as "left_"'
_RETRY = 0.1  # seconds between two requests while the controller does not answer


def check_prefix(prefix: object) -> None:
    """Check a prefix of names.

    Raises:
        ParameterError: names in ROS do not begin so.
    """
    if not isinstance(prefix, str) or _PREFIX.fullmatch(prefix) is None:
        raise ParameterError("prefix", prefix, _PREFIXES)


@dataclass(frozen=True, slots=True, kw_only=True)
class NodeSettings:
    """Parameters of a driver; the shells use the same names.

    Attributes:
        host: address of the controller.
        port: TCP port of the controller.
        model: model of the arm, such as "gcr5_910", for its limits.
        prefix: prefix of the names of joints and frames, such as "left_".
        joint_names: names of the joints; empty for joint_1 to joint_6.
        frame: frame in which the controller gives poses; empty: the prefix and "base_link".
        rate: joint states and transforms per second [Hz].
        slow_rate: states, inputs and outputs per second [Hz].
        wrench: whether to publish the force at the tool, which needs one more request each time.
        velocity: largest speed of a joint in a goal [rad/s]; 0: the arm's limit.
        acceleration: acceleration with which the arm follows goals and comes to rest [rad/s²].
        through: how set-points of goals reach the controller: "realtime" for its queue, "servoj"
            for one call each, "auto" for the queue if it has one.
        feedback_rate: feedback messages of a goal per second, up to 50 [Hz].
        heartbeat: seconds after which the controller stops the arm of a dead driver.
        guard: "process" for a process that stops the arm of a dead driver at once; empty for none.
            With it, a stop also ends a goal whose client or middleware has gone.
        command_rate: expected joint commands per second [Hz].
        command_timeout: time without a command after which the arm is free for other motions [s].
        hold_commands: whether joint commands own the arm all the time, as ros2_control requires;
            then nothing else moves it.
        rules: rules for goals.
    """

    host: str
    port: int = 7003
    model: str = "gcr5_910"
    prefix: str = ""
    joint_names: tuple[str, ...] = ()
    frame: str = ""
    rate: float = 125.0
    slow_rate: float = 10.0
    wrench: bool = False
    velocity: float = 0.0
    acceleration: float = 10.0
    through: Through = "auto"
    feedback_rate: float = 20.0
    heartbeat: float = 1.0
    guard: Literal["", "process"] = ""
    command_rate: float = 100.0
    command_timeout: float = 0.5
    hold_commands: bool = False
    rules: GoalRules = field(default_factory=GoalRules)

    def __post_init__(self) -> None:
        for name, most in (
            *(("rate", 500.0), ("slow_rate", 100.0), ("feedback_rate", 50.0)),
            ("command_rate", 500.0),
        ):
            stored(self, **{name: Number(0.1, most, "Hz", source="this package")})
        stored(self, command_timeout=Number(0.1, 10.0, "s", source="this package"))
        one_of("through", self.through, get_args(Through))
        check_prefix(self.prefix)

    @property
    def base_frame(self) -> str:
        """The frame in which the controller gives poses."""
        return self.frame or self.prefix + "base_link"

    @property
    def profile(self) -> NamedLimits:
        """Names and limits of the arm."""
        return NamedLimits.of(
            self.model,
            self.prefix,
            joint_names=self.joint_names,
            velocity=self.velocity or None,
            acceleration=self.acceleration,
        )


class StateSink(Protocol):
    """Receives a driver's state. All methods are called on the event loop, and must not wait."""

    def wants_frames(self) -> bool:
        """Whether there is a subscriber for frames; without one, none are computed."""
        ...

    def joints(self, at: float, reading: ArmReading, frames: list[PlacedFrame]) -> None:
        """Take joint states and frames.

        Args:
            at: when they were received, on the clock of `time.monotonic` [s].
            reading: the joints.
            frames: tool tip and flange; empty without a subscriber.
        """

    def wrench(self, at: float, force: list[float]) -> None:
        """Take force and torque at the tool [N, N·m], six."""

    def states(self, snapshot: Snapshot) -> None:
        """Take the whole sample, for states, inputs and outputs."""

    def speed(self, percent: float) -> None:
        """Take the global speed, which scales motions and goals [percent]."""

    def tool(self, fields: dict[str, Any]) -> None:
        """Take the data of the tool in use, once a second, as fields of ToolData."""

    def progress(self, place: GoalProgress, factor: float) -> None:
        """Take where the arm is and is to be, at the rate of feedback.

        Args:
            place: where it is on the path of its goal; without a goal, it is to be where it is.
            factor: factor of their speed at which goals are followed.
        """

    def diagnosis(self, found: Diagnosis) -> None:
        """Take the diagnosis of the arm, once a second."""


class ArmNode:
    """The driver of one arm. Made by `arm_node`.

    Attributes:
        robot: the robot, open.
        goals: trajectory goals of the arm.
        services: services of the arm.
        commands: joint positions that are followed as they arrive.
        twists: speeds of the tool that are followed as they arrive.
        freedrive: hand guiding while it is asked for.
    """

    def __init__(
        self,
        robot: Robot,
        settings: NodeSettings,
        *,
        wall: Callable[[], float],
        options: WorkerOptions | None = None,
    ) -> None:
        self.robot = robot
        self.settings = settings
        self.goals: TrajectoryServer = TrajectoryServer(
            robot,
            settings.profile,
            settings.rules,
            wall=wall,
            feedback_rate=settings.feedback_rate,
            through=settings.through,
            options=options,
            stop_at_loss=bool(settings.guard),
        )
        self.services: ArmServices = ArmServices(
            robot,
            self.goals,
            recovered=self._allow,
            halted=self._ignore,
            twisting=lambda: self.twists.following,
            streaming=lambda: self.twists.following or self.commands.following,
        )
        self.commands: JointCommands = JointCommands(
            robot,
            settings.profile,
            busy=lambda: self.goals.busy or self.twists.following,
            rate=settings.command_rate,
            timeout=settings.command_timeout,
            hold=settings.hold_commands,
            reach=2.0 * settings.rules.start,
            options=options,
        )
        self.twists: TwistCommands = TwistCommands(
            robot,
            base=settings.base_frame,
            tips=[settings.prefix + tip for tip in ("tcp_controller", "tcp")],
            flange=settings.prefix + "tool0",
            busy=lambda: self.goals.busy or self.commands.following,
            timeout=settings.command_timeout,
            options=options,
        )
        self.freedrive: Freedrive = Freedrive(
            robot, busy=lambda: self.goals.busy or self.commands.following or self.twists.following
        )
        self._tcp_offset: Pose | None = None
        self._position: tuple[float, ...] = ()
        self._newest: Snapshot | None = None
        self._count = 0  # joint states since the last diagnosis

    def _allow(self) -> None:
        """Follow commands again: the arm was brought up or recovered."""
        for streamed in (self.commands, self.twists, self.freedrive):
            streamed.allow()

    def _ignore(self) -> None:
        """Ignore commands that go on, also those that are not followed yet: the arm is stopped."""
        for streamed in (self.commands, self.twists, self.freedrive):
            streamed.ignore()

    async def run(self, sink: StateSink) -> None:
        """Publish and serve until this is cancelled; it may be run again."""
        streams = (self.commands, self.twists, self.freedrive)
        try:
            async with anyio.create_task_group() as tasks:
                for part in (self.goals, *streams):
                    tasks.start_soon(part.run)
                for streamed in streams:
                    tasks.start_soon(streamed.watch)
                for publish in (
                    *(self._publish_joints, self._publish_progress, self._publish_states),
                    *(self._watch_speed, self._watch_tool, self._diagnose),
                ):
                    tasks.start_soon(publish, sink)
        finally:
            for streamed in streams:
                streamed.leave()

    async def _publish_joints(self, sink: StateSink) -> None:
        """Publish joints at the full rate: one request each; a whole sample needs three."""
        state, prefix = self.robot.state, self.settings.prefix
        async for _ in every(1.0 / self.settings.rate):
            try:
                status = await state.getRobotStatus()
                reading = joint_reading(status)
                self._position = reading.position
                sink.joints(
                    status.received_at,
                    reading,
                    placed_frames(status, self._tcp_offset, prefix) if sink.wants_frames() else [],
                )
                self._count += 1
                if self.settings.wrench:
                    force = await state.get_tcp_force_tool()
                    sink.wrench(time.monotonic(), force.tolist())
            except DucoError as error:
                self._position = ()
                _log.debug("no joint states: %s", error)
                await anyio.sleep(_RETRY)

    async def _publish_progress(self, sink: StateSink) -> None:
        """Publish where the arm is and is to be."""
        async for _ in every(1.0 / self.settings.feedback_rate):
            place = self.goals.progress
            if place is None and self._position:
                here = np.array(self._position)
                place = GoalProgress(0.0, here, here)
            if place is not None:
                sink.progress(place, self.goals.factor)

    async def _publish_states(self, sink: StateSink) -> None:
        """Pass whole samples to the sink; a slow sink loses samples, and causes no delay."""
        with self.robot.feed.subscribe("latest") as samples:
            async for snapshot in samples:
                self._newest = snapshot
                sink.states(snapshot)

    async def _watch_speed(self, sink: StateSink) -> None:
        """Publish the global speed, and let goals follow it."""
        async for _ in every(1.0 / self.settings.slow_rate):
            try:
                before = self.goals.factor
                percent = float(await self.robot.settings.get_global_speed())
                sink.speed(percent)
                # whole numbers on the wire: a fraction that a service has set stays
                if self.goals.factor == before and abs(percent - 100.0 * before) >= 1.0:
                    self.goals.scale(min(max(percent, 1.0), 100.0) / 100.0)
            except DucoError as error:
                _log.debug("no speed: %s", error)

    async def _watch_tool(self, sink: StateSink) -> None:  # noqa: ARG002 - as all that run beside
        """Follow changes of the tool, by which the flange is placed."""
        async for _ in every(1.0 / self.settings.slow_rate):
            try:
                self._tcp_offset = await self.robot.frames.get_tcp_offset()
            except DucoError:
                self._tcp_offset = None  # the tool may have changed: do not use an old offset

    async def _diagnose(self, sink: StateSink) -> None:
        feed, asked = self.robot.feed, anyio.current_time()
        async for _ in every(1.0):
            if (offset := self._tcp_offset) is not None and self._newest is not None:
                with suppress(DucoError):
                    load = await self.robot.frames.get_tool_load()
                    sink.tool(tool_data_fields(self._newest, offset, load))
            now = anyio.current_time()
            rate, asked, self._count = self._count / max(now - asked, 1e-3), now, 0
            sink.diagnosis(diagnosis(self._newest, feed.error, time.monotonic(), rate))


@asynccontextmanager
async def arm_node(
    settings: NodeSettings,
    *,
    wall: Callable[[], float] = time.time,
    options: WorkerOptions | None = None,
) -> AsyncIterator[ArmNode]:
    """Connect to an arm for a driver; when the block exits, the arm stands.

    Args:
        settings: the driver's parameters.
        wall: the middleware's clock [s].
        options: options of streams; None: in a separate process.

    Raises:
        ParameterError: a parameter is out of range; nothing was sent.
        ConnectError: no controller answers.
    """
    _ = settings.profile  # raises before anything is sent
    async with connect(
        settings.host,
        settings.port,
        heartbeat=settings.heartbeat,
        guard=settings.guard or None,
        state_rate=settings.slow_rate,
    ) as robot:
        await _compare_model(robot, settings.model)
        yield ArmNode(robot, settings, wall=wall, options=options)


async def _compare_model(robot: Robot, model: str) -> None:
    """Say if the controller reports another model than the one whose limits goals have to keep."""
    try:
        told = arm_named(await robot.version.get_robot_type())
    except DucoError:
        return  # this controller does not say
    if model_named(told) is not None and not same_arm(model, told):
        _log.warning(
            "the arm is a %s, but goals have to keep the limits of a %s: set the parameter model",
            *(told, model),
        )
