"""Keys of a terminal, as they are pressed."""

from __future__ import annotations

import enum
import os
import re
from typing import Any, Final

import anyio

#: seconds between two polls of a console that cannot be waited for
_LOOK: Final = 0.05


class Key(enum.Enum):
    """Command of a key."""

    STOP = "stop"
    PAUSE = "pause"
    RESUME = "resume"
    QUIT = "quit"


_KEYS: Final = {" ": Key.STOP, "s": Key.STOP, "p": Key.PAUSE, "r": Key.RESUME, "q": Key.QUIT}
#: sequences that terminals send for arrows, function keys and the like; no letter in them is a key
_SEQUENCE: Final = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]?|O.?|.?)", re.DOTALL)


def keys_of(data: bytes) -> list[Key]:
    """The commands in the bytes from a terminal. Other keys are ignored."""
    text = _SEQUENCE.sub("", data.decode(errors="replace"))
    return [_KEYS[letter] for letter in text.lower() if letter in _KEYS]


async def wait_for_keys(terminal: int) -> list[Key] | None:
    """Wait for keys, and return their commands; None if the terminal was closed."""
    try:
        import msvcrt  # noqa: PLC0415 - Windows has it, and its console cannot be waited for
    except ImportError:
        await anyio.wait_readable(terminal)
        try:
            data = os.read(terminal, 1024)
        except OSError:
            return None
        return keys_of(data) if data else None
    console: Any = msvcrt
    while not console.kbhit():  # noqa: ASYNC110 - nothing else tells of a key
        await anyio.sleep(_LOOK)
    letter = console.getwch()
    if letter in "\0\xe0":  # prefix of an arrow or a function key: the next code is no letter
        console.getwch()
        return []
    return keys_of(letter.encode())
