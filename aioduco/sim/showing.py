"""How the arm is looked at, as methods of the simulator."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from aioduco.sim.camera import Camera, towards

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.models.pose import Pose
    from aioduco.sim.render import Studio
    from aioduco.sim.runtime import Runtime
    from aioduco.sim.viewer import Viewer

__all__ = ["Showing"]


class Showing(ABC):
    """Pictures of a running machine, and a window on it."""

    arm: Arm
    mounting: Pose
    _studio: Studio | None

    @abstractmethod
    def _running(self) -> Runtime:
        """Give the simulation, which must be running."""

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions of everything that moves, for `render`: the joints, the tool, the scene."""
        return self._running().snapshot.positions.copy()

    def render(
        self,
        *,
        width: int = 640,
        height: int = 480,
        camera: Camera | str | None = None,
        positions: NDArray[np.float64] | None = None,
    ) -> NDArray[np.uint8]:
        """Draw a picture of the arm and what is around it, without a display.

        It is drawn by a process of its own, which starts with the first picture: the simulation
        goes on meanwhile.

        Args:
            width: of the picture, at most 1920 [pixels].
            height: of the picture, at most 1080 [pixels].
            camera: from where it is seen: a `Camera`, or the name of one in the scene; None for
                one that sees the whole arm.
            positions: what is to be drawn, as `positions` gave it at another instant; None for now.

        Returns:
            Red, green, blue. Shape (height, width, 3).

        Raises:
            ParameterError: The picture is too large, or there is no such camera.
            RenderError: This computer has no OpenGL that draws off screen.
        """
        shown = self.positions if positions is None else positions
        assert self._studio is not None
        seen = towards(self.arm, self.mounting) if camera is None else camera
        return self._studio.picture(shown, width, height, seen)

    def window(self) -> Viewer:
        """Open MuJoCo's window on the arm, where there is a display.

        The window shows how things are each time that its method `show` is called:

            with sim.window() as window:
                while window.running:
                    window.show()
                    time.sleep(1 / 30)

        Returns:
            The window.

        Raises:
            RenderError: There is no display.
        """
        from aioduco.sim.viewer import Viewer  # noqa: PLC0415 - for those who have a display

        self._running()
        assert self._studio is not None
        return Viewer(self._studio.model, lambda: self.positions, towards(self.arm, self.mounting))
