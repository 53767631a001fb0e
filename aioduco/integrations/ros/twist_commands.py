"""Follow speeds of the tool as they arrive, for example from a joystick or MoveIt Servo.

Guarantees:
- The arm moves only while commands arrive: the stream ends when they cease, and the controller
  itself ends the motion when the driver dies.
- After a stop, and as the driver starts, commands that go on are ignored until they have ceased, or
  the arm was brought up or recovered.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal, TypeAlias

import anyio

from aioduco._process.reporting import BackgroundLogger
from aioduco.errors import DucoError, ParameterError
from aioduco.integrations.ros.streamed_commands import StreamedCommands
from aioduco.models.quaternions import from_rpy, inverse, rotated

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco import Robot, WorkerOptions


_Frame: TypeAlias = Literal["base", "tool", "flange"]
_log = BackgroundLogger(__name__)
_ACCELERATION, _TURN_ACCELERATION = 1.0, 4.0  # m/s², rad/s²
_STILL = (0.0,) * 6


class TwistCommands(StreamedCommands):
    """Speeds of the tool of one arm, followed by a speed stream that is open while they arrive.

    Args:
        robot: the robot, open.
        base: frame of the arm's base; commands without a frame are in it, too.
        tips: frames at the tool's tip.
        flange: frame at the flange, from whose axes those of the tool may be turned.
        busy: returns whether something else uses the arm, such as a trajectory goal.
        timeout: time without commands after which the stream ends [s].
        options: options of the stream; None: in a separate process.

    Attributes:
        following: whether the stream is open.
    """

    def __init__(
        self,
        robot: Robot,
        *,
        base: str,
        tips: Sequence[str],
        flange: str,
        busy: Callable[[], bool],
        timeout: float,
        options: WorkerOptions | None = None,
    ) -> None:
        super().__init__(robot, _log, busy=busy, timeout=timeout, options=options)
        self._frames: dict[str, _Frame] = dict.fromkeys(("", base), "base")
        self._frames |= {**dict.fromkeys(tips, "tool"), flange: "flange"}
        #: the newest command, and the frame of its axes
        self._newest: tuple[_Frame, tuple[float, ...]] | None = None

    def take(self, twist: Sequence[float], frame: str = "") -> bool:
        """Take a command; only the newest counts. Return whether it may be followed.

        Args:
            twist: speed along x, y, z [m/s], and about them [rad/s].
            frame: frame of the axes: the base's, empty for that, or one at the tool.
        """
        axes = self._frames.get(frame)
        if axes is None or not all(map(math.isfinite, twist)):
            # it keeps no stream open: the arm would go on with the twist before it
            known = ", ".join(self._frames)
            text = "twist refused: not finite, or frame %r is none of %s"
            self._warn("refused", text, frame, known)
            return False
        self._note_command()
        if self._refused() or (not self.following and self._busy()):
            return False
        self._newest = axes, tuple(twist)
        self._changed.set()
        return True

    def _block(self) -> None:
        super()._block()
        self._newest = None

    async def run(self) -> None:
        """Follow commands until this is cancelled; the arm then comes to rest."""
        while True:
            if self._newest is None or self._newest[1] == _STILL:
                self._newest, self._changed = None, anyio.Event()
                await self._changed.wait()
                continue
            try:
                await self._follow(self._newest[0])
            except DucoError as error:
                self._block()
                _log.warning("twist commands: %s", error)
            self._newest = None

    async def _follow(self, frame: _Frame) -> None:
        """Follow commands of one frame in one stream, until they cease or have another one."""
        turn = from_rpy(0.0, 0.0, 0.0)
        if frame == "flange":  # a stream has the axes of the tool
            offset = await self._robot.frames.get_tcp_offset()
            turn = inverse(from_rpy(*offset[3:]))
        try:
            async with self._robot.speed.linear(
                a=_ACCELERATION,
                turn_a=_TURN_ACCELERATION,
                frame="base" if frame == "base" else "tool",
                hold=2.0 * self._timeout,
                options=self._options,
            ) as stream:
                self._opened()
                while anyio.current_time() - self._came < self._timeout:
                    axes, twist = self._newest or (frame, _STILL)
                    if axes != frame:
                        break  # the next stream has the other one
                    self._changed = anyio.Event()
                    try:
                        await stream.send((*rotated(turn, twist[:3]), *rotated(turn, twist[3:])))
                    except ParameterError as error:
                        self._warn("out of range", "twist refused, the arm stands: %s", error)
                        await stream.send(_STILL)  # it would go on with the twist before it
                    with anyio.move_on_after(self._timeout):
                        await self._changed.wait()
        finally:
            self._ended()
