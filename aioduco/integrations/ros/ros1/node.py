"""The driver as a node of ROS 1.

The main thread runs the event loop with the robot. rospy calls its callbacks on its own threads;
they pass their data to the loop. A stop does not wait for the loop: it is sent to the controller
from the thread on which it was requested.
"""

# pyright: reportMissingImports=false
# ROS 1 and its messages come with the system or are made at run time, and have no types.

from __future__ import annotations

import contextlib
import functools
import time
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import aioduco_msgs.srv
import anyio
import rosgraph
import rospy
import std_srvs.srv
from actionlib import ActionServer
from anyio.from_thread import BlockingPortal
from control_msgs.msg import FollowJointTrajectoryAction, JointTrajectoryControllerState
from std_srvs.srv import Trigger, TriggerResponse

from aioduco._process.reporting import BackgroundLogger
from aioduco._process.threads import in_thread
from aioduco.errors import ParameterError
from aioduco.integrations.ros.arm_node import ArmNode, NodeSettings, arm_node
from aioduco.integrations.ros.node_parameters import NodeError, settings_of
from aioduco.integrations.ros.ros1 import conversions
from aioduco.integrations.ros.ros1._packed_joint_state import PackedJointState
from aioduco.integrations.ros.service_table import ServiceEntry, service_table
from aioduco.integrations.ros.shutdown import cancel_on_signal
from aioduco.integrations.ros.topics import (
    COMMAND_TOPICS,
    STATE_TOPICS,
    StatePublisher,
    topic_name,
)
from aioduco.integrations.ros.trajectory_goals import ErrorCode, TrajectoryGoal

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from anyio.abc import SocketStream, TaskGroup

    from aioduco.integrations.ros.arm_services import ServiceReply
    from aioduco.integrations.ros.trajectory_server import GoalProgress


_LOOK_AT_MASTER = 1.0  # seconds between two checks of the master
_LOOKS_AGAIN, _LOOK_AGAIN = 4, 0.005  # checks after it closed its connection, and seconds between
_SILENT = 5.0  # seconds without an answer after which the master has gone; it may be busy
_QUEUE = 10  # queued messages for a slow subscriber
_CONTROLLER_STATE = "joint_trajectory_controller/state"
_TOPICS = STATE_TOPICS | {_CONTROLLER_STATE: JointTrajectoryControllerState}
#: Seconds from a goal to its result, at the least. `SimpleActionClient.send_goal` of Python begins
#: to track a goal after it has sent it: a result that comes earlier is lost, and its
#: `wait_for_result` never returns (ros/actionlib, issue 206; that repository is archived).
_SOONEST_RESULT = 0.1

_log = BackgroundLogger(__name__)


def main(arguments: Sequence[str], parameters: dict[str, Any]) -> None:
    """Run the node until a signal, or until ROS shuts it down.

    Args:
        arguments: arguments of the command line: remappings, `_name:=value` for private parameters.
        parameters: parameters that override those of the parameter server.

    Raises:
        NodeError: no master answers, or ROS refuses the arguments.
        ParameterError: an argument or a parameter is wrong; nothing was sent.
        ConnectError: no controller answers.
    """
    for word in arguments:
        name, assigned, value = word.partition(":=")
        if not (name and assigned) or ":=" in value:
            expected = "name:=value, as _prefix:=left_ or joint_states:=left_states"
            raise ParameterError("argument", word, expected)
    if not rosgraph.is_master_online():
        raise NodeError(
            f"no ROS master answers at {rosgraph.get_master_uri()}: start roscore, or set "
            "ROS_MASTER_URI. Nothing was sent"
        )
    try:
        try:
            rospy.init_node("duco", argv=["duco", *arguments], disable_signals=True)
        except (rospy.ROSException, ValueError) as error:
            raise NodeError(f"ROS refuses the arguments: {error}. Nothing was sent") from error
        # From here on, rospy's threads keep the process alive until `signal_shutdown`.
        anyio.run(_serve, _settings(parameters))
    finally:
        rospy.signal_shutdown("the driver ends")


def _settings(parameters: dict[str, Any]) -> NodeSettings:
    """The settings by the parameter server and, before it, these parameters."""
    server = rospy.get_param("~", {}) or {}
    try:
        return settings_of({**server, **parameters}, joint_commands=False)  # no topic takes them
    except ParameterError as error:
        name = error.parameter
        if name in parameters or name not in server:
            raise
        kept = f"rosparam delete {rospy.resolve_name(f'~{name}')}"
        text = f"{error.expected}; the master keeps it for the next start, too: {kept}"
        raise ParameterError(name, error.value, text) from None


