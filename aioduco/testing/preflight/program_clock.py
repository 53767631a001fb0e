"""The program's time: the simulator's time, which advances only while the program waits.

Guarantees:
- While the program computes, or one of its calls is in progress, simulated time stands. So the
  program reacts as fast as on a fast computer, even if this one is slow or busy. If simulated time
  would fall behind the wall clock by more than `STALL`, it follows the wall clock for as long as
  necessary.
- While the program waits, time runs as fast as this computer can simulate, up to exactly the next
  moment at which one of its waits ends. While an event loop that has a timer of this package due
  does not get to run, such as for the next poll of a task, time stands.
- While a stream's worker runs, which is a process with its own schedule, time is the wall clock's.
"""

from __future__ import annotations

import contextlib
import heapq
import math
import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from aioduco.sim import Simulator


#: longest time for which a computing program holds simulated time, by the wall clock [s]
STALL = 0.05
#: step of time if there is no timer to wait for [s]
_STEP = 0.2
#: simulated seconds per real second while the program waits: more than any computer reaches
_FAST = 1e5
#: number of sleeps that are remembered, of those that last so long [s]
_SLEEPS, _LONG = 100, 1.0
#: time between two checks of a program that computes or does not wake up, by the wall clock [s]
_LOOK = 0.02

# the program's own functions of this name are replaced
_monotonic = time.monotonic


@dataclass(frozen=True, slots=True)
class _Timer:
    """A function to call at a time of the program's clock.

    Attributes:
        made: time at which the timer was created [s].
        fire: the function.
        alive: whether it is still to be called.
    """

    made: float
    fire: Callable[[], object]
    alive: Callable[[], bool]


@dataclass(slots=True, eq=False)
class Wait:
    """One wait of a thread.

    Attributes:
        thread: id of the thread.
        due: when it ends by itself, by the wall clock [s].
        counts: whether the clock counts it as waiting.
    """

    thread: int
    due: float
    counts: bool = False


