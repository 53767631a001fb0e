"""The topics of an arm, in ROS 1 and ROS 2: names, types, what publishes them and what takes them.

Where the driver of Universal Robots has a topic, it has its name here.
"""

# pyright: reportMissingImports=false
# Messages come with an installed ROS or are made at run time, and have no types.

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

from aioduco_msgs.msg import IOState, RobotState, ToolData
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped, WrenchStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64, String
from tf2_msgs.msg import TFMessage

from aioduco.integrations.ros import shared_messages
from aioduco.integrations.ros.arm_readings import STATE_NAMES, state_names

if TYPE_CHECKING:
    from collections.abc import Mapping

    from aioduco import Snapshot
    from aioduco.integrations.ros.arm_node import ArmNode, NodeSettings
    from aioduco.integrations.ros.arm_readings import ArmReading, Diagnosis, PlacedFrame
    from aioduco.integrations.ros.trajectory_server import GoalProgress


#: topics of the arm's state, and their types; each shell has its own for the controller's state
STATE_TOPICS: dict[str, Any] = {
    "joint_states": JointState,
    "/tf": TFMessage,
    "wrench": WrenchStamped,
    "robot_state": RobotState,
    "io_states": IOState,
    "speed_scaling": Float64,
    "tool_data": ToolData,
    **dict.fromkeys(STATE_NAMES, String),
    "/diagnostics": DiagnosticArray,
}
#: of these, the topics that all arms publish
_SHARED = ("joint_states", "/tf", "/diagnostics")


def topic_name(prefix: str, topic: str) -> str:
    """The name of a topic of the arm with that prefix."""
    return topic if topic in _SHARED else prefix + topic


def _take_twist(arm: ArmNode, message: Any) -> None:
    arm.twists.take(*shared_messages.twist(message))


def _take_freedrive(arm: ArmNode, message: Any) -> None:
    arm.freedrive.take(bool(message.data))


#: topics of commands: their types, and what takes a message, on the event loop
COMMAND_TOPICS: dict[str, Any] = {
    "twist_controller/command": (Twist, _take_twist),
    "delta_twist_cmds": (TwistStamped, _take_twist),
    "freedrive_mode_controller/enable_freedrive_mode": (Bool, _take_freedrive),
}


class StatePublisher(ABC):
    """Publishes the state of an arm: the sink of `ArmNode.run`.

    Args:
        settings: the driver's parameters.
        name: full name of the node.
        publishers: a publisher for each of `STATE_TOPICS`, and for what the shell has besides.
    """

    #: type of the joint states
    joint_state: Any = JointState

    def __init__(self, settings: NodeSettings, name: str, publishers: Mapping[str, Any]) -> None:
        self._settings = settings
        self._base = settings.base_frame
        self._name = name
        self.names: tuple[str, ...] = settings.profile.joint_names
        self.publishers: Mapping[str, Any] = publishers
        #: offset from the clock of samples to the clock of messages [s]
        self._ahead = self.wall() - time.monotonic()

    @abstractmethod
    def wall(self) -> float:
        """The clock of messages [s]."""

    @abstractmethod
    def stamp(self, seconds: float) -> Any:
        """A time of that clock, for a message."""

    @abstractmethod
    def wants_frames(self) -> bool:
        """Whether there is a subscriber for frames."""

    @abstractmethod
    def progress(self, place: GoalProgress, factor: float) -> None:
        """Publish where the arm is and is to be."""

    def _stamp_of(self, at: float) -> Any:
        """The time of a sample, for a message: 0 at the least, where simulated clocks begin."""
        return self.stamp(max(at + self._ahead, 0.0))

    def joints(self, at: float, reading: ArmReading, frames: list[PlacedFrame]) -> None:
        """Publish joint states, and frames if there are any."""
        stamp = self._stamp_of(at)
        message = shared_messages.joint_state(
            self.joint_state(), self.names, reading, self._base, stamp
        )
        self.publishers["joint_states"].publish(message)
        if frames:
            self.publishers["/tf"].publish(shared_messages.transforms(self._base, frames, stamp))

    def wrench(self, at: float, force: list[float]) -> None:
        """Publish force and torque at the tool."""
        frame = self._settings.prefix + "tcp_controller"
        message = shared_messages.wrench(frame, force, self._stamp_of(at))
        self.publishers["wrench"].publish(message)

    def states(self, snapshot: Snapshot) -> None:
        """Publish states, inputs and outputs."""
        stamp = self._stamp_of(snapshot.received_at)
        self.publishers["robot_state"].publish(
            shared_messages.robot_state(snapshot, self._base, stamp)
        )
        self.publishers["io_states"].publish(shared_messages.io_state(snapshot, self._base, stamp))
        for topic, text in state_names(snapshot).items():
            self.publishers[topic].publish(String(data=text))

    def tool(self, fields: dict[str, Any]) -> None:
        """Publish the data of the tool."""
        message = shared_messages.tool_data(fields, self._base, self.stamp(self.wall()))
        self.publishers["tool_data"].publish(message)

    def speed(self, percent: float) -> None:
        """Publish the global speed."""
        self.publishers["speed_scaling"].publish(Float64(data=percent))

    def diagnosis(self, found: Diagnosis) -> None:
        """Publish the diagnosis of the arm."""
        now = self.wall()
        self._ahead = now - time.monotonic()  # the clock may have been set, or be simulated
        host = self._settings.host
        message = shared_messages.diagnostics(self._name, host, found, self.stamp(now))
        self.publishers["/diagnostics"].publish(message)
