"""The common parts of all grippers: their state, and a base class for drivers.

Guarantees:
- `state` takes no time: it is the state that was read last, with its age. A separate task polls
  the gripper, over connections that no motion uses.
- What fails in a driver while it reads does not end the polling.
- `carrying` ends also when it is not known any more whether the part is held: the state is older
  than `max_age`, or says nothing of it. Time in which the event loop stood still does not count.
- If a movement is cancelled, or takes too long, the gripper is halted, but keeps holding a held
  object.
- Nothing is sent if an argument is out of range.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, ClassVar, NamedTuple, Self

import anyio

from aioduco._process import trial
from aioduco._process.copying import Uncopied
from aioduco._process.reporting import BackgroundLogger
from aioduco.errors import (
    DucoError,
    GripperError,
    GripperTimeout,
    HoldUnknown,
    ObjectLost,
    ParameterError,
)
from aioduco.models import ranges
from aioduco.models.gripper_models import GripperModel
from aioduco.models.rules import Number, Vector
from aioduco.supervision.concurrency import BackgroundTasks, Silence, every

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from aioduco.robot import Robot


_log = BackgroundLogger(__name__)

_PAIR = Vector(ranges.FROM_0, length=2)
#: seconds within which the gripper must answer the command to halt
_HALTING = 2.0

#: what became of the arm when a part was lost
_NOTHING = "nothing was done to the arm"
_CANCELLED = (
    "the await in carrying() was cancelled: a motion that it awaited was stopped, or what its "
    "on_cancel says; any other motion goes on"
)
_ENDED = "the block of carrying() had ended by then: nothing was done to the arm"


class GripperState(NamedTuple):
    """State that a gripper reported.

    Attributes:
        width: opening between the fingers [m]; None if the gripper does not report it.
        holding: whether it holds something; None if it cannot detect that.
        moving: whether its fingers move, or its vacuum builds up.
        read_at: when the gripper reported it [s of `time.monotonic`].
    """

    width: float | None
    holding: bool | None
    moving: bool
    read_at: float

    @property
    def age(self) -> float:
        """Time since then [s]."""
        return time.monotonic() - trial.wall(self.read_at)


class PolledGripper(Uncopied, ABC):
    """A gripper whose state is polled; a base class for drivers.

    A driver of your own implements how the gripper is read (`_read`), moved (`_go`) and halted
    (`_halt`): see `examples/gripper_of_your_own.py`.

    Args:
        model: stroke, forces and speeds of the gripper.
        poll: seconds between two polls of the gripper's state.
        timeout: seconds within which a movement must have ended.
        max_age: seconds without a new state after which it is not known whether a part is held:
            `carrying` then stops the arm.

    Raises:
        ParameterError: a time is out of range.

    Attributes:
        model: its stroke, forces and speeds.
    """

    #: what `_halt` has done, for errors
    _HALTED: ClassVar[str] = "it was halted"

    def __init__(
        self,
        model: GripperModel,
        *,
        poll: float = 0.05,
        timeout: float = 10.0,
        max_age: float = 1.0,
    ) -> None:
        model = _checked(model)
        self.model: GripperModel = model
        self._poll = ranges.TIMEOUT("poll", poll)
        self._timeout = ranges.TIMEOUT("timeout", timeout)
        self._max_age = ranges.TIMEOUT("max_age", max_age)
        self._width = Number(0.0, model.stroke, "m", source=model.source)
        self._force = Number(*model.force, "N", source=model.source)
        self._speed = None if model.speed is None else Number(
            *model.speed, "m/s", source=model.source
        )  # fmt: skip
        self._state: GripperState | None = None
        self._lock = anyio.Lock()
        self._background = BackgroundTasks(self._poll_failed)
        self._held = self._lost = self._going = self._silent = False
        self._started = self._ended = False
        #: why the last poll failed; None if it did not
        self._failure: Exception | None = None

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.model.title}>"

    def __str__(self) -> str:
        """As errors call it."""
        return f"the {self.model.title}"

    # -- what a driver implements ---------------------------------------------------------------

    @abstractmethod
    async def _read(self) -> GripperState:
        """Read the gripper's state."""

    @abstractmethod
    async def _go(self, width: float, speed: float, force: float) -> None:
        """Send the fingers to a width [m] at a speed [m/s], with a force [N]."""

    @abstractmethod
    async def _halt(self) -> None:
        """Stop the fingers; a held object must stay held."""

    async def activate(self) -> None:
        """Make the gripper ready; if the gripper is always ready, only read its state.

        Raises:
            GripperTimeout: the gripper did not become ready.
        """
        await self.read()

    # -- start and end --------------------------------------------------------------------------

    async def start(self) -> Self:
        """Read the gripper's state, and keep polling it. Nothing moves.

        Raises:
            GripperError: it was started before, and not closed.
            ModbusError: the gripper does not answer as it should.
        """
        if self._started:
            raise GripperError(f"{self} is started already, and polled. Nothing was sent")
        self._started, self._ended = True, False
        try:
            await self.read()
        except BaseException:
            self._started = False
            raise
        name = f"aioduco gripper {self.model.name}"
        self._background.start(self._watch(), name)
        self._background.start(self._watch_age(), f"{name} age")
        return self

    async def aclose(self) -> None:
        """End the polling. The gripper stays as it is, and keeps what it holds.

        From then on it takes no commands but `halt`; a movement of another task goes on.
        """
        self._started, self._ended = False, True
        await self._background.aclose()

    async def __aenter__(self) -> Self:
        return await self.start()

    async def __aexit__(self, *_: object) -> None:
        await self.aclose()

    async def _watch(self) -> None:
        async for _ in every(self._poll):
            try:
                await self._read_state()
            except Exception as error:
                if self._failure is None:
                    trace = None if isinstance(error, DucoError) else error
                    _log.warning("%r was not read: %r", self, error, exc_info=trace)
                self._failure = error
            else:
                self._failure = None

    async def _watch_age(self) -> None:
        """Note whether no new state comes; apart from the polls, since one of them may hang."""
        silence = Silence(self._poll)
        async for _ in every(self._poll):
            age = silence.look(time.monotonic(), trial.wall(self.state.read_at))
            self._silent = age > self._max_age

    def _poll_failed(self, error: BaseException) -> None:
        self._silent = True
        _log.error("%r is not read any more: %r", self, error)

    # -- interface for programs -----------------------------------------------------------------

    @property
    def state(self) -> GripperState:
        """The state that was read last; this takes no time.

        Its `age` grows while the gripper does not answer.

        Raises:
            GripperError: it was not started.
        """
        if self._state is None:
            raise GripperError(f"{self} was not started: use it in its block. Nothing was sent")
        return self._state

    async def read(self) -> GripperState:
        """Read the gripper's state now.

        Raises:
            ModbusTimeout: the gripper does not answer.
            ModbusGarbled: the answer has a wrong checksum, or is not valid.
            GripperFault: the gripper has a fault.
            GripperError: its block has ended.
        """
        self._require_open()
        return await self._read_state()

    def _require_open(self) -> None:
        if self._ended:
            raise GripperError(f"{self} is closed: its block has ended. Nothing was sent")

    async def _read_state(self) -> GripperState:
        read = await self._read()
        state = read._replace(read_at=trial.moment(read.read_at))
        if self._held and state.holding is False and not self._going:
            self._held, self._lost = False, True
        self._state = state
        return state

    async def open(self, *, speed: float | None = None, force: float | None = None) -> GripperState:
        """Open as far as it goes; as `move`."""
        return await self.move(self.model.stroke, speed=speed, force=force)

    async def close(
        self, *, speed: float | None = None, force: float | None = None
    ) -> GripperState:
        """Close until it holds something, or as far as it goes; as `move`."""
        return await self.move(0.0, speed=speed, force=force)

    async def move(
        self, width: float, *, speed: float | None = None, force: float | None = None
    ) -> GripperState:
        """Move the fingers, and return when they stand: at the width, or at what they hold.

        Cancelling this halts the fingers; a held object stays held.

        Args:
            width: opening between the fingers, from 0 to the model's stroke [m].
            speed: speed of the opening, within the model's range [m/s]; None for half of the
                fastest.
            force: force of the grip, within the model's range [N]; None for the middle of it.

        Returns:
            The state at the end: `holding` says whether something was gripped.

        Raises:
            ParameterError: an argument is out of range, or cannot be set; nothing was sent.
            GripperNotActivated: `activate` was not called since power on; nothing moved.
            GripperFault: the gripper has a fault.
            GripperTimeout: the fingers did not come to rest; the error says if they were halted.
            GripperError: its block has ended; nothing was sent.
            ModbusTimeout: the gripper does not answer: its motion is not known.
            ModbusGarbled: an answer has a wrong checksum, or is not valid.
        """
        width_ = self._width("width", width)
        low, high = self.model.force
        force_ = 0.5 * (low + high) if force is None else self._force("force", force)
        speed_ = 0.5 * self.model.fastest
        if speed is not None:
            if self._speed is None:
                self._cannot("speed", speed)
            else:
                speed_ = self._speed("speed", speed)
        elif self._speed is not None:
            speed_ = max(speed_, self._speed.low)
        async with self._turn():
            return await self._carry_out(width_, speed_, force_)

    @asynccontextmanager
    async def _turn(self) -> AsyncIterator[None]:
        """For each command that moves the fingers: one at a time, and none after the block."""
        async with self._lock:
            self._require_open()
            with trial.at_own_pace():  # it is polled by this computer's clock
                yield

    def _cannot(self, name: str, value: float) -> None:
        raise ParameterError(name, value, f"None: that of a {self.model.title} cannot be set")

    async def _carry_out(self, width: float, speed: float, force: float) -> GripperState:
        self._held = self._lost = False
        self._going = True
        try:
            # a time-out of its own is that of a gripper that did not answer: nothing more is sent
            with anyio.move_on_after(self._timeout):
                await self._go(width, speed, force)
                state = await self._at_rest()
                self._held = state.holding is True
                return state
            halted = await self._halt_shielded()
        except anyio.get_cancelled_exc_class():
            await self._halt_shielded()
            raise
        finally:
            self._going = False
        done = self._HALTED if halted else "it could not be halted, and may still move"
        raise GripperTimeout(f"{self} did not come to rest within {self._timeout:g} s; {done}")

    async def _at_rest(self) -> GripperState:
        async for _ in every(self._poll):
            if not (state := await self._read_state()).moving:
                return state
        raise AssertionError("a schedule without end has ended")

    async def _halt_shielded(self) -> bool:
        """Halt the gripper, also if the caller is cancelled; return whether that was answered."""
        error: Exception | None = None
        with anyio.move_on_after(_HALTING, shield=True):
            try:
                await self._halt()
            except Exception as raised:  # of a driver of one's own
                error = raised
            else:
                return True
        why = error or f"it did not answer within {_HALTING:g} s"
        _log.warning("%r may go on: it was not halted: %s", self, why)
        return False

    async def halt(self) -> None:
        """Stop the fingers where they are, also while another task moves them.

        It works after the block, too.

        Raises:
            ModbusError: the gripper did not answer as it should: it may still move.
            GripperError: a DH gripper is being activated, which cannot be halted.
        """
        await self._halt()

    def check_held(self) -> None:
        """Check in the state that was read last that the gripper still holds its object.

        It returns at once, and nothing if the object is held.

        Raises:
            ObjectLost: it does not, or it gripped nothing.
            HoldUnknown: the state is older than `max_age`, or says nothing of it any more.
        """
        self._check(_NOTHING)

    def _check(self, arm: str) -> None:
        """As `check_held`; the error ends with what was done to the arm."""
        if self._lost:
            raise ObjectLost(f"{self} lost what it held: look where it lies; {arm}")
        if why := self._unknown:
            raise HoldUnknown(
                f"it is not known whether {self} still holds its part: {why}. Look at it; {arm}"
            ) from self._failure
        if self.state.holding is False:
            raise ObjectLost(f"{self} holds nothing: what it was to grip was not there; {arm}")
        # also what was gripped before the program, or by a command that was cancelled
        self._held = self._held or self.state.holding is True

    @property
    def _unknown(self) -> str:
        """Why it is not known whether the part is held; empty if it is known."""
        state = self.state
        if self._silent or (not self._background and state.age > self._max_age):
            failure = "" if self._failure is None else f" ({self._failure})"
            return f"it reported nothing for {state.age:.2g} s{failure}"
        if self._held and state.holding is None:
            return "it does not report it any more; its power may have been off"
        return ""

    @asynccontextmanager
    async def carrying(self) -> AsyncIterator[None]:
        """Monitor the held object: if it is lost, a motion that the block awaits is stopped.

            async with gripper.carrying():
                await robot.motion.movel(there, v=0.2, a=0.5)

        The same happens when it is not known any more whether the object is held: no new state came
        for `max_age`, or the state says nothing of it.

        Raises:
            ObjectLost: the object was lost, or nothing is held; the block's await was cancelled.
            HoldUnknown: it is not known whether it is held; the block's await was cancelled.
            GripperError: the gripper is not polled; the block was not entered.
        """
        if not self._background:
            raise GripperError(f"{self} is not polled: write `async with` it; {_NOTHING}")
        self._check(_NOTHING)
        error: BaseException | None = None
        cancelled = False
        async with anyio.create_task_group() as watching:
            watching.start_soon(self._cancel_when_lost, watching.cancel_scope)
            # Kept and raised outside of the task group, which would wrap the error in a group.
            try:
                yield
            except (Exception, SystemExit, KeyboardInterrupt) as raised:
                error = raised
            except anyio.get_cancelled_exc_class():
                cancelled = True
                raise
            watching.cancel_scope.cancel()
        if error is not None:
            raise error
        if self._lost or self._unknown:
            self._check(_CANCELLED if cancelled else _ENDED)

    async def _cancel_when_lost(self, scope: anyio.CancelScope) -> None:
        async for _ in every(self._poll):
            if self._lost or self._unknown:
                scope.cancel()
                return


def awaited(robot: Robot) -> Robot:
    """Return a driver's robot; one of `aioduco.sync`, whose calls are not awaited, is refused."""
    if hasattr(robot, "close"):
        made = "one of aioduco.connect; with one of aioduco.sync, aioduco.sync.Gripper(robot, …)"
        raise ParameterError("robot", robot, f"{made} makes the driver")
    return robot


def _checked(model: GripperModel) -> GripperModel:
    """The figures of a model, which a driver of one's own may have made."""
    if not isinstance(model, GripperModel):
        raise ParameterError("model", model, "a GripperModel")
    return model._replace(
        name=ranges.OWN_NAME("name", model.name),
        title=ranges.OWN_NAME("title", model.title),
        stroke=ranges.FROM_0("stroke", model.stroke),
        force=_pair("force", model.force),
        speed=None if model.speed is None else _pair("speed", model.speed),
        fastest=ranges.FROM_0("fastest", model.fastest),
    )


def _pair(name: str, value: tuple[float, float]) -> tuple[float, float]:
    low, high = _PAIR(name, value)
    if low > high:
        raise ParameterError(name, value, "the smallest, then the largest")
    return low, high
