"""What a person does at the machine: methods of `Simulator`.

Inputs, the mode switch, the emergency stop, a collision, a push at the flange, a load, friction.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING

from aioduco.errors import ParameterError
from aioduco.models.enums import OperationMode
from aioduco.models.ranges import FLAG
from aioduco.models.rules import Integer, Number, Vector

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.sim.assembly import SimulatorAssembly


_JOINT = Integer(1, 6, source="this package")
# far beyond what an arm bears, and still safe to compute with
_WRENCH = Vector(
    *[Number(-1e4, 1e4, "N", source="this package")] * 3,
    *[Number(-1e4, 1e4, "N·m", source="this package")] * 3,
)
_MASS = Number(0.0, 1000.0, "kg", source="this package")
_CENTRE = Vector(Number(-10.0, 10.0, "m", source="this package"), length=3)
_DRY = Vector(Number(0.0, 1e4, "N·m", source="this package"), length=6)
_VISCOUS = Vector(Number(0.0, 1e4, "N·m·s/rad", source="this package"), length=6)


class OperatorActions:
    """Actions of a person at the machine, and what acts on the arm from outside."""

    @abstractmethod
    def _running(self) -> SimulatorAssembly:
        """The parts of the running simulation."""

    def set_digital_input(self, num: int, value: bool) -> None:
        """Set a general input of the cabinet, 1 to 16.

        Raises:
            IndexError: there is no such input.
            ParameterError: `value` is neither True nor False.
        """
        value = FLAG("value", value)
        with self._running().runtime.command() as controller:
            controller.signals.standard_in[num] = value

    def set_tool_digital_input(self, num: int, value: bool) -> None:
        """Set an input of the tool, 1 or 2.

        Raises:
            IndexError: there is no such input.
            ParameterError: `value` is neither True nor False.
        """
        value = FLAG("value", value)
        with self._running().runtime.command() as controller:
            controller.signals.tool_in[num] = value

    def switch_mode(self, mode: OperationMode) -> None:
        """Turn the mode switch of the cabinet; running motions and programs are paused.

        If `cabinet.mode_switch` is set, programs cannot switch the mode.

        Args:
            mode: manual, automatic or remote.

        Raises:
            ParameterError: it is none of them.
        """
        if not isinstance(mode, OperationMode):
            raise ParameterError("mode", mode, "an OperationMode")
        with self._running().runtime.command() as controller:
            controller.switch_mode(mode)

    def emergency_stop(self) -> None:
        """Press the emergency stop."""
        with self._running().runtime.command() as controller:
            controller.press_emergency_stop()

    def release_emergency_stop(self) -> None:
        """Release the emergency stop; then power off, power on and enable end the stop."""
        with self._running().runtime.command() as controller:
            controller.release_emergency_stop()

    def collide(self, joint: int) -> None:
        """Make a joint, 1 to 6, detect a collision.

        An arm that is not enabled detects none, nor one whose program has switched detection off.

        Raises:
            ParameterError: there is no such joint.
        """
        joint = _JOINT("joint", joint)
        with self._running().runtime.command() as controller:
            if controller.collisions.level:
                controller.collide(joint)

    def push(self, wrench: Sequence[float]) -> None:
        """Push at the flange from now on, like a person that guides the arm by hand.

        Args:
            wrench: force [N], then torque [N m], in the base frame, each at most 10,000; six zeros
                to end the push.

        Raises:
            ParameterError: `wrench` is not six such numbers; the push is as before.
        """
        wrench = _WRENCH("wrench", wrench)
        self._running().runtime.push(wrench)

    def load(self, mass: float, centre: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        """Mount a load at the flange, whatever load the program sets.

        Until this is called, the mounted load is the one that the program sets by `set_tool_data`
        and `set_load_data`. From then on the two are independent: if the program sets a wrong load,
        the controller takes the difference for an external force, as a real one does.

        Args:
            mass: mass of the load, a point without inertia of its own, at most 1000 [kg]; zero for
                no load.
            centre: its centre of mass in the frame of the flange, at most 10 m along each axis [m].

        Raises:
            ParameterError: One of the numbers is none of these; the load is as before.
        """
        mass, centre = _MASS("mass", mass), _CENTRE("centre", centre)
        self._running().runtime.carry(mass, centre)

    def drag(
        self,
        dry: Sequence[float],
        viscous: Sequence[float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    ) -> None:
        """Let something drag at the joints from now on, as a worn bearing or a hose does.

        The controller does not know of it: it appears in the joints' currents and, with the
        opposite sign of the speed, in the observed external torques. The `friction` of a profile
        is another thing: that of the drives, for which they compensate.

        Args:
            dry: torque against the motion of the six joints, at most 10,000 [N m].
            viscous: torque that grows with the speed, likewise [N m s/rad].

        Raises:
            ParameterError: One of them is not six such numbers; the drag is as before.
        """
        dry, viscous = _DRY("dry", dry), _VISCOUS("viscous", viscous)
        self._running().runtime.drag(dry, viscous)
