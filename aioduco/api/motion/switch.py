"""Lead the arm from a trajectory that it follows into another one, without a stop."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from aioduco._process.copying import Uncopied

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from aioduco.streaming.joint_trajectory import JointTrajectory, Tolerances


class SwitchPlace(NamedTuple):
    """Where a trajectory is left.

    Attributes:
        joints: the set-point there [rad]. Shape (6,).
        speeds: its speed [rad/s]. Shape (6,).
        delay: time until the arm is sent it [s].
    """

    joints: NDArray[np.float64]
    speeds: NDArray[np.float64]
    delay: float


_Make: TypeAlias = "Callable[[SwitchPlace], tuple[JointTrajectory, Tolerances] | None]"


class TrajectorySwitch(Uncopied):
    """Leads `robot.motion.follow_joint_trajectory` from its trajectory into another one.

        switch = TrajectorySwitch()
        tasks.start_soon(follow_with, switch)
        switch.ask(lambda place: (onwards(place.joints, place.speeds), Tolerances()))

    The other trajectory has to begin at time 0 with the joints and the speeds of the place: there
    the set-points have no step in either. It is the program's to keep the limits; the stream's
    limiter rounds what exceeds its acceleration. The place lies as far ahead as set-points are
    sent ahead, 0.4 s. All methods belong to the event loop.
    """

    def __init__(self) -> None:
        self._open = False
        self._asked: tuple[_Make, Callable[[], object]] | None = None

    def ask(self, make: _Make, otherwise: Callable[[], object] = lambda: None) -> None:
        """Ask for another trajectory; an earlier question is withdrawn.

        Args:
            make: called once, with the place; returns the trajectory and its tolerances, or None
                to go on with the present one.
            otherwise: called in its place if no trajectory is being sent, or the last set-point of
                it was.
        """
        if self._open:
            self._asked = make, otherwise
        else:
            otherwise()

    # -- for the function that follows the trajectory ----------------------------------------------

    @property
    def asked(self) -> bool:
        """Whether another trajectory was asked for."""
        return self._asked is not None

    def begin(self) -> None:
        """Set-points are sent from now on."""
        self._open = True

    def made(self, place: SwitchPlace) -> tuple[JointTrajectory, Tolerances] | None:
        """The other trajectory; None to go on."""
        assert self._asked is not None
        (make, _), self._asked = self._asked, None
        return make(place)

    def end(self) -> None:
        """The last set-point is sent, or the trajectory has ended."""
        self._open, asked, self._asked = False, self._asked, None
        if asked is not None:
            asked[1]()
