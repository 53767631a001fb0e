"""One run: a program, a controller, and an outage of the network between them."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Iterator
from contextlib import AsyncExitStack
from dataclasses import dataclass, field

import anyio
import anyio.to_thread

from . import network as networks
from .child import Child, child
from .judge import begun_after, first_told
from .lines import Line
from .network import CONTROLLER, Network, network
from .proxy import RULES

KINDS = (*networks.KINDS, *RULES)
SCENES = ("sent", "running", "stream")
#: s. The kernel repeats what is not acknowledged after 0.2, 0.6, 1.4, 3.1 and 6.5 s, more or less:
#: at 3.2 s, a motion comes a little before or after the stop; at 3.5 s, three seconds after it.
OUTAGES = (0.5, 2.0, 3.2, 3.5, 5.0, 8.0, 12.0, 30.0)

#: how often a run is begun anew whose outage did not come to begin
_ATTEMPTS = 3
#: until a process of a run has begun [s]
_START = 90.0
#: for which a program may take, and its guard after it, before the run is given up [s]
_PROGRAM, _GUARD = 150.0, 60.0
#: for which the arm is watched at the end: the kernel repeats what nobody acknowledged after 0.2,
#: 0.4, 0.8, 1.6 and 3.2 s, then after 6.4 s, but gives up after 8 s [s]
_WATCH = 6.0
#: the same after the last byte that a proxy kept [s]
_WATCH_KEPT = 3.0
#: for which the arm has been moving when the network fails [s]
_MIDST = 0.5
#: for which a stream goes on after the outage, if it goes on [s]
_STREAM = 3.0


@dataclass(frozen=True, slots=True)
class Cell:
    """What is tried."""

    kind: str
    outage: float
    scene: str
    heartbeat: float | None = 1.0
    guard: bool = False

    def __str__(self) -> str:
        beat = "no heartbeat" if self.heartbeat is None else f"heartbeat {self.heartbeat:g}"
        guard = "guard" if self.guard else "no guard"
        return f"{self.kind} {self.outage:g} s, {self.scene}, {beat}, {guard}"


def cells() -> Iterator[Cell]:
    """All that is tried. What is running is nothing that a late reader has not read yet."""
    for outage, kind, scene in itertools.product(OUTAGES, KINDS, SCENES):
        if (kind, scene) != ("late", "running"):
            for heartbeat, guard in itertools.product((1.0, None), (False, True)):
                yield Cell(kind, outage, scene, heartbeat, guard)


@dataclass
class Result:
    """What came of it.

    Attributes:
        cell: what was tried.
        trouble: why nothing can be said about it; empty if something can.
        begun: the times at which the arm began to move although the program knew that it rests.
        told: when the program knew [s].
        lines: all that was said, by whom.
    """

    cell: Cell
    trouble: str = ""
    begun: list[Line] = field(default_factory=list)
    told: float = math.nan
    lines: list[tuple[str, Line]] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether the arm stood when it was said to."""
        return not self.trouble and not self.begun

    @property
    def begin(self) -> float:
        """When the outage began [s]."""
        return next((line.at for _, line in self.lines if line.what == "outage"), math.nan)

    @property
    def what(self) -> str:
        """What the program was told first."""
        told = (line.text for who, line in self.lines if who == "program" and line.what == "told")
        return next(told, "nothing")

    def __str__(self) -> str:
        """One line: times in seconds since the outage began, in the order of events."""
        verdict = "passed" if self.passed else "FAILED"
        why = f" ({self.trouble.strip()})" if self.trouble else ""
        hidden = {"port", "mark", "pending", "ready"}
        events = [
            f"{line.at - self.begin:+.2f} {_short(who, line)}"
            for who, line in sorted(self.lines, key=lambda said: said[1].at)
            if line.what not in hidden and (who != "controller" or line.at > self.begin - 2.0)
            if line.what != "delivered" or "motion" in line.text
        ]
        count = f"; began {len(self.begun)} times after it was told" if self.begun else ""
        return f"{verdict}: {self.cell}{why}{count}: {'; '.join(events)}"


def _short(who: str, line: Line) -> str:
    if line.what == "told":
        name, _, message = line.text.partition(": ")
        return f"told {name}" + (f" ({message[:60]})" if message else "")
    if line.what == "begin":
        return "ARM BEGINS"
    if line.what == "rest":
        return "arm rests"
    words = f"{line.what} {line.text}".strip()
    return words if who in ("controller", "run", "proxy") else f"{who} {words}"


async def trial(cell: Cell) -> Result:
    """Try it. What goes wrong with the run itself is part of the result.

    On a machine so busy that a program or its heartbeat fails before the network does, or that a
    stream has come to its end by then, it is tried again.
    """
    for _ in range(_ATTEMPTS):
        result = await _once(cell)
        if not math.isnan(result.begin) and not result.told < result.begin:
            break
    return result


