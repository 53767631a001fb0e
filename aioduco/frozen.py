"""Programs that are frozen into one file or folder, by PyInstaller for instance."""

from __future__ import annotations

import os
import sys
import traceback
from typing import TYPE_CHECKING

from aioduco._spawn import MARK, children, is_frozen

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["freeze_support"]


def freeze_support() -> None:
    """Let a frozen program have a guard, and streams with processes of their own.

        if __name__ == "__main__":
            aioduco.freeze_support()
            main()

    Call it as the first thing that the program does. The executable of a frozen program is the
    program: to have a guard, it starts itself once more. There this function runs the guard, or
    the lane of a stream, and does not return. In the program, and in one that is not frozen, it
    returns at once. Without it, a frozen program is refused the guard and lanes in processes.
    """
    if not is_frozen():
        return
    children.told_apart = True
    if sys.argv[1:2] != [MARK]:
        return
    code = 1
    try:
        code = _run(sys.argv[2], sys.argv[3:])
    except BaseException:
        traceback.print_exc()
    finally:
        # Not by an exception, which the program may catch: nothing of it is to run here.
        sys.stderr.flush()
        os._exit(code)


def _run(module: str, arguments: list[str]) -> int:
    # Only here, since other programs need neither; written out, so that whoever freezes finds them.
    from aioduco.streaming.worker import main as worker  # noqa: PLC0415
    from aioduco.supervision.guard import process  # noqa: PLC0415

    mains: dict[str, Callable[[list[str]], int]] = {
        worker.__name__: worker.main,
        process.__name__: process.main,
    }
    return mains[module](arguments)
