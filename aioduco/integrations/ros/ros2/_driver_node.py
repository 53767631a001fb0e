"""The driver as a managed node of ROS 2.

The main thread runs the event loop with the robot. rclpy's executor runs on a separate thread and
waits only for transitions: goals and services are passed to the loop, and answered when it has
finished them. A stop has a node and a thread of its own, and is sent to the controller from there.

    unconfigured ──configure──> inactive ──activate──> active
       no arm      connected, services     states, goals, commands
"""

# pyright: reportMissingImports=false
# ROS 2 and its messages come with the system or a workspace, and have no types.

from __future__ import annotations

import functools
import math
import time
from typing import TYPE_CHECKING, Any

import aioduco_msgs.srv
import anyio
from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTrajectoryControllerState
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from aioduco._process.reporting import BackgroundLogger
from aioduco.errors import DucoError, ParameterError
from aioduco.integrations.ros.arm_node import ArmNode, NodeSettings, arm_node, check_prefix
from aioduco.integrations.ros.arm_services import ServiceReply
from aioduco.integrations.ros.node_parameters import parameter_defaults, settings_of
from aioduco.integrations.ros.ros2 import conversions
from aioduco.integrations.ros.service_table import ServiceEntry, service_table
from aioduco.integrations.ros.topics import (
    COMMAND_TOPICS,
    STATE_TOPICS,
    StatePublisher,
    topic_name,
)
from aioduco.integrations.ros.trajectory_goals import ErrorCode, GoalRefused, TrajectoryGoal
from aioduco.supervision.concurrency import every

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from anyio.abc import TaskStatus
    from anyio.from_thread import BlockingPortal

    from aioduco.integrations.ros.trajectory_server import GoalProgress


_log = BackgroundLogger(__name__)

_CONTROLLER_STATE = "joint_trajectory_controller/controller_state"
_TOPICS = STATE_TOPICS | {_CONTROLLER_STATE: JointTrajectoryControllerState}

#: for subscribers that request sensor data, and for those that request reliable data
_STATES = QoSProfile(depth=5)
_TRANSFORMS = QoSProfile(depth=100)
#: late subscribers also get the newest message
_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
#: of topics; of others, `_LATCHED` if they are published, `_NEWEST` if they are commands
_QUALITIES = {
    "joint_states": _STATES,
    "/tf": _TRANSFORMS,
    "wrench": _STATES,
    _CONTROLLER_STATE: _STATES,
    "/diagnostics": QoSProfile(depth=10),
    "freedrive_mode_controller/enable_freedrive_mode": 5,
}

_NEXT = 0.5  # a trajectory of one point that is due within this time is a command, not a goal [s]
_CANCEL_PERIOD = 0.002  # seconds between two checks whether rclpy has recorded a cancellation
_CANCEL_LIMIT = 1.0  # seconds within which it must have
_LOOK = 0.02  # seconds between two checks whether all results were sent
_RESULTS = 3.0  # seconds within which that is awaited
_DELIVERY = 0.3  # seconds for rclpy's thread to send a result; it does not report when it has
_SUCCESS, _FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE

_OFF = ServiceReply(False, "the driver is not configured: configure it first. Nothing was sent")
_ENDS = ServiceReply(False, "the driver ends; nothing was sent")

#: parameters of the node itself, besides those of the driver
_OWN = {"autostart": True, "watch_clients": True}


def _check_own(name: str, value: object) -> None:
    """Check a parameter of this shell: a text "false" would count as true."""
    if name in _OWN and not isinstance(value, bool):
        raise ParameterError(name, value, "true or false")


