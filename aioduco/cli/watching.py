"""Wait until a simulator is to end; meanwhile show it in a window, or take frames of a film."""

from __future__ import annotations

import contextlib
import select
import time
from typing import TYPE_CHECKING

from aioduco.cli import picture
from aioduco.cli.exit_codes import fail
from aioduco.cli.output import say

if TYPE_CHECKING:
    import socket
    from collections.abc import Iterator
    from pathlib import Path

    from aioduco.sim import Simulator
    from aioduco.sim.view.film import Film, Frame
    from aioduco.sim.view.viewer import Viewer


_LOOK = 0.05  # simulated time between two frames of a film [s]
_SHOW = 1 / 30  # time between two pictures in a window [s]
_LEAST = 0.01  # time between two frames in any case [s]
_WIDTH, _HEIGHT = 480, 360


class SimulatorWatch:
    """Shows a simulator in a window and records a film of it, as requested.

    Args:
        simulator: a running simulator.
        film: where to write what the arm did; None for nowhere.
        view: whether to show it in a window.

    Raises:
        RenderError: This computer cannot draw, or has no display.
    """

    def __init__(self, simulator: Simulator, film: Path | None, *, view: bool) -> None:
        self._simulator = simulator
        self._path = film
        if film is not None:
            simulator.render(width=_WIDTH, height=_HEIGHT)  # so that a failure occurs now
        self._window = simulator.window() if view else None

    def until(self, end: socket.socket) -> None:
        """Wait until a socket is readable or the window is closed; then write the film."""
        if self._path is None and self._window is None:
            select.select([end], [], [])
            return
        from aioduco.sim.view.film import Film  # noqa: PLC0415 - needs the extra

        film = Film(limit=200)
        with self._window or contextlib.nullcontext():
            _look(self._simulator, end, film, self._window)
        if self._path is not None:
            _write(self._simulator, end, film, self._path)


def _look(simulator: Simulator, end: socket.socket, film: Film, window: Viewer | None) -> None:
    period = max(_SHOW if window is not None else _LOOK / simulator.speed, _LEAST)
    due = time.monotonic()
    while window is None or window.running:
        film.add(simulator.time, simulator.positions)
        if window is not None:
            window.show()
        due = max(due + period, time.monotonic())
        if select.select([end], [], [], max(due - time.monotonic(), 0.0))[0]:
            return


def _write(simulator: Simulator, end: socket.socket, film: Film, path: Path) -> None:
    frames = film.frames if path.suffix == ".gif" else film.frames[-1:]
    say(f"drawing {len(frames)} pictures; Ctrl-C once more ends it with those drawn")
    with contextlib.suppress(BlockingIOError):
        end.setblocking(False)
        end.recv(4096)
    pictures = _drawn(simulator, end, frames)
    try:
        picture.save(path, pictures, [frame.duration for frame in frames])
    except OSError as error:
        fail(f"{path} cannot be written: {error.strerror or error}")
    say(f"written to {path}")


def _drawn(
    simulator: Simulator, end: socket.socket, frames: list[Frame]
) -> Iterator[picture.Picture]:
    for number, frame in enumerate(frames):
        if number and select.select([end], [], [], 0.0)[0]:
            return
        yield simulator.render(width=_WIDTH, height=_HEIGHT, positions=frame.positions)
