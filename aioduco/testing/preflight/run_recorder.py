"""Record the program's run: its calls, and the motions of the simulated arm."""

from __future__ import annotations

import contextvars
import threading
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco._wire.idempotence import CallKind, call_kind
from aioduco._wire.idl import functions
from aioduco.models.enums import TaskState
from aioduco.testing.preflight import lines
from aioduco.testing.preflight.borders import AccessBlocked

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.sim import Simulator
    from aioduco.sim.snapshot import SimulationSnapshot
    from aioduco.testing.preflight.handlers import WaitingLine
    from aioduco.testing.preflight.lines import CallOrigin, ProgramLine
    from aioduco.testing.preflight.program_clock import ProgramClock


#: time between two samples of the moving arm [s]
_SAMPLE = 0.02
#: after the end of a task, time is the wall clock's until this package has polled it: at most [s]
_POLLED = 0.1
_ENDED = frozenset(state for state in TaskState if state.ended)
#: calls that are not the program's work, but keep the connection and poll tasks
_UPKEEP = frozenset({"rpc_heartbeat", "get_noneblock_taskstate"})
_LONGEST = 80
#: values of a call that the report does not need
_NOT_REPORTED = ("taken", "waiting", "of_vendor")


@dataclass
class CheckedMotion:
    """What the check against the envelope found of the motion that is sent next.

    Attributes:
        name: the function of the wire protocol.
        impossible, slowed: as those of `ProgramCall`.
    """

    name: str
    impossible: str = ""
    slowed: float = 1.0


#: the motion that the running task sends next; None if none was checked
CHECKED: contextvars.ContextVar[CheckedMotion | None] = contextvars.ContextVar(
    "preflight_checked", default=None
)


@dataclass
class ProgramCall:
    """One call of the program that may change something.

    Attributes:
        name: the function of the wire protocol.
        text: the call as text.
        where: the line of the program; None if this package made the call by itself.
        actor: an id of the task or thread of the program.
        begin, end: times of the program [s]; -1 for none.
        radius: requested blend radius, in the unit of the function; 0 for none.
        result: the answer.
        error: the error that was raised instead.
        task: id of the task in the controller; None without a task.
        state: final state of the task; empty until it ends.
        message: the simulator's message about the end.
        started, ended: start and end of the task [s]; -1 for never.
        meanwhile: the program's line when the task ended with an error.
        waiting: the lines that wait for the call.
        impossible: why the motion cannot be carried out, if the run went on nevertheless as if it
            had been; else empty.
        replaced: whether a joint motion took its place.
        elsewhere: whether it begins where the motion before it was broken off, so that its path is
            not that of the real arm.
        of_vendor: whether the vendor's class made it, which returns the state of a motion.
        slowed: share of its speed to which the envelope slowed it; 1 if it did not.
    """

    name: str
    text: str
    where: ProgramLine | None
    actor: int
    begin: float
    end: float = -1.0
    radius: float = 0.0
    result: Any = None
    error: str = ""
    task: int | None = None
    state: str = ""
    message: str = ""
    started: float = -1.0
    ended: float = -1.0
    meanwhile: ProgramLine | None = None
    waiting: tuple[WaitingLine, ...] = field(default=(), repr=False)
    impossible: str = ""
    replaced: bool = False
    elsewhere: bool = False
    of_vendor: bool = False
    slowed: float = 1.0
    taken: bool = field(default=False, repr=False)


