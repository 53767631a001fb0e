"""The process in which the program runs; only `aioduco.testing.preflight.runner` starts it.

So a program on a real arm cannot run like this by accident. The process gets its options over its
channel, and ends when the channel closes.
"""

from __future__ import annotations

import asyncio
import contextlib
import faulthandler
import gc
import json
import os
import runpy
import signal
import sys
import threading
from dataclasses import asdict
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from aioduco._process import trial
from aioduco._process.linked_process import ValueChannel
from aioduco.models.whole_files import write_whole
from aioduco.sim import trial as controller_trial
from aioduco.sim.simulator import Simulator
from aioduco.testing.preflight import lines, patches
from aioduco.testing.preflight.borders import block_outside_access
from aioduco.testing.preflight.program_clock import ProgramClock
from aioduco.testing.preflight.run_recorder import RunRecorder
from aioduco.testing.preflight.tried_controller import ProgramSimulator, TriedController
from aioduco.testing.preflight.tried_program import TriedProgram
from aioduco.testing.preflight.variation import Variation

#: time between two checks of the program's progress, by the wall clock [s]
_LOOK = 0.05
#: least time without a change before a program counts as hung, by the wall clock [s]: while a
#: program waits for a computing thread, its own time runs as fast as this computer can simulate
_AT_LEAST = 3.0


class _Child:
    """One run of the program.

    Args:
        options: the program, its cell and its settings.
    """

    def __init__(self, options: dict[str, Any]) -> None:
        self.options = options
        self.clock = ProgramClock()
        self.recorder = RunRecorder(self.clock)
        self.variation = Variation.of(options.get("vary", ()), options.get("seed", 0))
        self._cell = ProgramSimulator(self._make, self._attached)
        self._controller = TriedController(
            self.clock, self.recorder, self._cell, self.variation, options["cycle"]
        )
        self._over = threading.Event()
        self._written = threading.Lock()

    def run(self) -> NoReturn:
        """Run the program to its end, write the result, and end this process."""
        self.clock.start()
        patches.install(self.clock, self.recorder)
        trial.current = TriedProgram(self.clock, self.recorder, self._cell)
        controller_trial.current = self._controller
        block_outside_access(
            self.options["reachable"],
            self._cell.ports,
            patches.asked_by_package,
            self.recorder.not_reached,
        )
        threading.excepthook = self._thread_failed
        self._note_lost_errors()
        threading.Thread(target=self._watch, name="preflight-watch", daemon=True).start()
        status = self._program()
        for thread in threading.enumerate():
            ours = thread.daemon or thread.name.startswith("aioduco")
            if not ours and thread is not threading.current_thread():
                with self.clock.waiting():
                    thread.join()
        gc.collect()
        self._over.set()
        with contextlib.suppress(RuntimeError):  # the simulator is closed
            self.recorder.finish()
        self._write(status)
        _end()

    def _program(self) -> int:
        program, arguments = self.options["program"], self.options["arguments"]
        if self.options["cwd"] is not None:
            os.chdir(self.options["cwd"])
        sys.argv = [program, *arguments]
        try:
            if self.options["vendor"]:
                from aioduco.compat._runner import run  # noqa: PLC0415

                run(program, arguments, module=self.options["module"])
            elif self.options["module"]:
                sys.path.insert(0, str(Path.cwd()))
                runpy.run_module(program, run_name="__main__", alter_sys=True)
            else:
                sys.path.insert(0, str(Path(program).resolve().parent))
                runpy.run_path(program, run_name="__main__")
        except SystemExit as exc:
            code = exc.code if isinstance(exc.code, int) else int(exc.code is not None)
            if code:
                self.recorder.failed(exc)
            return code
        except BaseException as exc:
            self.recorder.failed(exc)
            sys.excepthook(type(exc), exc, exc.__traceback__)
            return 1
        return 0

    def _thread_failed(self, failure: threading.ExceptHookArgs) -> None:
        """Note the error by which a thread of the program ended."""
        if failure.exc_value is not None and failure.exc_type is not SystemExit:
            self.recorder.failed(failure.exc_value)
        threading.__excepthook__(failure)

    def _note_lost_errors(self) -> None:
        """Note an error of a task that nobody awaits, or of a callback, which asyncio only logs."""
        loops: Any = asyncio.BaseEventLoop
        log = loops.default_exception_handler

        def note(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
            if (error := context.get("exception")) is not None:
                self.recorder.failed(error)
            log(loop, context)

        loops.default_exception_handler = note

    # -- the simulator ------------------------------------------------------------------------

    def _make(self) -> Simulator:
        keys = ("model", "scene", "tool", "gripper", "mounting", "pedestal", "joints")
        given = {key: self.options[key] for key in keys if self.options.get(key) is not None}
        return Simulator(**given).start()

    def _attached(self, simulator: Simulator) -> None:
        self.clock.attach(simulator)
        self.recorder.attach(simulator)
        self.variation.apply(simulator)

    # -- while it runs ------------------------------------------------------------------------

    def _watch(self) -> None:
        """Check the program's progress, and end the program if it hangs."""
        patience = self.options["patience"]
        looks, last = 0, -1.0
        while not self._over.wait(_LOOK):
            progress = self.recorder.progress
            # what it waits for on purpose is no endless wait, and its patience begins afterwards
            since = max(progress, self.clock.slept_until(progress + 0.1 * patience))
            looks, last = (0 if since != last else looks + 1), since
            waited = self.clock.passed - since
            if not self._cell.simulator or waited < patience or looks * _LOOK < _AT_LEAST:
                continue
            for where, text in self._waits():
                self.recorder.hung(where, f"{text}: for {patience:g} s nothing moved or changed")
            self._write(1)
            _end()

    def _waits(self) -> list[tuple[lines.ProgramLine | None, str]]:
        """The lines at which the program waits: of its tasks, or of its main thread."""
        tasks = (task for loop in list(patches.loops) for task in asyncio.all_tasks(loop))
        waiting = (lines.awaited(task.get_coro()) for task in tasks)
        found = [(where, f"waits in {where.function}") for where in waiting if where is not None]
        if found:
            return list(found)
        where = lines.of_main_thread()
        return [(where, f"waits in {where.function}" if where else "the program waits")]

    def _write(self, status: int) -> None:
        with self._written:
            folder = Path(self.options["folder"])
            result = {
                **self.recorder.as_json(), "status": status, "duration": self.clock.passed,
                "used": self._controller.cell, "touched": self._cell.simulator is not None,
                "variation": asdict(self.variation),
            }  # fmt: skip
            np.savez(folder / "samples.npz", **self.recorder.arrays())
            # whole: the half of it, as on a full disk, would be taken for the result
            write_whole(folder / "run.json", json.dumps(result, default=str))


def _end() -> NoReturn:
    """End the process at once: threads of the simulator and the program may wait for ever."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):
            stream.flush()
    os._exit(0)


def _end_with(channel: ValueChannel) -> None:
    """End this process when the process that started it has ended."""
    with contextlib.suppress(EOFError, OSError):
        channel.receive()
    os._exit(1)


def main(arguments: list[str]) -> NoReturn:
    """Run the program that the options name."""
    sys.setswitchinterval(0.0005)
    channel = ValueChannel.of(arguments)
    options = channel.receive()
    end = threading.Thread(target=_end_with, args=(channel,), name="preflight-end", daemon=True)
    end.start()
    with (Path(options["folder"]) / "stacks").open("w") as stacks:
        if hasattr(signal, "SIGUSR1"):  # sent after the time-out
            faulthandler.register(signal.SIGUSR1, stacks)
        _Child(options).run()