class _ActionGoal:
    """A goal of an action client, in the interface of the driver's core."""

    def __init__(self, node: DriverNode, handle: Any) -> None:
        self._node = node
        self._handle = handle
        self._seen: set[bytes] = set()
        self.goal: TrajectoryGoal = conversions.goal(handle.request)
        #: the result, for rclpy
        self.done = Future()

    def alive(self) -> bool:
        # A client may be discovered later than its goal. rclpy does not report the client of a
        # goal: any client that was present and has gone may have sent it.
        here = self._node.action_clients()
        self._seen |= here
        return self._seen <= here

    def accepted(self) -> None:
        """Do nothing: rclpy has already informed the client."""

    def feedback(self, feedback: GoalProgress) -> None:
        node = self._node
        self._handle.publish_feedback(conversions.feedback(node.names, feedback, node.wall()))

    async def cancellation_noted(self) -> None:
        """Wait until rclpy has recorded the cancellation that it has just reported."""
        with anyio.move_on_after(_CANCEL_LIMIT):
            async for _ in every(_CANCEL_PERIOD):
                if self._handle.is_cancel_requested:
                    return

    def succeeded(self) -> None:
        self._end(self._handle.succeed, ErrorCode.SUCCESSFUL, "")

    def cancelled(self, text: str) -> None:
        if self._handle.is_cancel_requested:
            self._end(self._handle.canceled, ErrorCode.SUCCESSFUL, text)
        else:  # superseded, or the client has gone: no cancellation was requested
            self._end(self._handle.abort, ErrorCode.INVALID_GOAL, text)

    def rejected(self, code: ErrorCode, text: str) -> None:
        # A refusal in ROS 2 has neither code nor reason; the end of an accepted goal has both.
        self._end(self._handle.abort, code, text)

    def aborted(self, code: ErrorCode, text: str) -> None:
        self._end(self._handle.abort, code, text)

    def _end(self, change: Callable[[], None], code: ErrorCode, text: str) -> None:
        try:
            change()
        finally:
            self._node.answer(self.done, conversions.result(code, text))


class _TopicGoal:
    """A trajectory from a topic: it has no client for a result, which is logged instead."""

    def __init__(self, goal: TrajectoryGoal) -> None:
        self.goal = goal

    def alive(self) -> bool:
        return True

    def accepted(self) -> None:
        """Do nothing: there is no client."""

    def feedback(self, feedback: GoalProgress) -> None:
        """Do nothing: there is no client."""

    def succeeded(self) -> None:
        _log.info("trajectory: the arm is there")

    def cancelled(self, text: str) -> None:
        _log.info("trajectory: %s", text)

    def rejected(self, code: ErrorCode, text: str) -> None:
        _log.warning("trajectory refused, %s: %s", code.name, text)

    def aborted(self, code: ErrorCode, text: str) -> None:
        _log.warning("trajectory ended, %s: %s", code.name, text)


def _take_joints(arm: ArmNode, message: Any) -> None:
    arm.commands.take(list(message.name), list(message.position))


def _follow_trajectory(arm: ArmNode, goal: TrajectoryGoal) -> None:
    if len(goal.points) == 1 and goal.points[0].time <= _NEXT:
        arm.commands.take(goal.joint_names, goal.points[0].positions)
    else:
        arm.goals.submit(_TopicGoal(goal))


_COMMANDS = COMMAND_TOPICS | {"joint_commands": (JointState, _take_joints)}


class _StatePublisher(StatePublisher):
    """The arm's state as messages of ROS 2."""

    def __init__(
        self, node: DriverNode, settings: NodeSettings, publishers: dict[str, Any]
    ) -> None:
        self._node = node
        super().__init__(settings, node.get_fully_qualified_name(), publishers)

    def wall(self) -> float:
        return self._node.wall()

    def stamp(self, seconds: float) -> Any:
        return conversions.stamp(seconds)

    def wants_frames(self) -> bool:
        return bool(self.publishers["/tf"].get_subscription_count())

    def progress(self, place: GoalProgress, factor: float) -> None:
        publisher = self.publishers.get(_CONTROLLER_STATE)
        if publisher is not None and publisher.get_subscription_count():
            state = conversions.controller_state(self.names, place, factor, self.wall())
            publisher.publish(state)


