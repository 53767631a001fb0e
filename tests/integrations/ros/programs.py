"""Programs of a ROS graph: each in a process that ends with the test."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import contextlib

__all__ = ["HERE", "ROOT", "START", "Programs", "processor_time"]

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
START = [0.0, 0.3, 1.2, 0.1, -1.5, 0.0]


def processor_time(pid: int) -> float:
    """Seconds of processor time that a process has used."""
    numbers = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(numbers[11]) + int(numbers[12])) / os.sysconf("SC_CLK_TCK")


class Programs:
    """Starts programs that all end with the stack.

    Args:
        folder: for logs and files.
        stack: what they end with.
        environment: variables of theirs, beside those of this process.

    Attributes:
        folder: as given.
        environment: all of their variables.
    """

    def __init__(
        self, folder: Path, stack: contextlib.ExitStack, environment: dict[str, str]
    ) -> None:
        self._stack = stack
        self.folder = folder
        self.environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(ROOT), *filter(None, sys.path)]),
            **environment,
        }

    @property
    def errors(self) -> str:
        """The end of what the programs wrote to their standard errors."""
        return (self.folder / "errors").read_text()[-4000:]

    def start(self, *command: str, **environment: str) -> subprocess.Popen[str]:
        """Start a program, whose output is kept from this one's but for what it answers."""
        with (self.folder / "errors").open("a") as errors:
            process = subprocess.Popen(
                command,
                env={**self.environment, **environment},
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
            )
        self._stack.callback(_end, process)
        return process


def _end(process: subprocess.Popen[str]) -> None:
    if process.poll() is None:
        process.kill()
    process.wait()
    assert process.stdout is not None
    process.stdout.close()
