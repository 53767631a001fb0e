"""The robot: observations from the state feed, actions into a stream of set-points."""

from __future__ import annotations

import logging
import math
import sys
from contextlib import ExitStack
from functools import cached_property
from operator import sub
from typing import TYPE_CHECKING, Any

from lerobot.cameras.utils import make_cameras_from_configs
from lerobot.robots import Robot
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError

import aioduco.sync
from aioduco import StreamStatistics, WorkerOptions
from aioduco.errors import ParameterError, StaleState, StreamStarved
from lerobot_robot_duco.config_duco import DucoConfig

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["KEYS", "Duco", "as_values"]

#: names of the joints in observations and actions; values are in radians
KEYS: tuple[str, ...] = tuple(f"joint_{number}.pos" for number in range(1, 7))
_MOST = 2 * math.pi

logger = logging.getLogger(__name__)


def as_values(joints: Sequence[float]) -> dict[str, float]:
    """Joint angles [rad] by their names."""
    return {key: float(angle) for key, angle in zip(KEYS, joints, strict=True)}


def _only_late(error: StreamStarved) -> bool:
    """Whether no action came in time; not that the program hung, or its heartbeat was lost."""
    statistics = error.statistics
    return isinstance(statistics, StreamStatistics) and statistics.reason.name == "STARVED"


