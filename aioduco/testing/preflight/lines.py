"""Find the program line that made a call: the innermost frame of the program itself."""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import contextvars
import sys
import threading
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from aioduco._process.program_lines import PACKAGE, of_program
from aioduco.testing.preflight.handlers import WaitingLine

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from types import CodeType, FrameType


_PROGRAMS = PACKAGE / "cli"


class ProgramLine(NamedTuple):
    """A line of the program.

    Attributes:
        file: path of the file.
        line: number of the line, from 1.
        function: name of the function.
        caller: file and line from which the program called that function; empty if it is unknown,
            or if the function is a task of its own.
    """

    file: str
    line: int
    function: str
    caller: str = ""

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"


class CallOrigin(NamedTuple):
    """Origin of a call.

    Attributes:
        where: the line.
        actor: an id of the task or thread that ran it.
        waiting: all lines that wait for the call, the innermost first.
    """

    where: ProgramLine
    actor: int
    waiting: tuple[WaitingLine, ...] = ()


#: origin of the line that started the running task, for tasks without a frame of the program
TASK_ORIGIN: contextvars.ContextVar[CallOrigin | None] = contextvars.ContextVar(
    "preflight_origin", default=None
)


#: whether the program gets the error of a call by another line, which waits for the task
_LATER: contextvars.ContextVar[bool] = contextvars.ContextVar("preflight_later", default=False)


@contextlib.contextmanager
def later() -> Iterator[None]:
    """A block whose errors the program gets by another line, which waits for the task."""
    token = _LATER.set(True)
    try:
        yield
    finally:
        _LATER.reset(token)


#: libraries that pass an error on as it is
_PASSING = ("anyio", "sniffio")


@cache
def is_program(file: str) -> bool:
    """Whether a file belongs to the program; commands of this package may be the program."""
    return of_program(file) or Path(file).resolve().is_relative_to(_PROGRAMS)


@cache
def _is_library(file: str) -> bool:
    """Whether a file belongs to an installed library that may handle errors of its own."""
    parts = Path(file).parts
    installed = {"site-packages", "dist-packages"} & set(parts)
    return bool(installed) and not any(each in parts for each in (*_PASSING, PACKAGE.name))


def current() -> CallOrigin | None:
    """The origin of the code that runs now on this thread; None if it is not the program's."""
    frame: FrameType | None = sys._getframe(1)
    where: ProgramLine | None = None
    begun, others = TASK_ORIGIN.get(), _LATER.get()
    waiting: list[tuple[str, int, dict[str, Any], bool]] = []
    while frame is not None:
        code = frame.f_code
        program = is_program(code.co_filename)
        if code is _RUN_ONCE:
            if where is None:
                return begun  # the frames below belong to the code that runs the loop
        elif code.co_filename.startswith(_POOLS):
            others = True  # the error comes to the line that asks the pool for the result
        if program and where is None:
            where = _line(code, frame.f_lineno)._replace(caller=_caller(frame))
        if program or _is_library(code.co_filename):
            waiting.append((code.co_filename, frame.f_lineno, frame.f_globals, not program))
        frame = frame.f_back
    if where is None:
        return begun
    lines = [WaitingLine(*each, later=others) for each in waiting]
    if begun is not None:
        lines += begun.waiting
    return CallOrigin(where, _actor(), tuple(lines))


def _caller(frame: FrameType) -> str:
    """File and line of the program from which it called the function of a frame."""
    above: FrameType | None = frame.f_back
    while above is not None and not _of_asyncio(above.f_code):
        if is_program(above.f_code.co_filename):
            return str(_line(above.f_code, above.f_lineno))
        above = above.f_back
    return ""


def _of_asyncio(code: CodeType) -> bool:
    """Whether it is asyncio's: what is called through that is a task, or begins the program."""
    return Path(code.co_filename).parent.name == "asyncio"


def of_error(error: BaseException) -> ProgramLine | None:
    """The innermost line of the program in an error's traceback."""
    found, caller, traceback = None, "", error.__traceback__
    while traceback is not None:
        code = traceback.tb_frame.f_code
        if is_program(code.co_filename):
            found = _line(code, traceback.tb_lineno)._replace(caller=caller)
            caller = str(found)
        elif _of_asyncio(code):
            caller = ""
        traceback = traceback.tb_next
    return found


def innermost(origin: Iterable[tuple[str, int, str]]) -> ProgramLine | None:
    """The first line of the program among frames, innermost first."""
    return next((ProgramLine(*each) for each in origin if is_program(each[0])), None)


def awaited(coroutine: Any) -> ProgramLine | None:
    """The innermost line of the program in a chain of coroutines that await each other."""
    found = None
    while coroutine is not None:
        frame = getattr(coroutine, "cr_frame", None) or getattr(coroutine, "gi_frame", None)
        if frame is not None and is_program(frame.f_code.co_filename):
            found = _line(frame.f_code, frame.f_lineno)
        coroutine = getattr(coroutine, "cr_await", None) or getattr(coroutine, "gi_yieldfrom", None)
    return found


def of_main_thread() -> ProgramLine | None:
    """The program line that the main thread runs now; None if it runs none."""
    frame = sys._current_frames().get(threading.main_thread().ident or 0)
    while frame is not None and not is_program(frame.f_code.co_filename):
        frame = frame.f_back
    return None if frame is None else _line(frame.f_code, frame.f_lineno)


def _line(code: CodeType, number: int) -> ProgramLine:
    return ProgramLine(code.co_filename, number, code.co_name)


def of_new_task(*, by_program: bool) -> CallOrigin | None:
    """The origin of an asyncio task that is being created; None if it is not the program's.

    Args:
        by_program: whether the program creates it. Then another line may wait for it, unless it is
            the main task of a loop.
    """
    origin = current()
    if origin is None or not by_program or _runs_loop():
        return origin
    return origin._replace(waiting=tuple(each._replace(later=True) for each in origin.waiting))


def _runs_loop() -> bool:
    """Whether the running code starts an event loop, which raises the error of its main task."""
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and not is_program(frame.f_code.co_filename):
        if frame.f_code in (_RUN_UNTIL_COMPLETE, _RUN):
            return True
        frame = frame.f_back
    return False


def _actor() -> int:
    with contextlib.suppress(RuntimeError):
        if (task := asyncio.current_task()) is not None:
            return id(task)
    return threading.get_ident()


_POOLS = str(Path(concurrent.futures.__file__).parent)
_LOOP: Any = asyncio.BaseEventLoop
_RUN_ONCE = _LOOP._run_once.__code__
_RUN_UNTIL_COMPLETE = _LOOP.run_until_complete.__code__
_RUN = asyncio.Runner.run.__code__