class DriverNode(LifecycleNode):  # type: ignore[misc]  # rclpy has no types
    """Topics, services, action and transitions of one arm.

    Args:
        portal: portal to the event loop with the robot.
        fail: takes an error that ended the driver unexpectedly; called on the loop.
        parameters: parameters that override those of the command line.

    Raises:
        ParameterError: one of the parameters that are read at once is wrong.

    Attributes:
        names: names of the joints.
        error: why the last configuration failed; None if it succeeded.
    """

    def __init__(
        self,
        portal: BlockingPortal,
        fail: Callable[[BaseException], None],
        parameters: dict[str, Any],
    ) -> None:
        super().__init__(
            "duco",
            parameter_overrides=[Parameter(name, value=v) for name, v in parameters.items()],
            automatically_declare_parameters_from_overrides=True,
        )
        self._portal = portal
        self._fail = fail
        self.names: tuple[str, ...] = ()
        self.error: DucoError | None = None
        self._arm: ArmNode | None = None
        self._released = anyio.Event()
        self._left = anyio.Event()
        self._running: anyio.CancelScope | None = None
        self._stopped = anyio.Event()
        self._topics: dict[str, Any] = {}
        self._state: _StatePublisher | None = None
        self._incoming: list[Any] = []
        self._action: Any = None
        self._feedback_topic = ""
        self._open_goals = 0
        self._ended_at = -math.inf  # when the last goal ended [s]
        self._group = ReentrantCallbackGroup()
        self._known = parameter_defaults() | _OWN
        for name, default in self._known.items():
            if not self.has_parameter(name):
                kind = ParameterDescriptor(dynamic_typing=True)
                # An empty list has no type in ROS: a list with one empty text is a list of texts.
                self.declare_parameter(name, [""] if default == () else default, kind)
        self.add_on_set_parameters_callback(self._check_parameters)
        for service in self.services:
            if service.srv_type is ChangeState:
                # rclpy's own raises for a transition that this state does not have.
                service.callback = functools.partial(_change_state, service.callback)
        for name in _OWN:
            _check_own(name, self.get_parameter(name).value)
        self._prefix: str = self.get_parameter("prefix").value
        check_prefix(self._prefix)
        self._offer_services()

    # -- parameters ------------------------------------------------------------------------------

    def _values(self) -> dict[str, Any]:
        """The driver's parameters, without ROS's own."""
        found = {}
        for name in self.get_parameters_by_prefix(""):
            if name in _OWN or name.startswith(("use_sim_time", "qos_overrides", "start_type_")):
                continue
            value = self.get_parameter(name).value
            if isinstance(value, (list, tuple)):
                value = tuple(each for each in value if each != "")
            found[name] = value
        return found

    def _check_parameters(self, parameters: list[Any]) -> Any:
        late = [each.name for each in parameters if each.name in self._known]
        if late and self._arm is not None:
            text = f"{', '.join(late)}: read when the driver is configured; clean it up first"
            return SetParametersResult(successful=False, reason=text)
        try:
            for each in parameters:
                self._check_parameter(each.name, each.value)
        except ParameterError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _check_parameter(self, name: str, value: object) -> None:
        _check_own(name, value)
        if name == "prefix" and value != self._prefix:
            expected = "given as the driver starts: services already have their names"
            raise ParameterError(name, value, expected)

    # -- transitions: on rclpy's thread, or on the thread that starts the node -------------------

    def start(self) -> None:
        """Configure and activate.

        Raises:
            DucoError: the driver could not be configured; the message says why.
        """
        if self.trigger_configure() is not _SUCCESS:
            raise self.error or DucoError("the driver could not be configured; nothing was sent")
        self.trigger_activate()

    def on_configure(self, state: Any) -> Any:
        """Read the parameters, connect to the arm, and offer topics and the action."""
        del state
        try:
            settings = settings_of(self._values())
            self.names = settings.profile.joint_names
            self._portal.start_task(self._hold_arm, settings)
        except DucoError as error:
            self.error = error
            self.get_logger().error(f"not configured: {error}")
            return _FAILURE
        self.error = None
        self._offer_topics(settings)
        return _SUCCESS

    def on_activate(self, state: Any) -> Any:
        """Publish states, and accept goals and commands."""
        found = super().on_activate(state)
        self._portal.start_task(self._run_arm)
        return found

    def on_deactivate(self, state: Any) -> Any:
        """Accept no more goals and commands; the arm comes to rest, also from a service."""
        self._portal.call(self._come_to_rest)
        return super().on_deactivate(state)

    def on_cleanup(self, state: Any) -> Any:
        """Disconnect from the arm."""
        del state
        self._portal.call(self.release)
        self._withdraw_topics()
        return _SUCCESS

    def on_shutdown(self, state: Any) -> Any:
        """Bring the arm to rest, and disconnect from it; the action stays, to send its results."""
        del state
        self._portal.call(self.release)
        return _SUCCESS

    def on_error(self, state: Any) -> Any:
        """Disconnect from the arm after a failed transition."""
        return self.on_cleanup(state)

    # -- the arm: on the loop --------------------------------------------------------------------

    async def _hold_arm(
        self, settings: NodeSettings, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED
    ) -> None:
        """Stay connected until the arm is released."""
        self._released, self._left = anyio.Event(), anyio.Event()
        try:
            async with arm_node(settings, wall=self.wall) as arm:
                self._arm = arm
                task_status.started()
                await self._released.wait()
        except DucoError as error:
            if self._arm is None:  # whoever configures it gets the error
                raise
            self._fail(error)
        finally:
            self._arm = None
            self._left.set()

    async def _run_arm(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Publish states and carry out goals until the node is deactivated."""
        arm, state = self._arm, self._state
        assert arm is not None
        assert state is not None
        self._stopped = anyio.Event()
        try:
            with anyio.CancelScope() as scope:
                self._running = scope
                task_status.started()
                await arm.run(state)
        except Exception as error:  # any error: a driver must not run with a part failed
            self._fail(error)
        finally:
            self._running = None
            self._stopped.set()

    async def _end_running(self) -> None:
        if self._running is not None:
            self._running.cancel()
            await self._stopped.wait()

    async def _come_to_rest(self) -> None:
        """End what runs, and stop the arm, which a service or a program may still move."""
        await self._end_running()
        if self._arm is not None:
            await self._arm.robot.stop()

    async def release(self) -> None:
        """Bring the arm to rest, and disconnect from it."""
        await self._end_running()
        if self._arm is not None:
            self._released.set()
            await self._left.wait()

    async def send_results(self) -> None:
        """Wait until rclpy has sent the results of goals that the driver's end has ended."""
        with anyio.move_on_after(_RESULTS):
            async for _ in every(_LOOK):
                if not self._open_goals and time.monotonic() - self._ended_at > _DELIVERY:
                    return

    # -- topics ----------------------------------------------------------------------------------

    def _offer_topics(self, settings: NodeSettings) -> None:
        prefix = settings.prefix
        controller = f"{prefix}joint_trajectory_controller"
        for topic, kind in _TOPICS.items():
            if topic == _CONTROLLER_STATE and settings.hold_commands:
                continue  # the controller of ros2_control publishes it
            name, quality = topic_name(prefix, topic), _QUALITIES.get(topic, _LATCHED)
            self._topics[topic] = self.create_lifecycle_publisher(kind, name, quality)
        self._state = _StatePublisher(self, settings, self._topics)
        for topic, (kind, take) in _COMMANDS.items():
            pass_on = functools.partial(self._pass_on, take)
            self._listen(kind, prefix + topic, pass_on, _QUALITIES.get(topic, _NEWEST))
        if settings.hold_commands:
            return  # ros2_control has an action of this name, and carries out its goals itself
        self._listen(JointTrajectory, f"{controller}/joint_trajectory", self._take_trajectory, 5)
        self._action = ActionServer(
            self,
            FollowJointTrajectory,
            f"{controller}/follow_joint_trajectory",
            self._execute_goal,
            goal_callback=self._judge_goal,
            cancel_callback=self._cancel_goal,
            callback_group=self._group,
        )
        self._feedback_topic = f"{controller}/follow_joint_trajectory/_action/feedback"

    def _listen(self, kind: Any, topic: str, take: Callable[[Any], None], quality: Any) -> None:
        self._incoming.append(self.create_subscription(kind, topic, take, quality))

    def _withdraw_topics(self) -> None:
        for publisher in self._topics.values():
            self.destroy_lifecycle_publisher(publisher)
        for subscription in self._incoming:
            self.destroy_subscription(subscription)
        if self._action is not None:
            self._action.destroy()
        self._topics, self._incoming, self._action = {}, [], None

    def wall(self) -> float:
        """The node's clock [s]."""
        return float(self.get_clock().now().nanoseconds) * 1e-9

    # -- commands and goals: on rclpy's thread ---------------------------------------------------

    def _schedule(self, function: Callable[..., object], *values: object) -> bool:
        """Schedule a call on the loop, without waiting for it. Return whether it was scheduled."""
        try:
            self._portal.start_task_soon(function, *values)
        except RuntimeError:
            return False
        return True

    def _take_trajectory(self, message: Any) -> None:
        self._pass_on(_follow_trajectory, conversions.trajectory(message))

    def _pass_on(self, take: Callable[[ArmNode, Any], None], message: Any) -> None:
        self._schedule(self._take, take, message)

    def _judge_goal(self, request: Any) -> Any:
        del request
        if self._running is None:
            self.get_logger().warning("a goal was refused: the driver is not active")
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    async def _execute_goal(self, handle: Any) -> Any:
        try:
            goal = _ActionGoal(self, handle)
        except GoalRefused as refusal:
            handle.abort()
            return conversions.result(refusal.code, str(refusal))
        except Exception as error:  # a client may send anything: the node continues
            handle.abort()
            text = f"the goal cannot be read: {error!r}; nothing was sent"
            return conversions.result(ErrorCode.INVALID_GOAL, text)
        handle.driver_goal = goal
        if not self._schedule(self._submit, goal):
            handle.abort()
            return conversions.result(ErrorCode.INVALID_GOAL, _ENDS.message)
        self._open_goals += 1
        try:
            return await goal.done
        finally:
            self._open_goals -= 1
            self._ended_at = time.monotonic()

    def _cancel_goal(self, handle: Any) -> Any:
        goal = getattr(handle, "driver_goal", None)
        if goal is None or not self._schedule(self._cancel, goal):
            return CancelResponse.REJECT
        return CancelResponse.ACCEPT

    def action_clients(self) -> set[bytes]:
        """Clients of the action that ROS has discovered; empty if clients are not watched."""
        if not self.get_parameter("watch_clients").value:
            return set()
        found = self.get_subscriptions_info_by_topic(self._feedback_topic)
        return {bytes(each.endpoint_gid) for each in found}

    # -- and on the loop -------------------------------------------------------------------------

    async def _submit(self, goal: _ActionGoal) -> None:
        if self._arm is None or self._running is None:
            goal.rejected(ErrorCode.INVALID_GOAL, "the driver is not active; nothing was sent")
        else:
            self._arm.goals.submit(goal)

    async def _cancel(self, goal: _ActionGoal) -> None:
        await goal.cancellation_noted()
        if self._arm is not None:
            self._arm.goals.cancel(goal)

    def _take(self, take: Callable[[ArmNode, Any], None], message: Any) -> None:
        """Let a command be taken, if the driver is active."""
        if self._arm is not None and self._running is not None:
            take(self._arm, message)

    def answer(self, future: Any, value: object) -> None:
        """Set the result of a future for which rclpy is waiting."""
        future.set_result(value)
        executor = self.executor
        if executor is not None:
            executor.wake()

    # -- services --------------------------------------------------------------------------------

    def _offer_services(self) -> None:
        for entry in service_table():
            kind = Trigger if entry.kind == "Trigger" else getattr(aioduco_msgs.srv, entry.kind)
            name = entry.name.replace("~", "~/") if "~" in entry.name else self._prefix + entry.name
            self.create_service(kind, name, self._server(entry), callback_group=self._group)

    def _server(self, entry: ServiceEntry) -> Callable[[Any, Any], Awaitable[Any]]:
        async def run(request: Any, done: Any) -> None:
            reply = _ENDS
            try:
                arm = self._arm
                reply = _OFF if arm is None else await entry.call(arm.services, request)
            finally:
                self.answer(done, reply)

        async def serve(request: Any, response: Any) -> Any:
            done = Future()
            if not self._schedule(run, request, done):
                done.set_result(_ENDS)
            response.success, response.message = await done
            return response

        return serve

    def stop(self, request: Any, response: Any) -> Any:
        """Stop the arm, on the separate thread for stops, which no other call delays."""
        del request
        arm = self._arm
        reply = _OFF if arm is None else arm.services.stop_now(self._portal)
        response.success, response.message = reply
        return response


def _change_state(change: Callable[[Any, Any], Any], request: Any, response: Any) -> Any:
    """Answer a request of a transition; one that the node cannot make is refused."""
    try:
        return change(request, response)
    except Exception as error:  # RCLError, whose module is private
        _log.warning("transition %s refused: %s", request.transition.id, error)
        response.success = False
        return response
