"""Programs that are frozen into one file or folder, by PyInstaller for instance."""

from __future__ import annotations

import os
import sys
import traceback
from typing import TYPE_CHECKING, Final

from aioduco._process.spawn import MARK, children, is_frozen

if TYPE_CHECKING:
    from collections.abc import Callable


def freeze_support() -> None:
    """Let a frozen program start the processes of this package, such as the guard.

        if __name__ == "__main__":
            aioduco.freeze_support()
            main()

    Call it before anything else in the program. The executable of a frozen program is the program
    itself: to have a guard, it starts itself once more. In that process, this function runs the
    guard, a stream's worker, a planner, a simulator, a twin, the process that draws pictures or the
    relay of a tap, and does not return. In the program itself, and in a program that is not frozen,
    it returns at once. A frozen program that does not call it cannot start any of these processes.
    """
    if not is_frozen():
        return
    children.freeze_support_called = True
    if sys.argv[1:2] != [MARK]:
        return
    code = 1
    try:
        code = _run(sys.argv[2], sys.argv[3:])
    except BaseException:
        traceback.print_exc()
    finally:
        # Not by an exception, which the program could catch: no code of the program may run here.
        if sys.stderr is not None:  # a program without a console has none
            sys.stderr.flush()
        os._exit(code)


def _run(module: str, arguments: list[str]) -> int:
    main = _MAINS[module]()
    return main(arguments)


# Each is imported only in its own process: a program does not need the extras of the others. The
# imports are written out, so that a tool that freezes programs finds them.


def _guard() -> Callable[[list[str]], int]:
    from aioduco.supervision.guard.process import main  # noqa: PLC0415

    return main


def _stream() -> Callable[[list[str]], int]:
    from aioduco.streaming.worker.main import main  # noqa: PLC0415

    return main


def _planner() -> Callable[[list[str]], int]:
    from aioduco.planning.worker import main  # noqa: PLC0415

    return main


def _simulator() -> Callable[[list[str]], int]:
    from aioduco.sim.spawned import main  # noqa: PLC0415

    return main


def _twin() -> Callable[[list[str]], int]:
    from aioduco.sim.twin.worker import main  # noqa: PLC0415

    return main


def _pictures() -> Callable[[list[str]], int]:
    from aioduco.sim.view.drawing import main  # noqa: PLC0415

    return main


def _tap() -> Callable[[list[str]], int]:
    from aioduco.recording.tap.relay import main  # noqa: PLC0415

    return main


_MAINS: Final[dict[str, Callable[[], Callable[[list[str]], int]]]] = {
    "aioduco.supervision.guard.process": _guard,
    "aioduco.streaming.worker.main": _stream,
    "aioduco.planning.worker": _planner,
    "aioduco.sim.spawned": _simulator,
    "aioduco.sim.twin.worker": _twin,
    "aioduco.sim.view.drawing": _pictures,
    "aioduco.recording.tap.relay": _tap,
}
