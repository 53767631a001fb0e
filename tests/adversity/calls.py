"""Calls whose answers name their call, and a record of the outcome of each.

Each call carries a number that no other call carries, in its arguments; the server returns a
function of the arguments. So an answer that was delivered to a wrong call is seen by its value,
and a command that arrived twice by its number in the server's log.
"""

from __future__ import annotations

import itertools
import random
import threading
import time
from collections import Counter
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

import anyio

from aioduco._wire.idempotence import CallKind, call_kind
from aioduco.errors import ConnectError, ControllerError, NotSent, OutcomeUnknown
from aioduco.errors import ConnectionLost as Lost
from aioduco.testing import RecordingServer

#: what the proxy says in its application errors: no other may be seen by a caller
NO = "not today"


def _joints(token: int) -> list[float]:
    return [token + axis / 8 for axis in range(6)]


@dataclass(frozen=True)
class Call:
    """One call, its number, and the only answer that is true."""

    token: int
    method: str
    args: tuple[Any, ...]
    answer: Any


ANSWERS: dict[str, Callable[..., Any]] = {
    "get_system_value_double": lambda name: int(name[1:]) + 0.25,
    "get_system_value_str": lambda name: name[::-1],
    "get_system_value_list": lambda name: [float(name[1:])] * (int(name[1:]) % 60),
    "cal_ikine": lambda p, q_near, tool, wobj: [value + 0.5 for value in p],
    "cal_fkine": lambda joints, tool, wobj: joints[::-1],
    "write_word_reg": lambda num, value: value ^ 0x55,
    "set_system_value_double": lambda name, value: int(value) + 1,
    "log_info": lambda message: None,
    "speedj": lambda joints, acceleration, seconds, block: int(joints[0]),
    "stop": lambda block: 0,
}

_ARGUMENTS: dict[str, Callable[[int], tuple[Any, ...]]] = {
    "get_system_value_double": lambda token: (f"v{token}",),
    "get_system_value_str": lambda token: (f"v{token}",),
    "get_system_value_list": lambda token: (f"v{token}",),
    "cal_ikine": lambda token: (_joints(token), [], [], []),
    "cal_fkine": lambda token: (_joints(token), [], []),
    "write_word_reg": lambda token: (1, token),
    "set_system_value_double": lambda token: ("x", float(token)),
    "log_info": lambda token: (f"v{token}",),
    "speedj": lambda token: (_joints(token), 1.0, 0, False),
}

_TOKEN: dict[str, Callable[[tuple[Any, ...]], int]] = {
    "get_system_value_double": lambda args: int(args[0][1:]),
    "get_system_value_str": lambda args: int(args[0][1:]),
    "get_system_value_list": lambda args: int(args[0][1:]),
    "cal_ikine": lambda args: int(args[0][0]),
    "cal_fkine": lambda args: int(args[0][0]),
    "write_word_reg": lambda args: int(args[1]),
    "set_system_value_double": lambda args: int(args[1]),
    "log_info": lambda args: int(args[0][1:]),
    "speedj": lambda args: int(args[0][0]),
}

METHODS = tuple(_ARGUMENTS)
_tokens = itertools.count(1)


def make(method: str) -> Call:
    """A new call of a function, with a number of its own."""
    token = next(_tokens)
    args = _ARGUMENTS[method](token)
    return Call(token, method, args, ANSWERS[method](*args))


class Lag:
    """How late the machine is at worst, so that a busy one is not taken for a fault.

    While its block runs, a task of the event loop and a plain thread wake up again and again, and
    look how late they are.
    """

    _EVERY = 0.005

    def __init__(self) -> None:
        self.worst = 0.0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="lag")

    async def __aenter__(self) -> Self:
        self._group = await anyio.create_task_group().__aenter__()
        self._group.start_soon(self._watch_loop)
        self._thread.start()
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> bool | None:
        self._ended.set()
        self._group.cancel_scope.cancel()
        try:
            return await self._group.__aexit__(kind, exc, traceback)
        finally:
            self._thread.join()

    async def _watch_loop(self) -> None:
        due = time.monotonic()
        while True:
            due += self._EVERY
            await anyio.sleep(max(0.0, due - time.monotonic()))
            due = self._seen(due)

    def _watch(self) -> None:
        due = time.monotonic()
        while not self._ended.wait(max(0.0, due - time.monotonic())):
            due = self._seen(due) + self._EVERY

    def _seen(self, due: float) -> float:
        now = time.monotonic()
        self.worst = max(self.worst, now - due)
        return max(due, now)


