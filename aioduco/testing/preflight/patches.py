"""Functions that are replaced in the process that runs the program, and nowhere else.

- The program's clock: `time.sleep` and the clocks of `time`, timers of asyncio's event loops and
  waits of `threading` use `ProgramClock` when the program calls them. This package and the standard
  library keep the wall clock, so that network time-outs are real.
- Addresses: every connection of this package leads to the simulator.
- The interface of this package: the line and the result of each call are recorded.
"""

from __future__ import annotations

import asyncio
import contextvars
import selectors
import sys
import threading
import time
from contextlib import ExitStack
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import anyio.from_thread

from aioduco import robot as robot_module
from aioduco._wire import connection, lane
from aioduco.compat import DucoCobot
from aioduco.planning.planner import Planner
from aioduco.sim.controller.tasks import TaskTable
from aioduco.sim.runtime import SimulationRuntime
from aioduco.sim.server.processor import Processor
from aioduco.sim.view.render import PictureProcess
from aioduco.streaming.session import Session
from aioduco.supervision.command import MotionCommand
from aioduco.supervision.stop_coordinator import StopCoordinator
from aioduco.supervision.task_command import shown
from aioduco.sync._runner import Runner
from aioduco.testing.preflight import going_on, lines

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType

    from aioduco.sim.simulator import Simulator
    from aioduco.testing.preflight.program_clock import ProgramClock, Wait
    from aioduco.testing.preflight.run_recorder import ProgramCall, RunRecorder

__all__ = ["ProgramSimulator", "install"]

#: modules between the program and the functions that it calls
_BETWEEN = frozenset(
    {
        *("asyncio", "anyio", "threading", "queue", "concurrent", "contextlib", "functools"),
        *("selectors", "socket", "subprocess", "logging", "multiprocessing", "tempfile"),
        *("importlib", "sniffio"),
    }
)
#: shortest blocking of an event loop that is a finding [s]: the heartbeat's usual limit
BLOCKED = 1.0
#: least time-outs of a robot and of a stream here [s]: a busy computer is not the program's fault
_PATIENCE = {"call_timeout": 15.0, "connect_timeout": 15.0, "loop_stall_limit": 20.0}
_STREAM_PATIENCE = {"timeout": 15.0, "connect_timeout": 15.0, "away_limit": 20.0}
_HEARTBEAT = 30.0
#: time between two checks of a wait with a time-out, by the wall clock [s]
_LOOK = 0.01


class ProgramSimulator:
    """The simulator that the program runs on: its own, if it starts one, else the preflight's.

    Args:
        make: returns the preflight's simulator, started.
        attached: called with each simulator that is used.
    """

    def __init__(
        self, make: Callable[[], Simulator], attached: Callable[[Simulator], object]
    ) -> None:
        self._make = make
        self._attached = attached
        self._lock = threading.RLock()
        self.own: Simulator | None = None
        self.simulator: Simulator | None = None
        self.used: bool = False

    def address(self) -> tuple[str, int]:
        """Host and port of the simulator, to which the program's connections lead."""
        with self._lock:
            if self.simulator is None:
                self.own = self._make()
                self.attach(self.own)
            assert self.simulator is not None
            self.used = True
            return self.simulator.host, self.simulator.port

    def attach(self, simulator: Simulator) -> None:
        """Use a simulator from now on."""
        with self._lock:
            self.simulator = simulator
            self._attached(simulator)

    def ports(self) -> set[int]:
        """The ports of the simulator that is used."""
        # Without the lock: a thread that holds it may be connecting.
        used = self.simulator
        return set() if used is None else {used.port, used.status_port or used.port}

    def close(self) -> None:
        """Close the preflight's simulator, if there is one."""
        if self.own is not None:
            self.own.close()


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


def asked_by_package() -> bool:
    """Whether this package caused the event of an audit hook.

    If the stack shows neither, as in a thread of a pool, the event counts as the program's.
    """
    return _asked_by_program(3) is False


def _by_program() -> bool:
    """Whether the program called the replaced function directly."""
    name = sys._getframe(2).f_globals.get("__name__", "")
    first = name.partition(".")[0]
    return name.startswith("aioduco.cli") if first == "aioduco" else first not in _BETWEEN


def install(
    clock: ProgramClock, recorder: RunRecorder, cell: ProgramSimulator, serve: Callable[..., Any]
) -> None:
    """Replace all of these functions, for the rest of this process.

    Args:
        clock: the program's time.
        recorder: records the calls.
        cell: the simulator to which connections lead.
        serve: answers a call in the simulator's server; takes the original answering function.
    """
    _clocks(clock, recorder)
    _loops(clock)
    _threads(clock)
    _addresses(clock, cell)
    _streams(clock)
    _processes(clock)
    _unanswered(clock)
    _calls(recorder)
    _simulator(clock, recorder, serve)


