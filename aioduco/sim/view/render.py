"""Pictures of the simulated arm, drawn off screen by a separate process.

A picture takes milliseconds to a second, much of it with the interpreter's lock held, and graphics
drivers may crash. Neither may disturb a controller with a cycle of a millisecond.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from aioduco._process import trial
from aioduco._process.linked_process import LinkedProcess
from aioduco._process.spawn import MUJOCO_PACKAGES, Unstartable
from aioduco.errors import ParameterError, RenderError
from aioduco.sim.view.camera import Camera, PictureMark
from aioduco.sim.view.drawing import PictureRequest, advice

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import numpy as np
    from numpy.typing import NDArray


class PictureProcess:
    """Draws pictures of one model in a separate process.

    Args:
        compiled: returns the MuJoCo model; called when it is first needed.
    """

    def __init__(self, compiled: Callable[[], Any]) -> None:
        self._compiled = compiled
        self._model: Any = None
        self._compiling = threading.Lock()
        self._lock = threading.Lock()
        self._process: LinkedProcess | None = None

    @property
    def model(self) -> Any:
        """The MuJoCo model. Callers must not change it."""
        with self._compiling:
            if self._model is None:
                self._model = self._compiled()
            return self._model

    def picture(
        self,
        positions: NDArray[np.float64],
        width: int,
        height: int,
        camera: Camera | str,
        marks: Sequence[PictureMark] = (),
        *,
        depth: bool = False,
    ) -> NDArray[Any]:
        """Draw a picture, or measure distances from the camera's plane.

        Args:
            positions: positions of everything that moves.
            width: width of the picture [pixels].
            height: height of the picture [pixels].
            camera: the camera, or the name of a camera of the scene.
            marks: balls that are drawn besides.
            depth: whether to measure distances.

        Returns:
            Red, green, blue, shape (height, width, 3); or distances along the camera's axis [m],
            shape (height, width).

        Raises:
            ParameterError: The picture is too large, there is no such camera, or there are not as
                many positions as the model has.
            RenderError: This computer cannot draw, or cannot start the process.
        """
        most = self.model.vis.global_
        if not (0 < width <= most.offwidth and 0 < height <= most.offheight):
            raise ParameterError(
                "size", (width, height), f"from (1, 1) to ({most.offwidth}, {most.offheight})"
            )
        shape = getattr(positions, "shape", None)
        if shape != (self.model.nq,):
            given = positions if shape is None else shape
            raise ParameterError("positions", given, f"an array of shape ({self.model.nq},)")
        seen = self._camera(camera)
        request = PictureRequest(positions, width, height, seen, tuple(marks), depth)
        with self._lock, trial.untimed():
            answer: NDArray[Any] | str = self._ask(request)
        if isinstance(answer, str):
            raise RenderError(answer)
        return answer

    def close(self) -> None:
        """End the process; return when it has exited."""
        with self._lock:
            process, self._process = self._process, None
            if process is not None:
                process.close()

    def _ask(self, request: PictureRequest) -> Any:
        process, new = self._process, self._process is None
        if process is None:
            process = self._process = self._start()
        try:
            if new:
                process.channel.send(self.model)
            return process.ask(request)
        except (EOFError, OSError) as exc:
            self._process = None
            why = process.end() or repr(exc)
            raise RenderError(f"the process that draws has ended ({why}). {advice()}") from exc

    def _start(self) -> LinkedProcess:
        try:
            return LinkedProcess("aioduco.sim.view.drawing", packages=MUJOCO_PACKAGES)
        except (Unstartable, OSError) as exc:
            raise RenderError(f"the process that draws was not started: {exc}") from exc

    def _camera(self, camera: Camera | str) -> Camera | int:
        if isinstance(camera, Camera):
            return camera
        names = [self.model.camera(i).name for i in range(self.model.ncam)]
        for name in (camera, f"scene/{camera}", f"tool/{camera}"):
            if name in names:
                return names.index(name)
        raise ParameterError("camera", camera, f"a Camera, or one of the scene's: {names}")
