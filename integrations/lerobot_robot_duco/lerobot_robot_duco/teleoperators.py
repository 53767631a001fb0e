"""Teleoperators: a leader arm, and input devices. All of them give joint angles in radians."""

from __future__ import annotations

import time
from contextlib import ExitStack
from functools import cached_property
from typing import TYPE_CHECKING, Any

from lerobot.teleoperators import Teleoperator
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError

import aioduco.sync
from aioduco.devices.teleoperation import (
    GamepadDevice,
    InputDevice,
    JointTarget,
    KeyboardDevice,
    SpaceMouseDevice,
    TeleopScale,
)
from aioduco.kinematics import arm as arm_of
from aioduco.kinematics import models
from lerobot_robot_duco.config_duco import (
    DucoGamepadConfig,
    DucoKeyboardConfig,
    DucoLeaderConfig,
    DucoSpaceMouseConfig,
)
from lerobot_robot_duco.duco import KEYS, as_values

if TYPE_CHECKING:
    from aioduco.kinematics import Arm

__all__ = ["DucoGamepad", "DucoKeyboard", "DucoLeader", "DucoSpaceMouse"]

_LONGEST = 0.1  # s: a loop that stood still for longer does not make the arm leap


class _DucoTeleoperator(Teleoperator):
    """What all of them have in common: a controller that is looked at."""

    def __init__(self, config: Any) -> None:
        super().__init__(config)
        self.config = config
        self._open: ExitStack | None = None
        self._robot: aioduco.sync.Robot | None = None

    @cached_property
    def action_features(self) -> dict[str, type]:
        """Joint angles [rad]."""
        return dict.fromkeys(KEYS, float)

    @cached_property
    def feedback_features(self) -> dict[str, type]:
        """None: nothing is felt."""
        return {}

    @property
    def is_connected(self) -> bool:
        """Whether it is connected."""
        return self._robot is not None

    @property
    def is_calibrated(self) -> bool:
        """Always: the joints have absolute encoders."""
        return True

    def calibrate(self) -> None:
        """Nothing is to be done."""

    def configure(self) -> None:
        """Nothing is to be done."""

    def send_feedback(self, feedback: dict[str, Any]) -> None:
        """Nothing is felt."""

    def connect(self, calibrate: bool = True) -> None:  # noqa: ARG002 - LeRobot's signature
        """Connect.

        Args:
            calibrate: nothing is to be calibrated.
        """
        if self._robot is not None:
            raise DeviceAlreadyConnectedError(f"{self} is connected")
        with ExitStack() as stack:
            robot = self._entered(stack)
            robot.feed.latest(max_age=5.0)
            self._open = stack.pop_all()
            self._robot = robot

    def _entered(self, stack: ExitStack) -> aioduco.sync.Robot:
        """Connect, to look only: no heartbeat is sent, and leaving stops nothing."""
        robot = aioduco.sync.connect(
            self.config.host, self.config.port, heartbeat=None, lag_limit=None
        )
        stack.enter_context(robot)
        return robot

    def disconnect(self) -> None:
        """Let go of everything."""
        if self._robot is None or self._open is None:
            raise DeviceNotConnectedError(f"{self} is not connected: call connect() first")
        self._robot = None
        self._open.close()

    def _seen(self) -> list[float]:
        if self._robot is None:
            raise DeviceNotConnectedError(f"{self} is not connected: call connect() first")
        found = self._robot.feed.latest(max_age=self.config.max_age)
        return [float(angle) for angle in found.status.joints]


class DucoLeader(_DucoTeleoperator):
    """A second DUCO arm, guided by hand: its joint angles are the actions."""

    config_class = DucoLeaderConfig
    name = "duco_leader"

    def _entered(self, stack: ExitStack) -> aioduco.sync.Robot:
        if not self.config.guide:
            return super()._entered(stack)
        robot = aioduco.sync.connect(
            self.config.host, self.config.port, state_rate=self.config.state_rate
        )
        stack.enter_context(robot)
        robot.bring_up()
        stack.enter_context(robot.motion.teach_mode.start())
        return robot

    def get_action(self) -> dict[str, Any]:
        """Where the leader's joints are [rad]; the newest sample of its state."""
        return as_values(self._seen())


class _DucoDevice(_DucoTeleoperator):
    """An input device: its deflection is a speed, and the action is where that leads to."""

    def _device(self) -> InputDevice:
        raise TypeError(f"{type(self).__name__} names no device")

    def _entered(self, stack: ExitStack) -> aioduco.sync.Robot:
        robot = super()._entered(stack)
        config = self.config
        self._scale = TeleopScale(
            speed=config.speed, turn_speed=config.turn_speed, joint_speed=config.joint_speed
        )
        model = _model(robot) if not config.model else arm_of(config.model)
        self._target = JointTarget(model)
        self._input = stack.enter_context(self._device())
        self._before = time.monotonic()
        return robot

    def get_action(self) -> dict[str, Any]:
        """Where the device leads the joints [rad], or has led them, while it is not held.

        If something else has moved the arm meanwhile, it is where the joints are.
        """
        seen, now = self._seen(), time.monotonic()
        period, self._before = min(now - self._before, _LONGEST), now
        reading = self._input.read(now)
        if not reading.held:
            return as_values(self._target.rest(seen))
        if self.config.joints:
            return as_values(self._target.by_joints(self._scale.joints(reading), period, seen))
        twist = self._scale.twist(reading)
        in_tool = self.config.frame == "tool"
        return as_values(self._target.by_twist(twist, period, seen, in_tool=in_tool))


class DucoKeyboard(_DucoDevice):
    """The keys of the terminal."""

    config_class = DucoKeyboardConfig
    name = "duco_keyboard"

    def _device(self) -> InputDevice:
        return KeyboardDevice()


class DucoGamepad(_DucoDevice):
    """A gamepad."""

    config_class = DucoGamepadConfig
    name = "duco_gamepad"

    def _device(self) -> InputDevice:
        return GamepadDevice(self.config.device)


class DucoSpaceMouse(_DucoDevice):
    """A SpaceMouse."""

    config_class = DucoSpaceMouseConfig
    name = "duco_spacemouse"

    def _device(self) -> InputDevice:
        return SpaceMouseDevice(self.config.device or None)


def _model(robot: aioduco.sync.Robot) -> Arm:
    """The arm that the controller says it is."""
    told = "".join(filter(None, robot.version.get_robot_type()[:3]))
    bare = "".join(letter for letter in told.lower() if letter.isalnum())
    for name in models():
        if name.replace("_", "") == bare:
            return arm_of(name)
    raise ValueError(
        f"the controller calls its arm {told!r}: say by `model` which one of {models()} it is"
    )