class RunRecorder:
    """Collects the data of a run; `as_json` and `arrays` return it.

    Args:
        clock: the program's time.
    """

    def __init__(self, clock: ProgramClock) -> None:
        self._clock = clock
        self._lock = threading.RLock()
        self.calls: list[ProgramCall] = []
        self.made: dict[int, CallOrigin | None] = {}
        self.notes: list[dict[str, Any]] = []
        self.contacts: list[dict[str, Any]] = []
        self.io: list[dict[str, Any]] = []
        self.progress: float = 0.0
        self._open: dict[int, ProgramCall] = {}
        #: tasks that have ended, as long as no poll has told so
        self._unpolled: set[int] = set()
        self._under_way: list[ProgramCall] = []
        self._simulator: Simulator | None = None
        self._next_sample = 0.0
        self._touching: dict[str, dict[str, Any]] = {}
        self._at_first: frozenset[str] | None = None
        self._levels: dict[str, bool] = {}
        self._times: list[float] = []
        self._q: list[np.ndarray[Any, np.dtype[np.float64]]] = []
        self._qd: list[np.ndarray[Any, np.dtype[np.float64]]] = []
        self._positions: list[np.ndarray[Any, np.dtype[np.float64]]] = []

    # -- calls --------------------------------------------------------------------------------

    def call(
        self, name: str, args: tuple[Any, ...], *, vendor: bool = False
    ) -> Callable[[Any, BaseException | None], None]:
        """Record a call, unless it only reads; the program's time stands until its end.

        Args:
            name: the function of the wire.
            args: its arguments.
            vendor: whether the vendor's class makes it.

        Returns:
            A function that is called once at its end, with the answer and the error.
        """
        origin = lines.current()
        record = ProgramCall(
            name,
            "",
            origin and origin.where,
            origin.actor if origin else 0,
            self._clock.passed,
            waiting=origin.waiting if origin else (),
            of_vendor=vendor,
        )
        acts = call_kind(name) is not CallKind.READ and name not in _UPKEEP
        if acts:
            record.text = _text(name, args)
            record.radius = _radius(name, args)
            if (checked := CHECKED.get()) is not None and checked.name == name:
                record.impossible, record.slowed = checked.impossible, checked.slowed
            self.progress = record.begin
            with self._lock:
                self.calls.append(record)
                self._under_way.append(record)
        self._clock.call_begins()

        def ended(answer: Any, error: BaseException | None) -> None:
            record.result = answer
            if error is not None:
                record.error = f"{type(error).__name__}: {error}"
            if name == "get_noneblock_taskstate" and answer in _ENDED:
                self._unpolled.discard(args[0])
            self._clock.call_ends()
            record.end = self._clock.passed
            if acts:
                with self._lock:
                    self._under_way.remove(record)

        return ended

    def match_call(self, name: str) -> ProgramCall | None:
        """The recorded call that the controller begins to answer; None if it is not recorded."""
        with self._lock:
            for record in self._under_way:
                if record.name == name and not record.taken:
                    record.taken = True
                    return record
        return None

    def task(self, record: ProgramCall, number: int) -> None:
        """The controller has created a task for a call."""
        record.task = number
        with self._lock:
            self._open[number] = record

    def never_awaited(self, where: ProgramLine | None, what: str) -> None:
        """An awaitable was created, and never awaited."""
        self._note("forgotten await", where, f"{what} was never awaited: nothing was sent")

    def blocked(self, origin: CallOrigin | None, seconds: float) -> None:
        """A coroutine called `time.sleep`."""
        text = f"time.sleep({seconds:g}) blocks the event loop: the heartbeat ends, the arm stops"
        self._note("blocked event loop", origin and origin.where, text)

    def not_reached(self, text: str) -> None:
        """The program tried to connect to something outside the preflight."""
        origin = lines.current()
        self._note("not reached", origin and origin.where, text)

    def second_arm(self, does: str) -> None:
        """The program uses a second arm, which leads to the simulated arm of the first."""
        self.not_reached(
            f"the program {does}: a preflight has one arm, which both are then, so that what it "
            "says of their motions is wrong. Try the part of each arm in a preflight of its own"
        )

    def failed(self, error: BaseException) -> None:
        """The program ended with an error."""
        if isinstance(error, AccessBlocked):
            return  # already reported, with its line
        if isinstance(error, BaseExceptionGroup):
            for each in error.exceptions:
                self.failed(each)
            return
        self.finish()  # a task that failed is told of before the error that it made
        where = lines.of_error(error)
        kind = type(error).__name__
        self._note(
            "error", where, f"{kind}: {error}", error=kind, task=getattr(error, "task_id", None)
        )

    def hung(self, where: ProgramLine | None, text: str) -> None:
        """The program waits for something that does not happen."""
        self._note("endless wait", where, text)

    def _note(self, kind: str, where: ProgramLine | None, text: str, **more: Any) -> None:
        with self._lock:
            self.notes.append(
                {"kind": kind, "where": where, "text": text, "time": self._clock.passed, **more}
            )

    @property
    def passing_over(self) -> bool:
        """Whether the arm moves on a path that is not the program's."""
        moving = [call for call in tuple(self._open.values()) if call.started >= 0.0]
        return any(call.replaced or call.elsewhere for call in moving)

    # -- the arm ------------------------------------------------------------------------------

    def attach(self, simulator: Simulator) -> None:
        """Observe a simulator from now on."""
        self._simulator = simulator
        self._at_first = None
        simulator.observe(self.cycle)

    def detach(self) -> None:
        """Stop observing the simulator, because it is being closed."""
        if self._simulator is not None:
            self._simulator.observe(None)
            self._simulator = None

    def cycle(self, snapshot: SimulationSnapshot, touched: Callable[[], str]) -> None:
        """Observe one cycle; called on the simulation's thread."""
        now = self._clock.passed
        view = snapshot.view
        if view.moving:
            self.progress = now
        if self._open:
            self._follow(now)
        passing_over = self.passing_over
        self._touch(touched(), now, len(self._times), meant=view.force_control or passing_over)
        if now >= self._next_sample:
            self._next_sample = now + _SAMPLE
            self._signals(now, snapshot.time)
            moved = not self._q or np.abs(snapshot.q - self._q[-1]).max() > 1e-5
            if (moved or view.moving) and not passing_over:
                self._times.append(now)
                self._q.append(snapshot.q.copy())
                self._qd.append(snapshot.qd.copy())
                self._positions.append(snapshot.positions.copy())
        self._clock.tick()

    def _follow(self, now: float) -> None:
        # By the simulation's thread, and at the end by the program's: both may find an end at once.
        assert self._simulator is not None
        for number, record in tuple(self._open.items()):
            task = self._simulator.task(number)
            if task is None:
                self._open.pop(number, None)
                continue
            if record.started < 0.0 and task.state is not TaskState.IDLE:
                record.started = now
            if task.state.ended:
                record.ended = now
                record.state, record.message = task.state.name, task.message
                if task.state is TaskState.ERROR:
                    record.meanwhile = lines.of_main_thread()
                self._open.pop(number, None)
                self.progress = now
                if not record.of_vendor:
                    self._await_poll(number)

    def _await_poll(self, number: int) -> None:
        """Let time be the wall clock's until the end of a task has been polled."""
        due = time.monotonic() + _POLLED
        self._unpolled.add(number)
        self._clock.stream_begins(lambda: number not in self._unpolled or time.monotonic() > due)

    def _touch(self, touched: str, now: float, sample: int, *, meant: bool) -> None:
        pairs = frozenset(touched.split(", ")) if touched else frozenset()
        if self._at_first is None:
            self._at_first = pairs  # such as the base on its floor, things on a table
        if not pairs and not self._touching:
            return
        pairs -= self._at_first
        for pair in self._touching.keys() - pairs:
            self._touching.pop(pair)["end"] = now
        for pair in pairs - self._touching.keys():
            one, touches, other = pair.partition(" touches ")
            if not touches or not _of_arm(one):  # contacts of a gripped thing are intended
                continue
            contact = {
                "pair": [one, other], "time": now, "end": now, "sample": sample,
                "meant": meant,
            }  # fmt: skip
            self.contacts.append(contact)
            self._touching[pair] = contact

    def _signals(self, now: float, at: float) -> None:
        assert self._simulator is not None
        signals = self._simulator.signals
        banks = {"output": signals.standard_out.levels(at), "input": signals.standard_in.all()}
        for name, levels in banks.items():
            for number, level in enumerate(levels, 1):
                key = f"{name} {number}"
                if level is not self._levels.get(key, False):
                    self._levels[key] = level
                    self.io.append({"time": now, "signal": key, "value": level})

    def finish(self) -> None:
        """Record the changes of tasks since the last cycle."""
        if self._simulator is not None and self._open:
            self._follow(self._clock.passed)

    # -- at the end ---------------------------------------------------------------------------

    def as_json(self) -> dict[str, Any]:
        """All data except the arrays, as values for JSON."""
        with self._lock:
            calls = [
                {
                    **{key: value for key, value in vars(call).items() if key not in _NOT_REPORTED},
                    "where": _where(call.where),
                    "meanwhile": _where(call.meanwhile),
                    "result": call.result if isinstance(call.result, int | float | str) else None,
                }
                for call in self.calls
            ]
            notes = [{**note, "where": _where(note["where"])} for note in self.notes]
        return {"calls": calls, "notes": notes, "contacts": self.contacts, "io": self.io}

    def arrays(self) -> dict[str, Any]:
        """Samples of the moving arm: times, joints, joint speeds, all positions."""
        widest = max((each.size for each in self._positions), default=0)
        same = [each for each in self._positions if each.size == widest]
        return {
            "time": np.array(self._times),
            "q": np.reshape(self._q, (-1, 6)),
            "qd": np.reshape(self._qd, (-1, 6)),
            "positions": np.reshape(same, (len(same), widest)),  # (0, 0) if the arm never moved
        }


def _of_arm(name: str) -> bool:
    return name.startswith(("link", "base", "the flange", "the tool"))


def _where(line: ProgramLine | None) -> dict[str, Any] | None:
    return None if line is None else line._asdict()


def _text(name: str, args: tuple[Any, ...]) -> str:
    text = ", ".join(_value(value) for value in args[:4])
    return f"{name}({text if len(text) <= _LONGEST else text[: _LONGEST - 1] + '…'})"


def _value(value: Any) -> str:
    if isinstance(value, list | tuple):
        return f"[{', '.join(_value(each) for each in value)}]"
    return f"{value:.4g}" if isinstance(value, float) else repr(value)


def _radius(name: str, args: tuple[Any, ...]) -> float:
    """The blend radius among a call's arguments; a spiral's is that of its end."""
    if name == "move_spiral":
        return 0.0
    parameters = functions()[name].parameters
    index = next((i for i, each in enumerate(parameters) if each in ("r", "rad")), len(args))
    return float(args[index]) if index < len(args) else 0.0
