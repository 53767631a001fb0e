"""Functions of the standard library that are replaced in the process that runs the program.

- `time.sleep` and the clocks of `time`, timers of asyncio's event loops and waits of `threading`
  use `ProgramClock` when the program calls them. This package and the standard library keep the
  wall clock, so that network time-outs are real.
- What the program has a thread of a pool compute holds the time as the program itself does.
- A new task of asyncio knows the line of the program that made it.
- A coroutine that is never awaited is reported with the line that made it.
"""

from __future__ import annotations

import asyncio
import contextlib
import contextvars
import queue
import selectors
import sys
import threading
import time
import warnings
import weakref
from concurrent import futures
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import anyio.to_thread

from aioduco.testing.preflight import lines

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType

    from aioduco.testing.preflight.program_clock import ProgramClock, Wait
    from aioduco.testing.preflight.run_recorder import RunRecorder


#: modules between the program and the functions that it calls
_BETWEEN = frozenset(
    {
        *("asyncio", "anyio", "threading", "queue", "concurrent", "contextlib", "functools"),
        *("selectors", "socket", "subprocess", "logging", "multiprocessing", "tempfile"),
        *("importlib", "sniffio"),
    }
)
#: those of them that call functions and wait in threads for the program
_THREADS = frozenset({"threading", "concurrent", "anyio"})
#: threads that the program began: the stack of a timer shows neither it nor this package
_own: weakref.WeakSet[threading.Thread] = weakref.WeakSet()
#: shortest blocking of an event loop that is a finding [s]: the heartbeat's usual limit
BLOCKED = 1.0
#: time between two checks of a wait with a time-out, by the wall clock [s]
_LOOK = 0.01

# replaced below
_join = threading.Thread.join

#: event loops that were made in this process, which runs one program
loops: weakref.WeakSet[asyncio.AbstractEventLoop] = weakref.WeakSet()


def _asked_by_program(depth: int = 2) -> bool | None:
    """Whether the program made the call, and not this package; None if the stack shows neither."""
    frame: FrameType | None = sys._getframe(depth)
    while frame is not None:
        name = frame.f_globals.get("__name__", "")
        first = name.partition(".")[0]
        if first == "aioduco" and not name.startswith("aioduco.testing.preflight"):
            return bool(name.startswith("aioduco.cli"))
        if frame.f_code is lines._RUN_ONCE:
            return None
        if first not in _BETWEEN and first != "aioduco":
            return True
        frame = frame.f_back
    return None


def _asked_in_thread(depth: int) -> bool:
    """The same, with the threads that the program began if the stack shows neither."""
    asked = _asked_by_program(depth + 1)
    return threading.current_thread() in _own if asked is None else asked


def asked_by_package() -> bool:
    """Whether this package caused the event of an audit hook.

    If the stack shows neither, as in a thread of a pool, the event counts as the program's.
    """
    return _asked_by_program(3) is False


def _by_program() -> bool:
    """Whether the program called the replaced function directly, or by a thread or a pool."""
    name = sys._getframe(2).f_globals.get("__name__", "")
    first = name.partition(".")[0]
    if first in _THREADS or name == __name__:
        return _asked_in_thread(3)
    return name.startswith("aioduco.cli") if first == "aioduco" else first not in _BETWEEN


def install(clock: ProgramClock, recorder: RunRecorder) -> None:
    """Replace all of these functions, for the rest of this process.

    Args:
        clock: the program's time.
        recorder: gets the findings.
    """
    _clocks(clock, recorder)
    _loops(clock)
    _threads(clock)
    _pools(clock)
    _coroutines(recorder)


def _clocks(clock: ProgramClock, recorder: RunRecorder) -> None:
    real = {name: getattr(time, name) for name in ("monotonic", "perf_counter", "time")}
    begin: dict[str, float] = {name: function() - clock.now() for name, function in real.items()}
    begin["monotonic"] = 0.0  # the clock is on its scale

    def replaced(name: str, scale: int) -> Callable[[], float]:
        function: Callable[[], float] = getattr(time, name + ("_ns" if scale > 1 else ""))

        def read() -> float:
            if not _by_program():
                return function()
            now = begin[name] + clock.now()
            return round(now * scale) if scale > 1 else now

        return read

    for name in real:
        nanoseconds, seconds = replaced(name, 1_000_000_000), replaced(name, 1)
        setattr(time, f"{name}_ns", nanoseconds)
        setattr(time, name, seconds)

    sleep = time.sleep

    def slept(seconds: float) -> None:
        if not _by_program():
            sleep(seconds)
            return
        if seconds < 0:
            raise ValueError("sleep length must be non-negative")
        if seconds >= BLOCKED and asyncio._get_running_loop() is not None:
            recorder.blocked(lines.current(), seconds)
        clock.sleep(seconds)

    module: Any = time
    module.sleep = slept