def _clocks(clock: ProgramClock, recorder: RunRecorder) -> None:
    real = {name: getattr(time, name) for name in ("monotonic", "perf_counter", "time")}
    begin: dict[str, float] = {name: function() - clock.now() for name, function in real.items()}

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
        return soon_from_thread(self, *args, **options)

    def task(self: Any, coro: Any, *, name: Any = None, context: Any = None) -> Any:
        origin = lines.of_new_task(by_program=bool(_asked_by_program()))
        if origin is not None:
            context = contextvars.copy_context() if context is None else context
            context.run(lines.TASK_ORIGIN.set, origin)
        return create_task(self, coro, name=name, context=context)

    selecting.__init__ = new_loop
    base.call_soon_threadsafe = from_thread
    base.time, base.call_later, base.call_at, base.create_task = time_of, later, at, task

    portal: Any = anyio.from_thread.BlockingPortal
    start_soon = portal.start_task_soon

    def soon(self: Any, *args: Any, **options: Any) -> Any:
        origin = lines.current()
        token = lines.TASK_ORIGIN.set(origin)
        try:
            return start_soon(self, *args, **options)
        finally:
            lines.TASK_ORIGIN.reset(token)

    portal.start_task_soon = soon


def _threads(clock: ProgramClock) -> None:
    condition: Any = threading.Condition
    thread: Any = threading.Thread
    wait, notify, join = condition.wait, condition.notify, thread.join
    waits: dict[int, list[Wait]] = {}  # for each condition, whose lock protects the list

    def waited(self: Any, timeout: float | None = None) -> Any:
        by_program = timeout is not None and _asked_by_program()
        end = clock.now() + timeout if timeout is not None and by_program else 0.0
        with clock.waiting() as this:
            waits.setdefault(id(self), []).append(this)
            try:
                if not by_program:
                    return wait(self, timeout)
                clock.at(end, lambda: None)
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

    def joined(self: Any, timeout: float | None = None) -> None:
        if not _asked_by_program():
            join(self, timeout)  # a thread of this package, which is about to end
            return
        with clock.waiting():
            join(self, timeout)

    condition.wait, condition.notify, thread.join = waited, notified, joined


def _addresses(clock: ProgramClock, cell: ProgramSimulator) -> None:
    robot: Any = robot_module.Robot
    wire: Any = connection.Connection
    of_robot, of_wire = robot.__init__, wire.__init__

    def made(self: Any, host: str, port: int, settings: Any) -> None:
        there = cell.address()
        assert cell.simulator is not None
        patient = _at_least(settings, _PATIENCE)
        if settings.heartbeat is not None:
            patient["heartbeat"] = max(_HEARTBEAT, settings.heartbeat)
        patient["clock"] = cell.simulator.clock
        of_robot(self, *there, replace(settings, guard=None, lag_limit=None, **patient))
        self.host, self.port = host, port

    def opened(self: Any, _host: str, _port: int, **options: Any) -> None:
        options["connect_timeout"] = max(15.0, options.get("connect_timeout", 0.0))
        of_wire(self, *cell.address(), **options)

    robot.__init__, wire.__init__ = made, opened
    runner: Any = Runner
    open_runner, open_robot = runner.open, robot.open

    def opened_runner(self: Any) -> None:
        clock.call_begins()  # until the loop of the robot's thread waits
        try:
            open_runner(self)
        finally:
            clock.call_ends()

    async def opened_robot(self: Any) -> None:
        clock.call_begins()
        try:
            await open_robot(self)
        finally:
            clock.call_ends()

    async def closed_lane(self: Any) -> None:
        clock.call_begins()
        try:
            await close_lane(self)
        finally:
            clock.call_ends()

    lanes: Any = lane.WireLane
    close_lane = lanes.aclose
    runner.open, robot.open, lanes.aclose = opened_runner, opened_robot, closed_lane


def _streams(clock: ProgramClock) -> None:
    session: Any = Session
    of_session = session.__init__

    def made_stream(self: Any, endpoint: Any, config: Any) -> None:
        options = replace(config.options, **_at_least(config.options, _STREAM_PATIENCE))
        of_session(self, endpoint, replace(config, options=options))

    session.__init__ = made_stream
    launch = session._launch

    def launched(self: Any) -> None:
        clock.stream_begins(lambda: bool(self.gone))
        launch(self)

    session._launch = launched


