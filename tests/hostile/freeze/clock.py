"""The clock of a suspended computer: compiles `clock.c`, and sets how long it stands still."""

from __future__ import annotations

import mmap
import os
import shutil
import struct
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Self

_SOURCE = Path(__file__).with_name("clock.c")
_TIME = struct.Struct("=q")


def now() -> float:
    """The time that goes on while a computer is suspended, the same for all its processes [s]."""
    return time.clock_gettime(time.CLOCK_BOOTTIME)


def why_not() -> str:
    """Why there is no such clock here; empty if there is."""
    return "" if shutil.which("cc") else "there is no C compiler, cc"


def compiled(folder: Path) -> Path:
    """Compile the library that programs load."""
    library = folder / "clock.so"
    command = ["cc", "-shared", "-fPIC", "-O2", "-Wall", "-o", str(library), str(_SOURCE), "-ldl"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"the clock was not compiled: {done.stderr}")
    return library


class StandingClock:
    """The clock of one program and its children."""

    def __init__(self, library: Path) -> None:
        descriptor, name = tempfile.mkstemp(prefix="freeze-clock-")
        os.write(descriptor, _TIME.pack(0))
        self._page = mmap.mmap(descriptor, _TIME.size)
        os.close(descriptor)
        self._file = Path(name)
        self.environment = {"LD_PRELOAD": str(library), "FREEZE_CLOCK": name}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._page.close()
        self._file.unlink()

    def stand(self, seconds: float) -> None:
        """Take a time off the clock; none of the program's processes may run meanwhile [s]."""
        (before,) = _TIME.unpack(self._page[:])
        self._page[:] = _TIME.pack(before + round(seconds * 1e9))
