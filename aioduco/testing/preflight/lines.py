"""Find the program line that made a call: the innermost frame of the program itself."""

from __future__ import annotations

import asyncio
import contextlib
import contextvars
import sys
import threading
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from aioduco._process.program_lines import PACKAGE, of_program

if TYPE_CHECKING:
    from collections.abc import Iterable
    from types import CodeType, FrameType

__all__ = [
    "TASK_ORIGIN",
    "CallOrigin",
    "ProgramLine",
    "awaited",
    "current",
    "innermost",
    "is_program",
    "of_error",
    "of_main_thread",
]

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
    """Origin of a call: the line, and an id of the task or thread that ran it."""

    where: ProgramLine
    actor: int


#: origin of the line that started the running task, for tasks without a frame of the program
TASK_ORIGIN: contextvars.ContextVar[CallOrigin | None] = contextvars.ContextVar(
    "preflight_origin", default=None
)


@cache
def is_program(file: str) -> bool:
    """Whether a file belongs to the program; commands of this package may be the program."""
    return of_program(file) or Path(file).resolve().is_relative_to(_PROGRAMS)


def current() -> CallOrigin | None:
    """The origin of the code that runs now on this thread; None if it is not the program's."""
    frame: FrameType | None = sys._getframe(1)
    while frame is not None:
        if is_program(frame.f_code.co_filename):
            line = _line(frame.f_code, frame.f_lineno)
            return CallOrigin(line._replace(caller=_caller(frame)), _actor())
        if frame.f_code is _RUN_ONCE:
            break  # the frames below belong to the code that runs the loop
        frame = frame.f_back
    return TASK_ORIGIN.get()


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


def _actor() -> int:
    with contextlib.suppress(RuntimeError):
        if (task := asyncio.current_task()) is not None:
            return id(task)
    return threading.get_ident()


_LOOP: Any = asyncio.BaseEventLoop
_RUN_ONCE = _LOOP._run_once.__code__