def _at_least(settings: Any, least: dict[str, float]) -> dict[str, Any]:
    """Time-outs of some settings, none of them shorter than it may be."""
    return {name: max(limit, getattr(settings, name)) for name, limit in least.items()}


def _processes(clock: ProgramClock) -> None:
    """Hold the time while a process of this package plans or draws for the program."""

    def standing(asked: Callable[..., Any]) -> Callable[..., Any]:
        def ask(self: Any, request: Any) -> Any:
            clock.call_begins()
            try:
                return asked(self, request)
            finally:
                clock.call_ends()

        return ask

    planner: Any = Planner
    pictures: Any = PictureProcess
    awaited = planner._ask

    async def plan(self: Any, problem: Any) -> Any:
        clock.call_begins()  # before the loop waits for the thread that sends the request
        try:
            return await awaited(self, problem)
        finally:
            clock.call_ends()

    planner._ask, planner._solve = plan, standing(planner._solve)
    pictures._ask = standing(pictures._ask)


def _unanswered(clock: ProgramClock) -> None:
    """Run the program's time at the wall clock's rate while an unanswered command is watched."""
    coordinator: Any = StopCoordinator
    until_certain = coordinator.stop_until_certain

    async def stop_until_certain(self: Any, *arguments: Any, **options: Any) -> None:
        over = threading.Event()
        clock.stream_begins(over.is_set)
        try:
            await until_certain(self, *arguments, **options)
        finally:
            over.set()

    coordinator.stop_until_certain = stop_until_certain


def _calls(recorder: RunRecorder) -> None:
    lanes: Any = lane.WireLane
    vendor: Any = DucoCobot
    call, send = lanes.call, lanes.send
    from_thread, vendor_call = lanes.call_from_thread, vendor._call

    async def called(self: Any, name: str, args: Any, *rest: Any, **options: Any) -> Any:
        with recorder.call(name, args) as record:
            record.result = await call(self, name, args, *rest, **options)
            return record.result

    def sent(self: Any, one: Any) -> None:
        if one.further:  # of `ask`: it only reads
            send(self, one)
            return
        under_way = ExitStack()
        record = under_way.enter_context(recorder.call(one.name, one.args))
        ended = one.ended

        def over(one: Any) -> None:
            ended(one)
            record.result = one.value
            if one.error is not None:
                record.error = f"{type(one.error).__name__}: {one.error}"
            under_way.close()

        one.ended = over
        send(self, one)

    def called_from_thread(self: Any, name: str, args: Any, timeout: Any) -> Any:
        with recorder.call(name, args) as record:
            record.result = from_thread(self, name, args, timeout)
            return record.result

    def called_by_vendor(self: Any, name: str, args: Any) -> Any:
        with recorder.call(name, args) as record:
            record.of_vendor = True
            record.result = vendor_call(self, name, args)
            return record.result

    lanes.call, lanes.send, lanes.call_from_thread = called, sent, called_from_thread
    vendor._call = called_by_vendor

    motion: Any = MotionCommand
    init, gone = motion.__init__, motion.__del__

    def new(self: Any, *args: Any, **options: Any) -> None:
        init(self, *args, **options)
        recorder.made[id(self)] = lines.current()

    def forgotten(self: Any) -> None:
        origin = recorder.made.pop(id(self), None)
        if not getattr(self, "_used", True):
            recorder.never_awaited(origin and origin.where, shown(self.command))
        gone(self)

    motion.__init__, motion.__del__ = new, forgotten

    import warnings  # noqa: PLC0415 - of the process that is changed here

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


def _simulator(clock: ProgramClock, recorder: RunRecorder, serve: Callable[..., Any]) -> None:
    processor: Any = Processor
    tasks: Any = TaskTable
    runtime: Any = SimulationRuntime
    answer, new, wait = processor.answer, tasks.new, runtime.wait
    serving = threading.local()

    def answered(self: Any, message: Any) -> Any:
        record: ProgramCall | None = recorder.match_call(message.name)
        serving.record = record
        try:
            return serve(record, message.name, lambda: answer(self, message))
        finally:
            serving.record = None

    def made(self: Any, name: str) -> int:
        number: int = new(self, name)
        record: ProgramCall | None = getattr(serving, "record", None)
        if record is not None and record.task is None:
            recorder.task(record, number)
        return number

    def waited(self: Any, id_: int) -> Any:
        if getattr(serving, "record", None) is None:
            return wait(self, id_)
        clock.call_ends()
        try:
            return wait(self, id_)
        finally:
            clock.call_begins()

    processor.answer, tasks.new, runtime.wait = answered, made, waited
    going_on.install(recorder, lambda: getattr(serving, "record", None))
