"""A robot that counts as open, whose calls go to a function instead of a controller."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable
from contextlib import nullcontext
from typing import Any

import aioduco
from aioduco import TaskState
from aioduco._process.platform import boot_time
from aioduco.supervision.gate import Gate

#: given the function of the wire and its arguments, it returns the answer
Answer = Callable[[str, tuple[Any, ...]], Awaitable[Any]]


class _Launcher:
    """Passes each command on, and takes it for carried out."""

    def __init__(self, answer: Answer) -> None:
        self._answer = answer
        self.in_order = nullcontext()

    async def perform(self, name: str, args: tuple[Any, ...], _timeout: float) -> None:
        await self._answer(name, args)

    async def conduct(self, command: Any, *_: Any, **_options: Any) -> Any:
        return await self._answer(command.name, command.args)

    async def block(self, command: Any, _lane: Any) -> TaskState:
        return TaskState(await self._answer(command.name, command.args))

    async def feed(self, command: Any, _lane: Any, _mode: Any) -> Any:
        return await self._answer(command.name, command.args)

    def adopt(self, *_: object) -> None:
        """Its task counts as ended."""

    def require_opened(self, _name: str) -> None:
        """It counts as opened."""

    async def admit_stream(self, _name: str) -> None:
        """No stream begins here: nothing is waited for."""


class _SentCall:
    """A call that is answered when it is waited for."""

    error = None

    def __init__(self, asked: Awaitable[Any]) -> None:
        self._asked = asked

    async def wait(self) -> None:
        self.value = await self._asked


class _Permits:
    """Permits everything: what ends a permit is left out."""

    def __init__(self) -> None:
        self.gate = Gate(None, math.inf, boot_time())

    def ask(self, _name: str) -> None:
        """Permit it."""

    def within(self, _permit: None) -> nullcontext[None]:
        return nullcontext()

    def from_now(self, _name: str) -> nullcontext[None]:
        return nullcontext()


def robot_on(answer: Answer) -> aioduco.Robot:
    """A robot whose sections call this function; supervision is left out."""
    robot = aioduco.connect("192.0.2.1")
    supervisor: Any = robot._supervisor

    async def call(
        name: str, args: tuple[Any, ...], _timeout: float | None = None, **_: object
    ) -> Any:
        return await answer(name, args)

    async def end(ending: str, step: Callable[[], Awaitable[None]] | None) -> None:
        await (answer(ending, (False,)) if step is None else step())

    async def no_errors() -> tuple[str, ...]:
        return ()

    async def completed(_task: None, _timeout: float) -> None:
        """Take it for succeeded."""

    supervisor.calls.call = supervisor.blocking.call = call
    supervisor.calls.prepare = lambda name, args: _SentCall(answer(name, args))
    supervisor.calls.send = lambda _: None
    supervisor.dispatcher = _Launcher(answer)
    supervisor.permits = _Permits()
    supervisor.stop_coordinator.end = end
    supervisor.stop_coordinator.follower.error_list = no_errors
    supervisor.stop_coordinator.follower.completed = completed
    supervisor.check_open = lambda _: None
    return robot
