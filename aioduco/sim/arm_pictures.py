"""Pictures of the simulated arm and its surroundings: methods of `Simulator`."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING

from aioduco.sim.physics.world import camera_of
from aioduco.sim.view.camera import Camera, PictureMark, towards

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from aioduco.sim.assembly import SimulatorAssembly
    from aioduco.sim.view.viewer import Viewer


class ArmPictures:
    """Draws the arm, without a display or in a window."""

    @abstractmethod
    def _running(self) -> SimulatorAssembly:
        """The parts of the running simulation."""

    @property
    @abstractmethod
    def positions(self) -> NDArray[np.float64]:
        """Positions of all moving parts."""

    def field_of_view(self, camera: str) -> float:
        """Vertical angle of view of a camera of the scene or the tool [rad].

        Raises:
            ParameterError: there is no such camera.
        """
        return self._camera(camera)[0]

    def camera_pose(self, camera: str) -> NDArray[np.float64]:
        """Present frame of a camera of the scene or the tool in the world. Shape (4, 4).

        Its z axis points along its view, x to the right, y down.

        Raises:
            ParameterError: there is no such camera.
        """
        return self._camera(camera)[1]

    def _camera(self, name: str) -> tuple[float, NDArray[np.float64]]:
        return camera_of(self._running().pictures.model, name, self.positions)

    def render(
        self,
        *,
        width: int = 640,
        height: int = 480,
        camera: Camera | str | None = None,
        positions: NDArray[np.float64] | None = None,
        marks: Sequence[PictureMark] = (),
    ) -> NDArray[np.uint8]:
        """Draw a picture of the arm and its surroundings, without a display.

        A separate process draws it, which starts with the first picture. The simulation continues
        meanwhile.

        Args:
            width: of the picture, at most 1920 [pixels].
            height: of the picture, at most 1080 [pixels].
            camera: a `Camera`, or the name of one in the scene; None for one that sees the whole
                arm.
            positions: positions to draw, as `positions` gave them at another instant; None for now.
            marks: balls to draw in addition, such as one at a goal.

        Returns:
            Red, green, blue. Shape (height, width, 3).

        Raises:
            ParameterError: The picture is too large, or there is no such camera.
            RenderError: This computer has no OpenGL for off-screen drawing.
        """
        shown = self.positions if positions is None else positions
        return self._running().pictures.picture(shown, width, height, self._seen_by(camera), marks)

    def render_depth(
        self,
        *,
        width: int = 640,
        height: int = 480,
        camera: Camera | str | None = None,
        positions: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float32]:
        """Draw a depth image, as a depth camera does; arguments and errors are those of `render`.

        Returns:
            Distances along the camera's axis [m]. Shape (height, width).
        """
        shown = self.positions if positions is None else positions
        pictures, seen = self._running().pictures, self._seen_by(camera)
        return pictures.picture(shown, width, height, seen, depth=True)

    def window(self) -> Viewer:
        """Open MuJoCo's window with the arm; it needs a display.

        The window shows the present state each time that its method `show` is called:

            with sim.window() as window:
                while window.running:
                    window.show()
                    time.sleep(1 / 30)

        Returns:
            The window.

        Raises:
            RenderError: There is no display.
        """
        from aioduco.sim.view.viewer import Viewer  # noqa: PLC0415 - for those who have a display

        model = self._running().pictures.model
        return Viewer(model, lambda: self.positions, self._whole())

    def _seen_by(self, camera: Camera | str | None) -> Camera | str:
        return self._whole() if camera is None else camera

    def _whole(self) -> Camera:
        """A camera that sees the whole arm."""
        world = self._running().world
        return towards(world.arm, world.mounting)
