"""MuJoCo's window, which shows a running simulator."""

from __future__ import annotations

import copy
import importlib
import os
import sys
import warnings
from typing import TYPE_CHECKING, Any, Self

from aioduco._process.copying import Uncopied
from aioduco.errors import RenderError

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from aioduco.sim.view.camera import Camera

    mujoco: Any  # its bindings are compiled, without types
else:
    import mujoco


class Viewer(Uncopied):
    """A window that shows given positions; it moves nothing itself.

    It has its own thread: if the window is closed, `running` becomes false and nothing else ends.

    Args:
        model: MuJoCo model; it is copied.
        positions: returns the positions to be shown.
        camera: the first view.

    Raises:
        RenderError: There is no display.
    """

    def __init__(self, model: Any, positions: Callable[[], NDArray[Any]], camera: Camera) -> None:
        need_display()
        self._model = copy.copy(model)
        self._data = mujoco.MjData(self._model)
        self._positions = positions
        self._data.qpos[:] = positions()
        viewer = importlib.import_module("mujoco.viewer")
        self._window = viewer.launch_passive(
            self._model, self._data, show_left_ui=False, show_right_ui=False
        )
        with self._window.lock():
            camera.put(self._window.cam)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def running(self) -> bool:
        """Whether the window is open."""
        return bool(self._window.is_running())

    def show(self) -> None:
        """Show the present positions. Call it about thirty times a second."""
        with self._window.lock():
            self._data.qpos[:] = self._positions()
            mujoco.mj_forward(self._model, self._data)
        self._window.sync()

    def close(self) -> None:
        """Close the window."""
        self._window.close()


def need_display() -> None:
    """Check that a window can be opened: without a display, MuJoCo would wait for ever.

    Raises:
        RenderError: No window can be opened.
    """
    variables = ("DISPLAY", "WAYLAND_DISPLAY")
    if sys.platform == "linux" and not any(os.environ.get(name) for name in variables):
        raise RenderError(
            "there is no display (neither DISPLAY nor WAYLAND_DISPLAY is set): draw pictures "
            "instead, by Simulator.render() or `aioduco sim --render out.gif`"
        )
    try:
        glfw = importlib.import_module("glfw")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its warnings repeat what it returns
            opened = glfw.init()
    except Exception as exc:
        raise RenderError(f"no window can be opened: {exc}") from exc
    if not opened:
        raise RenderError("no window can be opened on this display")
