"""Stop, pause, resume, abort: on connections that nothing else uses.

Guarantees:
- A stop waits only behind another stop. It has a connection of its own, opened with the robot;
  pause, resume and abort use a second one.
- An unanswered stop is repeated over a fresh connection until its deadline: it is the only
  command that is safe to repeat. If no answer comes by the deadline, `StopUnconfirmed` is raised.
- An attempt for which there was no memory counts as unanswered, and is repeated like one.
- If a stop is requested while a motion is on its way, the controller may serve the stop first.
  The sender of the motion detects this by its permit, and stops once more.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, TypeAlias

import anyio

from aioduco._process import trial
from aioduco.errors import DucoError, OutcomeUnknown, Refused, StopUnconfirmed
from aioduco.supervision.rest import bring_to_rest
from aioduco.supervision.unanswered import UnansweredMotion

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.channel import LaneCall
    from aioduco._wire.lane import WireLane

#: seconds after which an unanswered stop is repeated over a fresh connection; doubled each time
FIRST_ATTEMPT = 0.25
#: the maximum of that: a connection that is made while the network is down detects late that it is
#: up again
_LONGEST_ATTEMPT = 1.0
#: seconds of `robotmoving` without an answer after which a fresh connection is used
_ASK_LIMIT = 0.5
#: the same after the deadline
_LAST_LIMIT = 0.25


#: a stop that was begun: when [s of `time.monotonic`], and its call; or why it was not sent
_Begun: TypeAlias = "tuple[float, LaneCall | Exception]"


class StopChannel:
    """Stops and pauses the arm, and waits until it stands.

    Args:
        stop: lane for stops alone.
        others: lane for pause, resume and abort.
        watch: lane for polls whether the arm moves.

    Attributes:
        others: lane for pause, resume and abort.
        stops: number of stops that the controller accepted.
        attempts: number of stops that were sent, repeats included.
    """

    def __init__(self, stop: WireLane, others: WireLane, watch: WireLane) -> None:
        self._stop = stop
        self.others: WireLane = others
        self._watch = watch
        self.stops: int = 0
        self.attempts: int = 0
        self._begun: _Begun | None = None

    def begin(self, timeout: float) -> _Begun:
        """Send a stop before anything else runs on the event loop.

        `stop` must be awaited next: it waits until the controller accepts it, or sends it again.

        Args:
            timeout: seconds within which the controller must accept it.

        Returns:
            When it was sent, and its call; or why it was not sent.

        Raises:
            WrongLoop: this is not the robot's event loop; nothing was sent.
            WrongProcess: this is a forked child; nothing was sent.
        """
        self._stop.owner_loop.require("stop")
        at = time.monotonic()
        self.attempts += 1
        try:
            self._begun = at, self._send(self._stop, min(FIRST_ATTEMPT, timeout))
        except (DucoError, MemoryError) as exc:
            self._begun = at, exc
        return self._begun

    async def stop(self, timeout: float) -> None:
        """Send a stop until the controller accepts one.

        Args:
            timeout: seconds within which it must accept one.

        Raises:
            StopUnconfirmed: it accepted none in time.
            WrongLoop: this is not the robot's event loop; nothing was sent.
            WrongProcess: this is a forked child; nothing was sent.
        """
        begun = self._begun
        # A stop that was begun and never awaited says nothing about the arm's present state.
        if begun is None or time.monotonic() - begun[0] > FIRST_ATTEMPT:
            begun = self.begin(timeout)
        self._begun = None
        at, first = begun
        until = at + timeout
        error = first if isinstance(first, Exception) else None
        call = None if isinstance(first, Exception) else first
        budget = FIRST_ATTEMPT
        lanes = (self._stop, self.others)
        attempt, left = 0, until - time.monotonic()
        while call is not None or left > 0:
            began = time.monotonic()
            try:
                if call is None:
                    # Each repeat uses the other lane: a cause that blocks one lane does not block
                    # both.
                    self.attempts += 1
                    call = self._send(lanes[attempt % 2], min(budget, left))
                error = refusal("stop", await call.answer())
                if error is None:
                    self.stops += 1
                    return
            except (DucoError, MemoryError) as exc:
                error = exc
            call = None
            attempt += 1
            # An attempt that fails at once (a refused port) must not be retried in a busy loop.
            await anyio.sleep(max(0.0, min(began + FIRST_ATTEMPT / 5, until) - time.monotonic()))
            budget = min(budget * 2, _LONGEST_ATTEMPT)
            left = until - time.monotonic()
        raise _unconfirmed(f"no stop was accepted within {timeout:.3g} s", error) from error

    @staticmethod
    def _send(lane: WireLane, timeout: float) -> LaneCall:
        call = lane.prepare("stop", (False,), timeout)
        lane.send(call)
        return call

    def stop_now(self, timeout: float) -> BaseException | None:
        """Send a stop from any thread or signal handler, and block until it is accepted.

        Args:
            timeout: seconds within which the controller must accept it.

        Returns:
            What interrupted an attempt: Ctrl-C, or what a signal handler raised; the caller raises
            it. Another attempt was accepted.

        Raises:
            StopUnconfirmed: it accepted none in time.
        """
        until = time.monotonic() + timeout
        error: BaseException | None = None
        interrupt: BaseException | None = None
        while (left := until - time.monotonic()) > 0:
            self.attempts += 1
            began = time.monotonic()
            try:
                error = refusal("stop", self._stop.call_from_thread("stop", (False,), left))
                if error is None:
                    self.stops += 1
                    return interrupt
            except (DucoError, MemoryError) as exc:
                error = exc
            except BaseException as exc:
                error = interrupt = exc
            time.sleep(max(0.0, min(began + FIRST_ATTEMPT / 5, until) - time.monotonic()))
        raise _unconfirmed(f"no stop was accepted within {timeout:.3g} s", error) from error

    async def moving(self, timeout: float = _ASK_LIMIT) -> bool:
        """Whether the arm moves.

        Args:
            timeout: seconds for the answer.

        Raises:
            DucoError: the controller does not answer.
        """
        answer: bool = await self._watch.call("robotmoving", (), timeout)
        return answer

    async def rest(
        self,
        stop_timeout: float | None,
        timeout: float,
        is_another: Callable[[], bool] = lambda: False,
    ) -> None:
        """Wait until the arm stands after a stop. A stop that has no effect is repeated.

        Args:
            stop_timeout: seconds within which a further stop must be accepted, if the arm still
                moves; None to wait without a further stop.
            timeout: seconds within which the arm must stand.
            is_another: whether what moves the arm is something that was asked for later.

        Raises:
            StopUnconfirmed: it is not known that the arm stands.
        """
        begin = time.monotonic()
        until = begin + timeout
        error: Exception | None = None

        async def stop() -> None:
            nonlocal error
            left = until - time.monotonic()
            try:
                await self.stop(min(stop_timeout or left, max(left, FIRST_ATTEMPT)))
            except StopUnconfirmed as exc:
                error = exc
                raise

        async def moves() -> bool:
            nonlocal error
            left, error = until - time.monotonic(), None
            if is_another():
                return False
            try:
                return await self.moving(min(_ASK_LIMIT, left) if left > 0 else _LAST_LIMIT)
            except (DucoError, MemoryError) as exc:
                error = exc
                raise

        motion = UnansweredMotion.none(begin, until, stops=stop_timeout is not None)
        with trial.at_own_pace():
            stands = await bring_to_rest(motion, stop, moves)
        if stands:
            return
        seconds = time.monotonic() - begin
        if isinstance(error, StopUnconfirmed):
            raise error
        if error is not None:
            raise _unconfirmed(
                f"nothing was heard of the arm for {seconds:.3g} s", error
            ) from error
        raise _unconfirmed(f"the arm still moves after {seconds:.3g} s", None)

    async def control(
        self, name: str, args: tuple[bool, ...] = (False,), timeout: float | None = None
    ) -> int:
        """Call once a function that pauses or aborts tasks, or ends a mode.

        Args:
            name: the function of the wire.
            args: its arguments.
            timeout: seconds for its answer; None for the lane's limit.

        Returns:
            Its answer: the id of the task that it became, or how it ended.

        Raises:
            Refused: the controller refused it.
            OutcomeUnknown: it was sent, but not answered.
            ConnectionLost: it was not sent.
        """
        limit = self.others.call_timeout if timeout is None else timeout
        answer: int = await self.others.call(name, args, limit)
        if (error := refusal(name, answer)) is not None:
            raise error
        return answer


def refusal(name: str, answer: int) -> Refused | None:
    """Return the error if this answer to a command says that it is not carried out."""
    return Refused(name, answer, "no reason is given") if answer < 0 else None


def _unconfirmed(what: str, error: BaseException | None) -> StopUnconfirmed:
    if isinstance(error, OutcomeUnknown):
        why = f" (the last one was sent, but {error.reason})"  # others were sent before it
    else:
        why = f" (the last answer: {str(error) or repr(error)})" if error is not None else ""
    return StopUnconfirmed(
        f"{what}{why}: the arm may be moving. Press the emergency stop if it does"
    )
