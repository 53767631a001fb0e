"""Keys of a terminal, as they are pressed."""

from __future__ import annotations

import enum
import os
import re
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

import anyio

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["Key", "keys_of", "single_keys", "wait_for_keys"]

#: seconds between two looks at a console that cannot be waited for
_LOOK: Final = 0.05


class Key(enum.Enum):
    """What a key asks for."""

    STOP = "stop"
    PAUSE = "pause"
    RESUME = "resume"
    QUIT = "quit"


_KEYS: Final = {" ": Key.STOP, "s": Key.STOP, "p": Key.PAUSE, "r": Key.RESUME, "q": Key.QUIT}
#: what terminals send for arrows, function keys and the like: none of its letters is a key
_SEQUENCE: Final = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]?|O.?|.?)", re.DOTALL)


def keys_of(data: bytes) -> list[Key]:
    """What was asked for by what a terminal sent. Other keys mean nothing."""
    text = _SEQUENCE.sub("", data.decode(errors="replace"))
    return [_KEYS[letter] for letter in text.lower() if letter in _KEYS]


@contextmanager
def single_keys(terminal: int) -> Iterator[None]:
    """Have a terminal give each key at once, and not show it; Ctrl-C stays what it is.

    Args:
        terminal: its descriptor.
    """
    try:
        import termios  # noqa: PLC0415 - where there is one
        import tty  # noqa: PLC0415
    except ImportError:
        yield  # a console of Windows gives each key at once by itself
        return
    before = termios.tcgetattr(terminal)
    tty.setcbreak(terminal, termios.TCSANOW)
    try:
        yield
    finally:
        termios.tcsetattr(terminal, termios.TCSANOW, before)


async def wait_for_keys(terminal: int) -> list[Key]:
    """Wait for keys; what was asked for by them. A terminal that is gone asks to quit."""
    try:
        import msvcrt  # noqa: PLC0415 - Windows has it, and its console cannot be waited for
    except ImportError:
        await anyio.wait_readable(terminal)
        data = os.read(terminal, 1024)
        return keys_of(data) if data else [Key.QUIT]
    console: Any = msvcrt
    while not console.kbhit():  # noqa: ASYNC110 - nothing else tells of a key
        await anyio.sleep(_LOOK)
    letter = console.getwch()
    if letter in "\0\xe0":  # of an arrow or a function key: what follows is no letter
        console.getwch()
        return []
    return keys_of(letter.encode())
