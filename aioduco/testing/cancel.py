"""Cancel a program at its first await, at its second, and so on to its last.

A coroutine can be cancelled only where it is suspended. The harness steps the coroutine itself,
counts its suspensions, and cancels it at a chosen one. So it needs no guesses about time, and it
covers every place where a cancellation can arrive.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import anyio
import anyio.lowlevel

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Coroutine, Generator

How = Literal["scope", "task"]
"""How a program is cancelled.

"scope": by an anyio cancel scope around it, as by `move_on_after` or a task group. Shielded
parts run on; the rest is cancelled at every await until it has ended.

"task": once, at this await alone, as by `asyncio.Task.cancel`: that is what Ctrl-C under
`asyncio.run`, `asyncio.timeout` and `asyncio.TaskGroup` do. No shield keeps it away.
"""


@dataclass(frozen=True, slots=True)
class Cancelled:
    """One run of a program that was to be cancelled.

    Attributes:
        at: number of the await at which it was to be cancelled, from 1.
        struck: whether the program reached this await and was cancelled.
        strikes: how often it was cancelled.
        awaits: number of awaits that it reached in all.
        error: exception that it raised, other than the cancellation; None if there was none.
        ended: "cancelled" if it raised the cancellation, "returned", or "raised".
    """

    at: int
    struck: bool
    strikes: int
    awaits: int
    error: Exception | None
    ended: Literal["cancelled", "returned", "raised"]


class _Stepped:
    """Runs a coroutine, and cancels it at chosen suspensions."""

    def __init__(self, program: Coroutine[Any, Any, object], at: int, again: int, how: How) -> None:
        self._program = program
        self._at = range(at, at + again + 1)
        self._how = how
        self.scope = anyio.CancelScope()
        self.awaits = 0
        self.strikes = 0

    def __await__(self) -> Generator[Any, Any, object]:
        value: Any = None
        error: BaseException | None = None
        while True:
            try:
                waited = self._program.send(value) if error is None else self._program.throw(error)
            except StopIteration as end:
                return end.value
            self.awaits += 1
            error = value = None
            if self.awaits in self._at:
                error = self._cancel(waited)
            if error is None:
                try:
                    value = yield waited
                except BaseException as exc:
                    error = exc

    def _cancel(self, waited: Any) -> BaseException | None:
        """Cancel; return the exception to raise in the program at once, if any."""
        self.strikes += 1
        if self._how == "scope":
            self.scope.cancel()
            return None
        # The event loop cancels a task in the same way: by the future that it waits for. A bare
        # yield waits for nothing.
        if waited is not None and waited.cancel():
            return None
        return anyio.get_cancelled_exc_class()()


async def cancel_at(
    program: Callable[[], Coroutine[Any, Any, object]],
    at: int,
    *,
    how: How = "scope",
    again: int = 0,
) -> Cancelled:
    """Run a program, and cancel it at one of its awaits.

    Args:
        program: makes the coroutine.
        at: number of the await, from 1.
        how: by a cancel scope or as a task.
        again: number of the awaits that follow at which it is cancelled once more.

    Returns:
        The result of the run.
    """
    stepped = _Stepped(program(), at, again, how)
    error: Exception | None = None
    ended: Literal["cancelled", "returned", "raised"] = "returned"
    with stepped.scope:
        try:
            await stepped
        except anyio.get_cancelled_exc_class():
            ended = "cancelled"
            if how == "scope":
                raise
        except Exception as exc:
            ended, error = "raised", exc
    # raises if the caller was cancelled, too
    await anyio.lowlevel.checkpoint()
    return Cancelled(at, stepped.strikes > 0, stepped.strikes, stepped.awaits, error, ended)


async def cancel_at_every_await(
    program: Callable[[], Coroutine[Any, Any, object]],
    check: Callable[[Cancelled], Awaitable[object]],
    *,
    how: How = "scope",
    again: int = 0,
    first: int = 1,
    step: int = 1,
) -> int:
    """Run a program repeatedly, and cancel it at a later await each time, up to its last.

    Args:
        program: makes the coroutine; called for each run.
        check: awaited with the result of each run; raises if that is wrong.
        how: by a cancel scope or as a task.
        again: number of the awaits that follow at which it is cancelled once more.
        first: number of the await to begin with.
        step: number of awaits by which the next run is cancelled later.

    Returns:
        How many runs were cancelled.
    """
    at, runs = first, 0
    while True:
        run = await cancel_at(program, at, how=how, again=again)
        await check(run)
        if not run.struck:
            return runs
        runs += 1
        at += step
