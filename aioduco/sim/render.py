"""Pictures of the simulated arm, drawn off screen.

Positions are drawn that were copied before, on a thread that has nothing to do with the physics:
a picture takes milliseconds to a second, a cycle of the controller a tenth of one.
"""

from __future__ import annotations

import copy
import importlib
import os
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.errors import ParameterError, RenderError
from aioduco.sim.camera import Camera

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]
    Picture = NDArray[np.uint8]

    mujoco: Any  # its bindings are compiled, without types
else:
    import mujoco

__all__ = ["Studio"]


class Studio:
    """Draws pictures of one model, on a thread of its own that OpenGL's context belongs to.

    Args:
        model: of MuJoCo; a copy is taken.

    Attributes:
        model: the copy, which nobody changes.
    """

    def __init__(self, model: Any) -> None:
        self.model: Any = copy.copy(model)
        self._thread: ThreadPoolExecutor | None = None
        self._drawer: _Drawer | None = None

    def picture(self, positions: Vector, width: int, height: int, camera: Camera | str) -> Picture:
        """Draw a picture.

        Args:
            positions: of everything that moves.
            width: of the picture [pixels].
            height: of the picture [pixels].
            camera: from where; a text names a camera of the scene.

        Returns:
            Red, green, blue. Shape (height, width, 3).

        Raises:
            ParameterError: The picture is too large, or there is no such camera.
            RenderError: This computer cannot draw.
        """
        most = self.model.vis.global_
        if not (0 < width <= most.offwidth and 0 < height <= most.offheight):
            raise ParameterError(
                "size", (width, height), f"from (1, 1) to ({most.offwidth}, {most.offheight})"
            )
        view = self._view(camera)
        if self._thread is None:
            self._thread = ThreadPoolExecutor(1, "sim-render")
        return self._thread.submit(self._draw, positions, width, height, view).result()

    def close(self) -> None:
        """Let go of OpenGL and end the thread."""
        if self._thread is not None:
            if self._drawer is not None:
                self._thread.submit(self._drawer.close).result()
            self._thread.shutdown()
        self._thread = self._drawer = None

    def _draw(self, positions: Vector, width: int, height: int, view: Any) -> Picture:
        if self._drawer is None:
            self._drawer = _Drawer(self.model)
        return self._drawer.draw(positions, width, height, view)

    def _view(self, camera: Camera | str) -> Any:
        view = mujoco.MjvCamera()
        if isinstance(camera, Camera):
            camera.put(view)
            return view
        names = [self.model.camera(i).name for i in range(self.model.ncam)]
        for name in (camera, f"scene/{camera}", f"tool/{camera}"):
            if name in names:
                view.type = mujoco.mjtCamera.mjCAMERA_FIXED
                view.fixedcamid = names.index(name)
                return view
        raise ParameterError("camera", camera, f"a Camera, or one of the scene's: {names}")


class _Drawer:
    """OpenGL's context and what MuJoCo keeps in it; for one thread."""

    def __init__(self, model: Any) -> None:
        self._model, self._data = model, mujoco.MjData(model)
        self._gl = _context(model.vis.global_.offwidth, model.vis.global_.offheight)
        try:
            self._gl.make_current()
            self._scene = mujoco.MjvScene(model, maxgeom=10_000)
            self._option = mujoco.MjvOption()
            self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        except Exception as exc:
            self._gl.free()
            raise RenderError(f"OpenGL draws nothing here: {exc}. {_ADVICE}") from exc

    def draw(self, positions: Vector, width: int, height: int, view: Any) -> Picture:
        data, model = self._data, self._model
        data.qpos[:] = positions
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_camlight(model, data)
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(model, data, self._option, None, view, everything, self._scene)
        rectangle = mujoco.MjrRect(0, 0, width, height)
        picture = np.empty((height, width, 3), np.uint8)
        mujoco.mjr_render(rectangle, self._scene, self._context)
        mujoco.mjr_readPixels(picture, None, rectangle, self._context)
        return np.ascontiguousarray(picture[::-1])  # OpenGL begins at the bottom

    def close(self) -> None:
        self._context.free()
        self._gl.free()


_ADVICE = "On Debian: apt-get install libegl1 libgl1-mesa-dri, or set MUJOCO_GL to what there is"


def _context(width: int, height: int) -> Any:
    """Open what OpenGL draws in: what MUJOCO_GL says, else the first of what needs no display."""
    wanted = os.environ.get("MUJOCO_GL", "").lower()
    native = {"darwin": "cgl", "win32": "glfw"}.get(sys.platform)
    tries = [wanted] if wanted else [native] if native else ["egl", "osmesa"]
    failures = []
    for kind in tries:
        try:
            return importlib.import_module(f"mujoco.{kind}").GLContext(width, height)
        except Exception as exc:  # PyOpenGL raises all sorts, an AttributeError too
            failures.append(f"{kind}: {exc}")
    raise RenderError(f"there is no OpenGL ({'; '.join(failures)}). {_ADVICE}")
