"""A camera in the simulator's scene, or on the tool.

A separate process renders its images, so that the controller's cycle does not wait for them.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Self

from aioduco._process.copying import Uncopied
from aioduco.devices.cameras.camera import CameraFrame, Intrinsics
from aioduco.errors import ParameterError
from aioduco.models.rules import Integer

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from aioduco.sim.simulator import Simulator


_WIDTH = Integer(1, 1920, "pixels", source="this package")
_HEIGHT = Integer(1, 1080, "pixels", source="this package")


class SimulatedCamera(Uncopied):
    """A camera that is defined in the MJCF of a scene or of a tool.

        scene = '<mujoco><worldbody><camera name="eye" pos="0.5 0 1.2" fovy="45"/>...'
        with Simulator(scene=scene) as sim, SimulatedCamera(sim, "eye") as eye:
            frame = eye.read()

    Args:
        simulator: the simulator, of this process, which must run when an image is taken.
        name: name of the camera in the MJCF; its `fovy` is the vertical angle of view.
        width, height: size of images, at most 1920 by 1080 [pixels].
        depth: whether to return distances, too; an image then takes twice as long.

    Raises:
        ParameterError: there is no such camera or simulator, or an image cannot have that size.
    """

    def __init__(
        self,
        simulator: Simulator,
        name: str,
        *,
        width: int = 640,
        height: int = 480,
        depth: bool = False,
    ) -> None:
        if not hasattr(simulator, "field_of_view"):
            here = "a Simulator of this process: one of Simulator.spawn has no pictures for others"
            raise ParameterError("simulator", simulator, here)
        width, height = _WIDTH("width", width), _HEIGHT("height", height)
        self._simulator, self._name, self._depth = simulator, name, depth
        focal = 0.5 * height / math.tan(0.5 * simulator.field_of_view(name))
        self._intrinsics = Intrinsics(
            width=width, height=height, fx=focal, fy=focal,
            cx=0.5 * (width - 1), cy=0.5 * (height - 1),
        )  # fmt: skip

    def __repr__(self) -> str:
        return f"<SimulatedCamera {self._name!r} of {self._simulator!r}>"

    @property
    def intrinsics(self) -> Intrinsics:
        """Mapping of points to pixels: a pinhole camera, without distortion."""
        return self._intrinsics

    @property
    def pose(self) -> NDArray[np.float64]:
        """The camera's present frame in the world, which on a real arm needs a calibration.

        The axes are those of `Intrinsics`: z along the viewing direction. Shape (4, 4).
        """
        return self._simulator.camera_pose(self._name)

    def read(self) -> CameraFrame:
        """Take an image of the instant of the call.

        Raises:
            RenderError: this computer has no OpenGL for off-screen rendering.
        """
        simulator, size = self._simulator, self._intrinsics
        time, positions = simulator.instant()
        width, height = size.width, size.height
        image = simulator.render(camera=self._name, positions=positions, width=width, height=height)
        depth = None
        if self._depth:
            depth = simulator.render_depth(
                camera=self._name, positions=positions, width=width, height=height
            )
        return CameraFrame(image, depth, time, size)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Do nothing: the simulator ends the rendering process."""