class Duco(Robot):
    """A DUCO arm.

    Actions and observations are joint angles in radians. An observation is the newest sample of
    the state feed, at most `max_age` old, and asks nothing of the controller. An action is a target
    of a servo stream: its worker, a process of its own, brings it up to 500 set-points a second
    within limits of speed, acceleration and jerk, however long the program computes.
    """

    config_class = DucoConfig
    name = "duco"

    def __init__(self, config: DucoConfig) -> None:
        super().__init__(config)
        self.config = config
        self.cameras = make_cameras_from_configs(config.cameras)
        self._open: ExitStack | None = None
        self._robot: aioduco.sync.Robot | None = None
        self._stream: aioduco.sync.Stream | None = None
        self._last: tuple[float, ...] | None = None

    # -- what it gives and takes ---------------------------------------------------------------

    @cached_property
    def observation_features(self) -> dict[str, Any]:
        """Joint angles [rad], and the pictures of the cameras."""
        pictures = {
            name: (camera.height, camera.width, 3) for name, camera in self.config.cameras.items()
        }
        return {**self.action_features, **pictures}

    @cached_property
    def action_features(self) -> dict[str, type]:
        """Joint angles [rad]."""
        return dict.fromkeys(KEYS, float)

    # -- its life ------------------------------------------------------------------------------

    @property
    def is_connected(self) -> bool:
        """Whether the robot and all cameras are."""
        return self._robot is not None and all(
            camera.is_connected for camera in self.cameras.values()
        )

    def connect(self, calibrate: bool = True) -> None:  # noqa: ARG002 - LeRobot's signature
        """Connect, and bring the arm up if that is chosen; nothing moves by this.

        Args:
            calibrate: nothing is to be calibrated: the joints have absolute encoders.
        """
        if self._robot is not None:
            raise DeviceAlreadyConnectedError(f"{self} is connected")
        config = self.config
        with ExitStack() as stack:
            robot = aioduco.sync.connect(
                config.host,
                config.port,
                state_rate=config.state_rate,
                heartbeat=config.heartbeat,
                loop_stall_limit=max(1.0, config.heartbeat),
                call_timeout=max(2.0, config.timeout),
                record=config.record or None,
            )
            stack.enter_context(robot)
            for camera in self.cameras.values():
                camera.connect()
                stack.callback(camera.disconnect)
            self._robot = robot
            stack.callback(self._forget)
            self.configure()
            robot.feed.latest(max_age=5.0)
            self._open = stack.pop_all()
        logger.info("%s connected", self)

    def _forget(self) -> None:
        self._robot = self._stream = self._last = None

    @property
    def is_calibrated(self) -> bool:
        """Always: the joints have absolute encoders."""
        return True

    def calibrate(self) -> None:
        """Nothing is to be done."""

    def configure(self) -> None:
        """Bring the arm up: power, enable, no fault."""
        if self.config.bring_up:
            self._connected().bring_up()

    def disconnect(self) -> None:
        """Follow the last action to its end if it is near, and leave the arm standing.

        The arm brakes at once if a joint is more than `max_step` from the last action, and while an
        error is handled, as in the `finally` with which LeRobot's commands end. The distance
        counts, too, because `lerobot-teleoperate` has handled Ctrl-C before it calls this.
        """
        self._connected()
        assert self._open is not None
        error = sys.exception()
        with self._open:
            self._open = None
            if error is None and (away := self._away()) > self.config.max_step:
                logger.warning("%s: %.3g rad from its last action, the arm brakes", self, away)
                error = KeyboardInterrupt()
            self._end_stream(error)

    def _away(self) -> float:
        """Largest distance of a joint from the last action [rad]; infinite if it is not known."""
        if self._last is None:
            return 0.0
        try:
            return max(map(abs, map(sub, self._last, self._joints())))
        except StaleState:
            return math.inf

    def _connected(self) -> aioduco.sync.Robot:
        if self._robot is None:
            raise DeviceNotConnectedError(f"{self} is not connected: call connect() first")
        return self._robot

    # -- observations and actions --------------------------------------------------------------

    def get_observation(self) -> dict[str, Any]:
        """The newest sample of the state, and the cameras' newest pictures.

        Raises:
            StaleState: the controller has not answered for `max_age`.
        """
        found: dict[str, Any] = as_values(self._joints())
        for name, camera in self.cameras.items():
            found[name] = camera.async_read()
        return found

    def _joints(self) -> tuple[float, ...]:
        found = self._connected().feed.latest(max_age=self.config.max_age)
        return tuple(float(angle) for angle in found.status.joints)

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Have the arm go to joint angles.

        Args:
            action: joint angles [rad].

        Returns:
            What was really sent: no joint more than `max_step` from the action before, or, for the
            first one, from where the arm is.

        Raises:
            ParameterError: an angle is missing, no number, or beyond what a joint can turn, as
                angles in degrees are; nothing was sent.
            StreamError: the stream has ended, such as by a stop; says why.
        """
        self._connected()
        try:
            wanted = [float(action[key]) for key in KEYS]
        except (LookupError, TypeError, ValueError, OverflowError) as exc:
            raise ParameterError(
                "action", action, f"a number for each of {', '.join(KEYS)}"
            ) from exc
        most = _MOST + self.config.max_step  # a policy may be a little beyond the end of a joint
        for key, angle in zip(KEYS, wanted, strict=True):
            if not abs(angle) <= most:
                raise ParameterError(key, angle, "from -2π to 2π rad (radians, not degrees)")
        sent = self._cut(wanted)
        try:
            self._streaming_on().send(sent)
        except StreamStarved as error:
            # Nothing was sent for a while, such as between two episodes: the arm stands.
            if not _only_late(error):
                raise
            logger.info("%s: goes on after a pause", self)
            self._end_stream(starved=True)
            sent = self._cut(wanted)
            self._streaming_on().send(sent)
        self._last = sent
        return as_values(sent)

    def _cut(self, wanted: Sequence[float]) -> tuple[float, ...]:
        """An action no farther than allowed from the last one, or from where the arm is."""
        base = self._last or self._joints()
        most = self.config.max_step
        return tuple(
            max(-_MOST, min(_MOST, b + max(-most, min(most, w - b))))
            for w, b in zip(wanted, base, strict=True)
        )

    def _streaming_on(self) -> aioduco.sync.Stream:
        """The stream, opened with the first action."""
        if self._stream is None:
            config = self.config
            stream = self._connected().servo.joints(
                v=config.v,
                a=config.a,
                jerk=config.jerk,
                rate=config.rate,
                latest=True,
                upsample="ruckig",
                hold=config.hold,
                max_step=2 * config.max_step,
                reach=2 * config.max_step,
                options=WorkerOptions(timeout=config.timeout),
            )
            self._stream = stream.__enter__()
        return self._stream

    def _end_stream(self, error: BaseException | None = None, *, starved: bool = False) -> None:
        stream, self._stream, self._last = self._stream, None, None
        if stream is None:
            return
        try:
            stream.__exit__(None, error, None)
        except StreamStarved as end:
            # It has ended by itself since the last action, and the arm stands.
            if not _only_late(end):
                raise
            if not starved:
                logger.info("%s: the arm stood before it was disconnected", self)

    def statistics(self) -> Any:
        """Figures of the stream (`aioduco.StreamStatistics`); None before the first action."""
        return None if self._stream is None else self._stream.statistics()