async def _serve(settings: NodeSettings) -> None:
    portal = BlockingPortal()
    async with contextlib.AsyncExitStack() as stack:
        await portal.__aenter__()
        # Last, since it waits for the services that still run: one that moves the arm ends as the
        # arm is left. Without the error of the block, which it would put into a group.
        stack.push_async_callback(portal.__aexit__, None, None, None)
        node = await stack.enter_async_context(arm_node(settings, wall=rospy.get_time))
        tasks = await stack.enter_async_context(anyio.create_task_group())
        shell = _Shell(node, portal, tasks)
        rospy.on_shutdown(lambda: _quietly(portal, tasks.cancel_scope.cancel))
        tasks.start_soon(cancel_on_signal, tasks.cancel_scope)
        tasks.start_soon(shell.watch_master)
        tasks.start_soon(shell.serve_services)
        try:
            await node.run(shell.state)
        finally:
            # Before the portal closes: later requests of rospy are refused, not lost.
            shell.close()


def _quietly(portal: BlockingPortal, function: Callable[[], object]) -> None:
    """Schedule a call on the loop, if it is still running."""
    try:
        portal.start_task_soon(function)
    except RuntimeError:
        return


async def _closes(connection: SocketStream, due: float) -> bool:
    """Keep a connection until a time. Return whether the peer closed it earlier."""
    with anyio.CancelScope(deadline=due):
        async with connection:
            with contextlib.suppress(anyio.EndOfStream, anyio.BrokenResourceError):
                await connection.receive(1)
            return True
    return False


async def _after(due: float, call: Callable[[], object]) -> None:
    """Make a call at a time, or earlier if this is cancelled."""
    try:
        await anyio.sleep_until(due)
    finally:
        call()


class _Goal:
    """A goal of actionlib, in the interface of the driver's core."""

    def __init__(self, shell: _Shell, handle: Any, arrived: float) -> None:
        self._shell = shell
        self._handle = handle
        self._arrived = arrived
        self._caller = handle.goal._connection_header.get("callerid", "")
        self.goal: TrajectoryGoal = conversions.goal(handle.goal.goal)

    def alive(self) -> bool:
        return self._shell.is_connected(self._caller)

    def accepted(self) -> None:
        self._handle.set_accepted()

    def feedback(self, feedback: GoalProgress) -> None:
        names = self._shell.names
        self._handle.publish_feedback(conversions.feedback(names, feedback, rospy.get_time()))

    def succeeded(self) -> None:
        self._end(self._handle.set_succeeded, ErrorCode.SUCCESSFUL, "")

    def cancelled(self, text: str) -> None:
        self._end(self._handle.set_canceled, ErrorCode.SUCCESSFUL, text)

    def rejected(self, code: ErrorCode, text: str) -> None:
        self._end(self._handle.set_rejected, code, text)

    def aborted(self, code: ErrorCode, text: str) -> None:
        self._end(self._handle.set_aborted, code, text)

    def _end(self, send: Callable[[Any, str], object], code: ErrorCode, text: str) -> None:
        self._shell.forget(self._handle.get_goal_id().id)
        self._shell.answer(send, code, text, self._arrived)


class _StatePublisher(StatePublisher):
    """The arm's state as messages of ROS 1."""

    joint_state = PackedJointState

    def wall(self) -> float:
        return float(rospy.get_time())

    def stamp(self, seconds: float) -> Any:
        return conversions.stamp(seconds)

    def wants_frames(self) -> bool:
        return bool(self.publishers["/tf"].get_num_connections())

    def progress(self, place: GoalProgress, factor: float) -> None:
        del factor  # no field of this message in ROS 1
        publisher = self.publishers[_CONTROLLER_STATE]
        if publisher.get_num_connections():
            publisher.publish(conversions.controller_state(self.names, place, self.wall()))


