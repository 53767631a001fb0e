"""The process that draws pictures of one model, started by `PictureProcess`.

It receives MuJoCo's model over its channel, then requests, and answers each. It exits when the
channel closes.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
import sys
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from aioduco._process.linked_process import ValueChannel
from aioduco.sim.view.camera import Camera, PictureMark

if TYPE_CHECKING:
    from numpy.typing import NDArray

    mujoco: Any  # its bindings are compiled, without types
else:
    import mujoco


#: values of MUJOCO_GL with which MuJoCo itself loads no OpenGL
_NOT_LOADED = frozenset(("disable", "disabled", "off", "false", "0"))
_LIBRARIES = "On Debian: apt-get install libegl1 libgl1-mesa-dri, or set MUJOCO_GL to what there is"


def advice() -> str:
    """What to do if no picture can be drawn on this computer."""
    if importlib.util.find_spec("OpenGL") is None:
        return "Pictures need PyOpenGL: pip install 'aioduco[sim]'"
    return _LIBRARIES


class PictureRequest(NamedTuple):
    """A request for a picture.

    Attributes:
        positions: positions of everything that moves.
        width, height: size of the picture [pixels].
        camera: the camera, or the number of a camera of the model.
        marks: balls that are drawn besides.
        depth: whether to return distances from the camera's plane instead of colours.
    """

    positions: NDArray[np.float64]
    width: int
    height: int
    camera: Camera | int
    marks: tuple[PictureMark, ...] = ()
    depth: bool = False


class Drawer:
    """An OpenGL context with MuJoCo's buffers in it; for one thread.

    Args:
        model: MuJoCo model.

    Raises:
        OSError: There is no OpenGL that draws off screen.
    """

    def __init__(self, model: Any) -> None:
        self._model, self._data = model, mujoco.MjData(model)
        self._gl = _context(model.vis.global_.offwidth, model.vis.global_.offheight)
        self._gl.make_current()
        self._scene = mujoco.MjvScene(model, maxgeom=10_000)
        self._option = mujoco.MjvOption()
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)

    def draw(self, request: PictureRequest) -> NDArray[np.uint8] | NDArray[np.float32]:
        """Draw a picture. Shape (height, width, 3), or distances [m], shape (height, width)."""
        data, model = self._data, self._model
        view = mujoco.MjvCamera()
        if isinstance(request.camera, Camera):
            request.camera.put(view)
        else:
            view.type = mujoco.mjtCamera.mjCAMERA_FIXED
            view.fixedcamid = request.camera
        data.qpos[:] = request.positions
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_camlight(model, data)
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(model, data, self._option, None, view, everything, self._scene)
        for mark in request.marks:
            self._mark(mark)
        rectangle = mujoco.MjrRect(0, 0, request.width, request.height)
        mujoco.mjr_render(rectangle, self._scene, self._context)
        if request.depth:
            buffer = np.empty((request.height, request.width), np.float32)
            mujoco.mjr_readPixels(None, buffer, rectangle, self._context)
            # MuJoCo's frustum is as wide as the scene; its buffer runs from 0 near to 1 far.
            extent, visible = model.stat.extent, model.vis.map
            near, far = visible.znear * extent, visible.zfar * extent
            distance = near / (1.0 - buffer * (1.0 - near / far))
            return np.ascontiguousarray(distance[::-1].astype(np.float32))
        picture = np.empty((request.height, request.width, 3), np.uint8)
        mujoco.mjr_readPixels(picture, None, rectangle, self._context)
        return np.ascontiguousarray(picture[::-1])  # OpenGL begins at the bottom

    def _mark(self, mark: PictureMark) -> None:
        scene = self._scene
        mujoco.mjv_initGeom(
            scene.geoms[scene.ngeom], mujoco.mjtGeom.mjGEOM_SPHERE, np.full(3, mark.radius),
            np.array(mark.at, dtype=float), np.eye(3).ravel(),
            np.array((*mark.colour, 1.0), dtype=np.float32),
        )  # fmt: skip
        scene.ngeom += 1


def _context(width: int, height: int) -> Any:
    """Open an OpenGL context: the one that MUJOCO_GL names, or the first that needs no display."""
    wanted = os.environ.get("MUJOCO_GL", "").lower()
    native = {"darwin": "cgl", "win32": "glfw"}.get(sys.platform)
    tries = [native] if native else ["egl", "osmesa"]
    if wanted and wanted not in _NOT_LOADED:
        tries = [wanted]
    failures = []
    for kind in tries:
        try:
            return importlib.import_module(f"mujoco.{kind}").GLContext(width, height)
        except Exception as exc:  # PyOpenGL raises many kinds, AttributeError too
            failures.append(f"{kind}: {exc}")
    raise OSError("; ".join(failures))


def main(arguments: list[str]) -> int:
    """Draw until the channel closes. If there is no picture, the answer is a text that says why."""
    drawer: Drawer | None = None
    channel = ValueChannel.of(arguments)
    with contextlib.suppress(KeyboardInterrupt, EOFError, OSError):
        model = channel.receive()
        while True:
            request = channel.receive()
            try:
                drawer = drawer or Drawer(model)
                answer: object = drawer.draw(request)
            except Exception as exc:  # reported to the process that asked
                answer = f"OpenGL draws nothing here ({exc}). {advice()}"
            channel.send(answer)
    return 0