class ProgramClock:
    """Follows a simulator's time, and holds it while the program runs.

    An actor is a thread of the program whose computing holds the time: its main thread, each thread
    with an event loop, and each of a pool while it computes for such a loop.
    """

    #: longest time for which a thread of a pool is one, by the wall clock [s]: one that takes
    #: longer is taken for one that runs beside the program, such as for a keyboard
    LONGEST = 10.0

    def __init__(self) -> None:
        self._state = threading.Condition(threading.RLock())
        self._simulator: Simulator | None = None
        self._zero = _monotonic()
        #: offset on the simulator's time, or on the wall clock without a simulator [s]
        self._offset = 0.0
        self._actors: dict[int, int] = {}
        #: until when those of pools are actors, by the wall clock [s]
        self._limits: dict[int, float] = {}
        self._waits: set[Wait] = set()
        self._calls = 0
        self._streams: list[Callable[[], bool]] = []
        self._timers: list[tuple[float, int, _Timer]] = []
        #: when the last longer sleeps began and ended
        self._slept: deque[tuple[float, float]] = deque(maxlen=_SLEEPS)
        self._count = 0
        self._let_go: Callable[[], None] | None = None
        self._held_at = math.inf
        self._quiet = False
        #: times of the wall clock and the simulator from which the delay is measured
        self._level = (_monotonic(), 0.0)
        self._behind = False
        self._closed = False
        self._thread = threading.Thread(target=self._run, name="preflight-clock", daemon=True)

    def start(self) -> None:
        """Start the thread that advances time; the calling thread becomes an actor."""
        self._actors[threading.get_ident()] = 0
        self._thread.start()

    def close(self) -> None:
        """End the thread; time then follows the wall clock."""
        self.detach()
        with self._state:
            self._closed = True
            self._state.notify_all()
        self._thread.join()

    # -- the time ----------------------------------------------------------------------------

    def now(self) -> float:
        """The program's time [s]; it starts at the value of `time.monotonic`."""
        simulator = self._simulator
        if simulator is None:
            return _monotonic() + self._offset
        return simulator.clock.now() + self._offset

    @property
    def passed(self) -> float:
        """The program's time since its start [s]."""
        return self.now() - self._zero

    def attach(self, simulator: Simulator) -> None:
        """Follow a started simulator from now on."""
        self.detach()
        with self._state:
            now = self.now()
            self._simulator = simulator
            self._offset = now - simulator.clock.now()
            self._level = (_monotonic(), simulator.clock.now())
            if not self._quiet:
                self._hold(simulator.clock.now())

    def detach(self) -> None:
        """Follow the wall clock."""
        with self._state:
            if self._simulator is None:
                return
            now = self.now()
            self._release(1.0)
            self._simulator = None
            self._offset = now - _monotonic()

    def tick(self) -> None:
        """Fire due timers; called after each cycle on the simulation's thread."""
        simulator = self._simulator
        if simulator is None or simulator.clock.now() + 1e-9 < self._held_at:
            return
        with self._state:
            if not self._fire() and self._quiet:
                self._hold_until_next()

    # -- timers and waits ----------------------------------------------------------------------

    def at(
        self, when: float, fire: Callable[[], object], alive: Callable[[], bool] = lambda: True
    ) -> None:
        """Schedule a call at a time [s], on any thread."""
        timer = _Timer(self.now(), fire, alive)
        with self._state:
            self._count += 1
            heapq.heappush(self._timers, (when, self._count, timer))
            if self._quiet:
                self._hold_until_next()

    @contextlib.contextmanager
    def standing_at(self, when: float, fire: Callable[[], object] = lambda: None) -> Iterator[None]:
        """Let time stand from a moment on, until the thread that waits for it leaves the block.

        Args:
            when: the moment [s].
            fire: called then.
        """
        stands = over = False

        def stand() -> None:
            nonlocal stands
            if not over:
                stands = True
                self.call_begins()
            fire()

        self.at(when, stand, lambda: not over)
        try:
            yield
        finally:
            with self._state:
                over = True
                if stands:
                    self.call_ends()

    def sleep(self, seconds: float) -> None:
        """Let `seconds` of the program's time pass."""
        if self._simulator is None:
            self._offset += max(0.0, seconds)
            return
        # No event: its wait would want the clock with a lock in hand, which the clock wants then.
        over = threading.Lock()
        over.acquire()
        with self.standing_at(self.now() + seconds, over.release), self.waiting():
            over.acquire()

    def slept_until(self, passed: float) -> float:
        """When the last sleep ended that began up to a time since the start [s]; now if one is on.

        Returns:
            A time since the start [s]; 0 if there was none.
        """
        begun = passed + self._zero
        with self._state:
            if any(each.alive() and each.made <= begun for *_, each in self._timers):
                return self.passed
            ended = [ended for made, ended in self._slept if made <= begun]
            return max(ended, default=self._zero) - self._zero

    @contextlib.contextmanager
    def waiting(self, timeout: float | None = None) -> Iterator[Wait]:
        """Mark the calling thread as waiting during the block, if it is an actor.

        Args:
            timeout: time after which the wait ends by itself, by the wall clock [s]; None: never.
        """
        due = math.inf if timeout is None else _monotonic() + timeout
        wait = Wait(threading.get_ident(), due)
        if wait.thread not in self._actors:
            # without the lock: the simulation's thread waits with a lock that `_hold` needs
            yield wait
            return
        with self._state:
            if wait.thread in self._actors:
                wait.counts = True
                self._waits.add(wait)
                self._actors[wait.thread] += 1
                self._change()
        try:
            yield wait
        finally:
            self.wake(wait)

    def wake(self, wait: Wait) -> None:
        """A wait is over, although its thread may not be running yet."""
        if not wait.counts:
            return
        with self._state:
            if wait.counts:
                wait.counts = False
                self._waits.discard(wait)
                if wait.thread in self._actors:
                    self._actors[wait.thread] -= 1
                self._change()

    def add_actor(self, longest: float | None = None) -> None:
        """The calling thread is an actor: it runs an event loop, or computes for one.

        Args:
            longest: time for which it is one at most, by the wall clock [s]; None for no limit.
        """
        with self._state:
            self._actors.setdefault(threading.get_ident(), 0)
            if longest is not None:
                self._limits[threading.get_ident()] = _monotonic() + longest
            self._change()

    def remove_actor(self) -> None:
        """The calling thread's loop, or what it computed for one, has ended."""
        with self._state:
            self._limits.pop(threading.get_ident(), None)
            if threading.current_thread() is not threading.main_thread():
                self._actors.pop(threading.get_ident(), None)
                self._change()

    def call_begins(self) -> None:
        """A call is in progress that the controller answers at once."""
        with self._state:
            self._calls += 1
            self._change()

    def call_ends(self) -> None:
        """A call is answered, or the controller waits before it answers."""
        with self._state:
            self._calls -= 1
            self._change()

    def stream_begins(self, over: Callable[[], bool]) -> None:
        """A worker with its own schedule runs until `over` returns true."""
        with self._state:
            self._streams.append(over)
            self._release(1.0)

    # -- inside, under the lock ------------------------------------------------------------------

    def _change(self) -> None:
        quiet = self._calls <= 0 and all(self._actors.values())
        if quiet is self._quiet:
            return
        self._quiet = quiet
        if quiet:
            if not self._fire():
                self._hold_until_next()
        elif self._simulator is not None and not self._streams and not self._behind:
            self._hold(self._simulator.clock.now())

    def _hold(self, at: float) -> None:
        assert self._simulator is not None
        before = self._let_go
        # Lasting: if a busy computer suspends all threads for seconds, no thread could renew the
        # hold before the simulator had advanced by minutes.
        self._let_go = self._simulator.clock.hold(at, lasting=True)
        self._held_at = at
        if before is not None:
            before()

    def _release(self, speed: float) -> None:
        if self._let_go is not None:
            self._let_go()
            self._let_go = None
        self._held_at = math.inf
        if self._simulator is not None:
            self._held_at = self._next() - self._offset
            self._simulator.speed = speed

    def _next(self) -> float:
        while self._timers and not self._timers[0][2].alive():
            heapq.heappop(self._timers)
        return self._timers[0][0] if self._timers else math.inf

    def _hold_until_next(self) -> None:
        simulator = self._simulator
        if simulator is None or self._streams:
            return
        now = simulator.clock.now()
        overdue = any(wait.due < _monotonic() for wait in self._waits)
        self._hold(now if overdue else min(self._next() - self._offset, now + _STEP))
        simulator.speed = _FAST

    def _fire(self) -> bool:
        fired = False
        while self._next() <= self.now() + 1e-9:
            timer = heapq.heappop(self._timers)[2]
            if (now := self.now()) - timer.made >= _LONG:
                self._slept.append((timer.made, now))
            timer.fire()
            fired = True
        return fired

    # -- the thread ------------------------------------------------------------------------------

    def _run(self) -> None:
        with self._state:
            while not self._closed:
                self._look()

    def _look(self) -> None:
        for thread in [each for each, until in self._limits.items() if until < _monotonic()]:
            del self._limits[thread]
            self._actors.pop(thread, None)
            self._change()
        if self._simulator is None:
            self._state.wait(_LOOK)
            self._fire()
            return
        if self._streams:
            self._streams = [over for over in self._streams if not over()]
            if self._streams:
                self._fire()
                self._held_at = self._next() - self._offset
                self._state.wait(_LOOK)
                return
        wall, simulated = _monotonic(), self._simulator.clock.now()
        late = (wall - self._level[0]) - (simulated - self._level[1])
        self._behind = late > STALL and not self._quiet
        if late < 0.0:
            self._level = (wall, simulated)
        if not self._quiet:
            if self._behind:
                self._release(1.0)
            self._fire()
            self._state.wait(_LOOK)
            return
        if not self._fire() and simulated + 1e-9 >= self._held_at:
            self._hold_until_next()  # the woken threads had nothing to do
        self._state.wait(_LOOK)