class _Shell:
    """Topics, services and the action of one arm."""

    def __init__(self, node: ArmNode, portal: BlockingPortal, tasks: TaskGroup) -> None:
        self._node = node
        self._portal = portal
        self._tasks = tasks
        self._settings = node.settings
        self.names = node.settings.profile.joint_names
        self._goals: dict[str, _Goal] = {}
        prefix = node.settings.prefix
        #: the sink of the arm's state
        self.state = _StatePublisher(
            node.settings,
            rospy.get_name(),
            {
                topic: rospy.Publisher(topic_name(prefix, topic), kind, queue_size=_QUEUE)
                for topic, kind in _TOPICS.items()
            },
        )
        self._services: list[Any] = []
        self._action = ActionServer(
            f"{prefix}joint_trajectory_controller/follow_joint_trajectory",
            FollowJointTrajectoryAction,
            self._take_goal,
            self._cancel_goal,
            auto_start=False,
        )

    # -- goals: called on threads of rospy -------------------------------------------------------

    def _take_goal(self, handle: Any) -> None:
        arrived = time.monotonic()
        try:
            goal = _Goal(self, handle, arrived)
        except Exception as error:  # a client may send anything: the node continues
            text = f"the goal cannot be read: {error!r}; nothing was sent"
            code = ErrorCode.INVALID_GOAL
            self._schedule(self.answer, handle.set_rejected, code, text, arrived)
            return
        self._schedule(self._submit, goal, handle.get_goal_id().id)

    def _cancel_goal(self, handle: Any) -> None:
        self._schedule(self._cancel, handle.get_goal_id().id)

    def _schedule(self, function: Callable[..., object], *values: object) -> None:
        """Schedule a call on the loop, without waiting for it."""
        try:
            self._portal.start_task_soon(function, *values)
        except RuntimeError:
            _log.warning("the driver ends: a goal came too late, and was left")

    # -- and on the loop -------------------------------------------------------------------------

    def _submit(self, goal: _Goal, number: str) -> None:
        self._goals[number] = goal
        self._node.goals.submit(goal)

    def _cancel(self, number: str) -> None:
        goal = self._goals.get(number)
        if goal is not None:
            self._node.goals.cancel(goal)

    def forget(self, number: str) -> None:
        """Remove a goal that has its result."""
        self._goals.pop(number, None)

    def answer(
        self, send: Callable[[Any, str], object], code: ErrorCode, text: str, arrived: float
    ) -> None:
        """Send the result of a goal, `_SOONEST_RESULT` after the goal arrived at the earliest."""
        result = functools.partial(send, conversions.result(code, text), text)
        early = arrived + _SOONEST_RESULT - time.monotonic()
        if early > 0.0:
            self._tasks.start_soon(_after, anyio.current_time() + early, result)
        else:
            result()

    def is_connected(self, caller: str) -> bool:
        """Whether a client's connection for goals is open."""
        implementation = self._action.goal_sub.impl
        return implementation is not None and any(
            each.callerid_pub == caller and each.socket is not None and not each.done
            for each in list(implementation.connections)
        )

    async def watch_master(self) -> None:
        """End goals while the master has gone: it refuses connections, or is silent for long."""
        address = urlsplit(rosgraph.get_master_uri())
        host, port = address.hostname or "localhost", address.port or 11311
        start = heard = anyio.current_time()
        here, closed = True, 0
        while True:
            connection: SocketStream | None = None
            refused = False
            with anyio.move_on_after(_SILENT):
                try:
                    connection = await anyio.connect_tcp(host, port)
                    heard = anyio.current_time()
                except OSError:
                    refused = True
            was, here = here, not refused and anyio.current_time() - heard < _SILENT
            if here is not was:
                _log.warning("the ROS master %s", "is back" if here else "is gone: goals end")
            if not here:
                await self._node.goals.cancel_on_loss("the ROS master is gone")
            passed = int((anyio.current_time() - start) / _LOOK_AT_MASTER)
            due = start + (passed + 1) * _LOOK_AT_MASTER
            # A dying master closes its connections: it is then checked again at once. The number of
            # checks is limited: its port may close later, or a master may keep no connection.
            if connection is not None and closed < _LOOKS_AGAIN:
                closed = closed + 1 if await _closes(connection, due) else 0
                if closed:
                    await anyio.sleep(_LOOK_AGAIN)
            else:
                closed = 0
                if connection is not None:
                    await connection.aclose()
                await anyio.sleep_until(due)

    # -- services --------------------------------------------------------------------------------

    async def serve_services(self) -> None:
        """Offer services and the action; on a thread, because the master may be slow."""
        await in_thread(self._offer, abandon_on_cancel=True)

    def _offer(self) -> None:
        prefix = self._settings.prefix
        for entry in service_table():
            kinds = std_srvs.srv if entry.kind == "Trigger" else aioduco_msgs.srv
            kind, response = (getattr(kinds, entry.kind + part) for part in ("", "Response"))
            name = entry.name if entry.name[0] == "~" else prefix + entry.name
            self._serve(name, kind, response, entry)
        self._services.append(rospy.Service("~stop", Trigger, self._stop))
        for topic, (kind, take) in COMMAND_TOPICS.items():
            rospy.Subscriber(prefix + topic, kind, self._take_command, take, queue_size=1)
        self._action.start()

    def _serve(self, name: str, kind: Any, response: Any, entry: ServiceEntry) -> None:
        async def answer(asked: Any) -> ServiceReply:
            return await entry.call(self._node.services, asked)

        def handle(asked: Any) -> Any:
            try:
                return response(*self._portal.call(answer, asked))
            except RuntimeError:
                return response(False, "the driver ends; nothing was sent")

        self._services.append(rospy.Service(name, kind, handle))

    def _take_command(self, message: Any, take: Callable[[ArmNode, Any], None]) -> None:
        self._schedule(take, self._node, message)

    def _stop(self, _: Any) -> Any:
        """Stop the arm, on rospy's thread: the stop needs no event loop, and nothing delays it."""
        return TriggerResponse(*self._node.services.stop_now(self._portal))

    def close(self) -> None:
        """Accept no more calls."""
        for service in self._services:
            service.shutdown("the driver ends")