class CallRecords:
    """What came of each call, checked as it comes; `close` checks it against the server's log."""

    #: s by which an await may outlive its deadline or its cancellation
    PATIENCE = 0.5

    def __init__(self, rng: random.Random) -> None:
        self._rng = rng
        self._outcomes: list[tuple[Call, str]] = []
        self.wrong: list[str] = []
        self.overshoot = 0.0
        self._longest = "no call"

    @property
    def outcomes(self) -> Counter[str]:
        """How many calls ended in which way."""
        return Counter(outcome for _, outcome in self._outcomes)

    def note(self, call: Call, outcome: str) -> None:
        self._outcomes.append((call, outcome))

    async def follow(
        self,
        call: Call,
        begin: Callable[[str, tuple[Any, ...], float], Awaitable[Any]],
        timeout: float,
        cancel_after: float | None = None,
    ) -> None:
        """Make a call, perhaps cancel it, and write down what came of it."""
        start = time.monotonic()
        limit = timeout if cancel_after is None else min(timeout, cancel_after)
        with anyio.move_on_after(cancel_after) as scope:
            await self._outcome(call, begin(call.method, call.args, timeout))
        if scope.cancelled_caught:
            self.note(call, "cancelled")
        self._took(call, time.monotonic() - start - limit)

    def follow_blocking(
        self, call: Call, begin: Callable[[str, tuple[Any, ...], float], Any], timeout: float
    ) -> None:
        """The same for a call from a plain thread."""
        start = time.monotonic()
        try:
            self._answered(call, begin(call.method, call.args, timeout))
        except Exception as exc:
            self._failed(call, exc)
        self._took(call, time.monotonic() - start - timeout)

    def _took(self, call: Call, longer: float) -> None:
        """Note by how much a call outlived its time, with what came of it."""
        if longer > self.overshoot:
            self.overshoot = longer
            self._longest = f"{call}, {self._outcomes[-1][1]}, on {threading.current_thread().name}"

    async def _outcome(self, call: Call, answer: Awaitable[Any]) -> None:
        try:
            self._answered(call, await answer)
        except Exception as exc:
            self._failed(call, exc)

    def _answered(self, call: Call, answer: Any) -> None:
        if answer != call.answer:
            self.wrong.append(f"{call} was answered by {answer!r}")
        self.note(call, "answered")

    def _failed(self, call: Call, exc: Exception) -> None:
        command = call_kind(call.method) is not CallKind.READ
        match exc:
            case ControllerError() if NO in str(exc):
                self.note(call, "error")
            case ConnectError() | NotSent():
                self.note(call, "not sent")
            case OutcomeUnknown() if command:
                self.note(call, "unknown")
            case Lost():
                # of a command, this type says that nothing was sent
                self.note(call, "not sent" if command else "lost")
            case _:
                self.wrong.append(f"{call} raised {exc!r}")

    def check(self, server: RecordingServer, lag: Lag | None = None) -> None:
        """Check all that came of the calls against what the server received.

        To be called when no call can be on its way any more.
        """
        arrived = Counter(
            _TOKEN[received.method](received.args)
            for received in server.received()
            if received.method in _TOKEN
        )
        for call, outcome in self._outcomes:
            if call.method not in _TOKEN:
                continue
            times = arrived[call.token]
            if call_kind(call.method) is CallKind.READ:
                allowed = range(1, 3) if outcome == "answered" else range(3)
            elif outcome == "answered":
                allowed = range(1, 2)
            elif outcome == "not sent":
                allowed = range(1)
            else:
                allowed = range(2)
            if times not in allowed:
                self.wrong.append(f"{call} ({outcome}) arrived {times} times")
        # A busy machine may be late at each wake-up of a call: when it is connected, at its answer,
        # and the same for a stop that a thread sends on a second connection.
        patience = self.PATIENCE + 4.0 * (lag.worst if lag else 0.0)
        if self.overshoot > patience:
            self.wrong.append(
                f"{self._longest}, took {self.overshoot:.3f} s longer than it may; "
                f"the machine was late by {lag.worst if lag else 0.0:.3f} s at worst"
            )
        if self.wrong:
            raise AssertionError("\n".join(self.wrong))
