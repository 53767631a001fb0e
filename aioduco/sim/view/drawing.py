"""Draws pictures of one model: `python -m aioduco.sim.view.drawing`, started by `render.Studio`.

It reads pickles from its standard input, MuJoCo's model first and then requests, and writes the
answer to each to its standard output. It ends when its input does.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import pickle
import struct
import sys
from typing import IO, TYPE_CHECKING, Any, NamedTuple

import numpy as np

from aioduco.sim.view.camera import Camera

if TYPE_CHECKING:
    from numpy.typing import NDArray

    mujoco: Any  # its bindings are compiled, without types
else:
    import mujoco

__all__ = ["ADVICE", "PictureRequest", "receive", "send"]

_HEAD = struct.Struct("<Q")
ADVICE = "On Debian: apt-get install libegl1 libgl1-mesa-dri, or set MUJOCO_GL to what there is"


class PictureRequest(NamedTuple):
    """A picture that is wanted.

    Attributes:
        positions: of everything that moves.
        width, height: of the picture [pixels].
        camera: from where, or the number of a camera of the model.
    """

    positions: NDArray[np.float64]
    width: int
    height: int
    camera: Camera | int


def send(stream: IO[bytes], thing: object) -> None:
    """Write a thing to a pipe."""
    data = pickle.dumps(thing)
    stream.write(_HEAD.pack(len(data)))
    stream.write(data)
    stream.flush()


def receive(stream: IO[bytes]) -> Any:
    """Read a thing from a pipe of a process that we started, or that started us.

    Raises:
        EOFError: The pipe was closed.
    """
    head = stream.read(_HEAD.size)
    if len(head) < _HEAD.size:
        raise EOFError
    return pickle.loads(stream.read(_HEAD.unpack(head)[0]))


class Drawer:
    """OpenGL's context and what MuJoCo keeps in it; for one thread.

    Args:
        model: of MuJoCo.

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

    def draw(self, request: PictureRequest) -> NDArray[np.uint8]:
        """Draw a picture. Shape (height, width, 3)."""
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
        rectangle = mujoco.MjrRect(0, 0, request.width, request.height)
        picture = np.empty((request.height, request.width, 3), np.uint8)
        mujoco.mjr_render(rectangle, self._scene, self._context)
        mujoco.mjr_readPixels(picture, None, rectangle, self._context)
        return np.ascontiguousarray(picture[::-1])  # OpenGL begins at the bottom


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
    raise OSError("; ".join(failures))


def main(requests: IO[bytes], answers: IO[bytes]) -> None:
    """Draw until the requests end. An answer that is a text says why there is no picture."""
    drawer: Drawer | None = None
    model = receive(requests)
    with contextlib.suppress(EOFError, BrokenPipeError):
        while True:
            request = receive(requests)
            try:
                drawer = drawer or Drawer(model)
                answer: object = drawer.draw(request)
            except Exception as exc:  # reported to the process that asked
                answer = f"OpenGL draws nothing here ({exc}). {ADVICE}"
            send(answers, answer)


def _serve() -> None:
    output = os.dup(1)
    os.dup2(2, 1)  # what a driver prints is no answer
    with contextlib.suppress(KeyboardInterrupt, EOFError), os.fdopen(output, "wb") as out:
        main(sys.stdin.buffer, out)


if __name__ == "__main__":
    _serve()