async def _once(cell: Cell) -> Result:
    result = Result(cell)
    try:
        async with AsyncExitStack() as stack:
            made = stack.enter_context(network())
            await _Trial(cell, result, made, stack).run()
    except Exception as exc:
        result.trouble = f"{type(exc).__name__}: {exc}"
        if isinstance(exc, ExceptionGroup):
            result.trouble += f": {exc.exceptions}"
    return result


async def _sleep_until(at: float) -> None:
    await anyio.sleep_until(anyio.current_time() + at - time.monotonic())


class _Trial:
    def __init__(self, cell: Cell, result: Result, net: Network, stack: AsyncExitStack) -> None:
        self._cell = cell
        self._result = result
        self._network = net
        self._stack = stack
        self._proxy: Child | None = None

    async def run(self) -> None:
        cell = self._cell
        controller = await self._start(self._network.controller, "controller")
        port = (await controller.says("port", _START)).text
        if cell.kind in RULES:
            self._proxy = await self._start(self._network.controller, "proxy", CONTROLLER, port)
            port = (await self._proxy.says("port", _START)).text
        guard = "process" if cell.guard else ""
        options = (CONTROLLER, port, cell.scene, str(cell.heartbeat or 0), guard)
        program = await self._start(
            self._network.program, "program", *options, str(cell.outage + _STREAM)
        )
        try:
            await program.says("ready", _START)
            if cell.scene != "sent":
                begin = await controller.says("begin", _START)
                await _sleep_until(begin.at + _MIDST)
            began = await self._fail(program)
            async with anyio.create_task_group() as group:
                group.start_soon(self._ended, program)
                await self._restore(began)
            until = time.monotonic() + _WATCH
            if self._proxy is not None:
                until = max(await self._last_kept(self._proxy), until - _WATCH) + _WATCH_KEPT
            await _sleep_until(until)
            await self._asked(controller, "mark")
        finally:
            self._collect(controller, program)

    async def _start(self, namespace: str, module: str, *options: str) -> Child:
        return await self._stack.enter_async_context(child(namespace, module, *options))

    async def _fail(self, program: Child) -> float:
        """Begin the outage; when that was [s]."""
        kind = self._cell.kind
        if self._proxy is not None:
            seen = len(self._proxy.lines)
            await self._proxy.write(f"{kind} {self._cell.outage}")
            began = (await self._proxy.says("begun", _START, seen)).at
        else:
            await anyio.to_thread.run_sync(self._network.interrupt, kind)
            began = time.monotonic()
        self._note("outage", began, kind)
        await program.write("go")
        return began

    async def _restore(self, began: float) -> None:
        """End the outage when it is time."""
        await _sleep_until(began + self._cell.outage)
        if self._proxy is None:
            await anyio.to_thread.run_sync(self._network.restore, self._cell.kind)
        self._note("outage over", time.monotonic())

    async def _ended(self, program: Child) -> None:
        """Wait until the program has ended, and nothing of it is left, its guard neither."""
        if not await program.ends(_PROGRAM):
            self._result.trouble = f"the program had not ended after {_PROGRAM:g} s"
            return
        with anyio.move_on_after(_GUARD):
            # nothing tells when processes end that others started
            while await anyio.to_thread.run_sync(self._network.pids):  # noqa: ASYNC110
                await anyio.sleep(0.25)
            self._note("guard's end" if self._cell.guard else "nothing left", time.monotonic())
            return
        self._result.trouble = f"its processes had not ended {_GUARD:g} s after the program"

    async def _last_kept(self, proxy: Child) -> float:
        """Wait until the proxy has delivered all that the program sent; when that was [s]."""
        # more may come while what is pending is delivered
        while due := (await self._asked(proxy, "pending")).text:
            await _sleep_until(float(due) + 0.05)
        return max([line.at for line in proxy.lines if line.what == "delivered"], default=0.0)

    async def _asked(self, whom: Child, what: str) -> Line:
        seen = len(whom.lines)
        await whom.write(what)
        return await whom.says(what, _START, seen)

    def _note(self, what: str, at: float, text: str = "") -> None:
        self._result.lines.append(("run", Line(at, what, text)))

    def _collect(self, controller: Child, program: Child) -> None:
        result = self._result
        if program.status is not None:
            status = str(program.status)
            result.lines.append(("program", Line(program.ended, "ended", status)))
        for who in (controller, program, self._proxy):
            if who is not None:
                result.lines += ((who.name, line) for line in who.lines)
        result.told = first_told(program.lines, program.ended)
        result.begun = begun_after(controller.lines, result.told)