class _Selector(selectors.DefaultSelector):
    """A selector that notifies the clock while its loop waits."""

    clock: ProgramClock
    wait: Wait | None = None

    def select(self, timeout: float | None = None) -> Any:
        self.clock.add_actor()
        if timeout is not None and timeout <= 0:
            return super().select(timeout)
        with self.clock.waiting(timeout) as self.wait:
            return super().select(timeout)

    def close(self) -> None:
        self.clock.remove_actor()
        super().close()


def _loops(clock: ProgramClock) -> None:
    _Selector.clock = clock
    base: Any = asyncio.base_events.BaseEventLoop
    selecting: Any = asyncio.SelectorEventLoop.__base__
    soon_from_thread = base.call_soon_threadsafe
    loop_time, call_at, create_task = base.time, base.call_at, base.create_task
    init = selecting.__init__
    inside = threading.local()

    def of_program() -> bool:
        asked = _asked_by_program(3)
        return bool(getattr(inside, "timer", False)) if asked is None else asked

    def new_loop(self: Any, selector: Any = None) -> None:
        init(self, _Selector() if selector is None else selector)
        loops.add(self)

    def time_of(self: Any) -> float:
        return clock.now() if of_program() else float(loop_time(self))

    def later(self: Any, delay: float, callback: Any, *args: Any, context: Any = None) -> Any:
        if of_program():
            return timer(self, clock.now() + delay, callback, args, context)
        return call_at(self, loop_time(self) + delay, callback, *args, context=context)

    def at(self: Any, when: float, callback: Any, *args: Any, context: Any = None) -> Any:
        if of_program():
            return timer(self, when, callback, args, context)
        return call_at(self, when, callback, *args, context=context)

    def timer(loop: Any, when: float, callback: Any, args: Any, context: Any) -> Any:
        handle: Any = asyncio.TimerHandle(when, callback, args, loop, context)

        def run() -> None:
            inside.timer = True
            try:
                if not handle.cancelled():
                    handle._run()
            finally:
                inside.timer = False

        def alive() -> bool:
            return not handle.cancelled() and not loop.is_closed()

        clock.at(when, lambda: alive() and loop.call_soon_threadsafe(run), alive)
        return handle

    def from_thread(self: Any, *args: Any, **options: Any) -> Any:
        wait = getattr(self._selector, "wait", None)
        if wait is not None:
            clock.wake(wait)
        origin = None if asyncio._get_running_loop() is self else lines.current()
        if origin is None:
            return soon_from_thread(self, *args, **options)
        # A task that begins so, as anyio's portals begin theirs, belongs to this line.
        token = lines.TASK_ORIGIN.set(origin)
        try:
            return soon_from_thread(self, *args, **options)
        finally:
            lines.TASK_ORIGIN.reset(token)

    def task(self: Any, coro: Any, *, context: Any = None, **options: Any) -> Any:
        origin = lines.of_new_task(by_program=bool(_asked_by_program()))
        if origin is not None:
            context = contextvars.copy_context() if context is None else context
            context.run(lines.TASK_ORIGIN.set, origin)
        return create_task(self, coro, context=context, **options)

    selecting.__init__ = new_loop
    base.call_soon_threadsafe = from_thread
    base.time, base.call_later, base.call_at, base.create_task = time_of, later, at, task


def _threads(clock: ProgramClock) -> None:
    condition: Any = threading.Condition
    thread: Any = threading.Thread
    wait, notify = condition.wait, condition.notify
    start, join = thread.start, thread.join
    waits: dict[int, list[Wait]] = {}  # for each condition, whose lock protects the list
    modules: tuple[Any, Any] = (threading, queue)
    real = modules[0]._time

    def time_of() -> float:
        """The time of waits that begin anew until their time-out is over."""
        return clock.now() if _asked_in_thread(2) else real()

    def waited(self: Any, timeout: float | None = None) -> Any:
        by_program = timeout is not None and _asked_in_thread(2)
        end = clock.now() + timeout if timeout is not None and by_program else 0.0
        standing = clock.standing_at(end) if by_program else contextlib.nullcontext()
        with standing, clock.waiting() as this:
            waits.setdefault(id(self), []).append(this)
            try:
                if not by_program:
                    return wait(self, timeout)
                while not (notified := wait(self, _LOOK)) and clock.now() < end:
                    pass
                return notified
            finally:
                waits[id(self)].remove(this)
                if not waits[id(self)]:
                    del waits[id(self)]

    def notified(self: Any, n: int = 1) -> None:
        for each in waits.get(id(self), ())[:n]:
            clock.wake(each)
        notify(self, n)

    def started(self: Any) -> None:
        starter = sys._getframe(1).f_globals.get("__name__", "")
        # the clock's own thread, too, has the program's start below it
        if not starter.startswith("aioduco.") and _asked_in_thread(2):
            _own.add(self)
        # it waits until the thread runs: on a busy computer that would be minutes of the program
        clock.call_begins()
        try:
            start(self)
        finally:
            clock.call_ends()

    def joined(self: Any, timeout: float | None = None) -> None:
        if not _asked_in_thread(2):
            join(self, timeout)  # a thread of this package, which is about to end
            return
        if timeout is None:
            with clock.waiting():
                join(self)
            return
        end = clock.now() + timeout
        with clock.standing_at(end), clock.waiting():
            while self.is_alive() and clock.now() < end:
                join(self, _LOOK)

    condition.wait, condition.notify = waited, notified
    thread.start, thread.join = started, joined
    for module, name in zip(modules, ("_time", "time"), strict=True):
        setattr(module, name, time_of)


class _Offloaded:
    """A function for a thread of a pool, which computes for the program: it holds the time.

    So does the way to the thread, once one is free, and from its end to who waits for it.

    Args:
        clock: the program's time.
        function: the function.
        works: functions of the same pool that have not ended, in their order; this one is added.
        threads: number of threads of the pool.
    """

    _lock = threading.RLock()

    def __init__(
        self,
        clock: ProgramClock,
        function: Callable[..., Any],
        works: list[_Offloaded] | None = None,
        threads: int = 1,
    ) -> None:
        self._clock, self._function = clock, function
        self._works: list[_Offloaded] = [] if works is None else works
        self._threads = threads
        self._begun = self._on_its_way = self._over = False
        #: what the pool has given for it
        self.future: futures.Future[Any] | None = None
        with self._lock:
            self._works.append(self)
            self._send()

    def __call__(self, *args: Any, **options: Any) -> Any:
        self._clock.add_actor(self._clock.LONGEST)
        with self._lock:
            self._begun = True
            self._hold(on_its_way=False)
        try:
            return self._function(*args, **options)
        finally:
            self._hold(on_its_way=True)
            self._end()
            self._clock.remove_actor()

    def over(self, *_: object) -> None:
        """Who waited for it has it, or waits no more."""
        self._over = True
        self._hold(on_its_way=False)
        self._end()

    def _end(self) -> None:
        with self._lock:
            if self in self._works:
                self._works.remove(self)
                self._send()

    def _send(self) -> None:
        for each in self._works[: self._threads]:
            if not each._begun:
                each._hold(on_its_way=True)

    def _hold(self, *, on_its_way: bool) -> None:
        with self._lock:
            holds = on_its_way and not self._over
            if holds is not self._on_its_way:
                self._on_its_way = holds
                (self._clock.call_begins if holds else self._clock.call_ends)()


def _pools(clock: ProgramClock) -> None:
    base: Any = asyncio.base_events.BaseEventLoop
    module: Any = anyio.to_thread
    pool: Any = ThreadPoolExecutor
    in_executor, run_sync = base.run_in_executor, module.run_sync
    submit, shutdown = pool.submit, pool.shutdown
    pools: weakref.WeakKeyDictionary[Any, list[_Offloaded]] = weakref.WeakKeyDictionary()

    def offloaded(self: Any, executor: Any, func: Any, *args: Any) -> Any:
        threads = executor is None or isinstance(executor, ThreadPoolExecutor)
        if not (threads and _asked_by_program()):
            return in_executor(self, executor, func, *args)
        work = _Offloaded(clock, func)
        try:
            future = in_executor(self, executor, work, *args)
        except BaseException:
            work.over()
            raise
        future.add_done_callback(work.over)
        return future

    async def synced(func: Any, *args: Any, **options: Any) -> Any:
        if not _asked_by_program():
            return await run_sync(func, *args, **options)
        work = _Offloaded(clock, func)
        try:
            return await run_sync(work, *args, **options)
        finally:
            work.over()

    def submitted(self: Any, fn: Any, /, *args: Any, **options: Any) -> Any:
        if isinstance(fn, _Offloaded) or not _asked_by_program():
            return submit(self, fn, *args, **options)
        work = _Offloaded(clock, fn, pools.setdefault(self, []), self._max_workers)
        try:
            future = work.future = submit(self, work, *args, **options)
        except BaseException:
            work.over()
            raise
        future.add_done_callback(work.over)
        return future

    def shut(self: Any, wait: bool = True, **options: Any) -> None:
        if wait and self in pools:
            shutdown(self, wait=False, **options)
            futures.wait([each.future for each in pools[self] if each.future is not None])
            for each in self._threads:
                _join(each)  # no wait of the program: they end at once
        shutdown(self, wait, **options)

    base.run_in_executor, module.run_sync = offloaded, synced
    pool.submit, pool.shutdown = submitted, shut


def _coroutines(recorder: RunRecorder) -> None:
    """Report coroutines of the program that are never awaited, with the line that made them."""
    module: Any = warnings
    unawaited = module._warn_unawaited_coroutine

    def warn(coroutine: Any) -> None:
        frames = tuple(
            (str(file), int(line), name) for file, line, name in coroutine.cr_origin or ()
        )
        recorder.never_awaited(lines.innermost(frames), f"{coroutine.__qualname__}()")
        unawaited(coroutine)

    module._warn_unawaited_coroutine = warn
    sys.set_coroutine_origin_tracking_depth(12)
