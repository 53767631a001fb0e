"""Faults of parts, as a person sees them at the machine: methods of `Simulator`."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING

from aioduco.models.pose import Pose, PoseLike
from aioduco.models.rules import Number

if TYPE_CHECKING:
    from aioduco.sim.assembly import SimulatorAssembly
    from aioduco.sim.physics.gripper import Hand
    from aioduco.sim.physics.parts import PartPlace


_FAR = 1000.0  # distance of a removed part [m]
_SHARE = Number(0.0, 1.0, source="this package")
_MASS = Number(0.0, 1000.0, "kg", open_low=True, source="this package")
_WORN = Number(0.0, 0.05, "m", source="this package")
_AFTER = Number(0.0, unit="s", source="this package")


class PartFaults:
    """What can go wrong with parts, gripper and tool, and where a part is.

    A part is a thing of the scene that may move on its own. Changes act from the next cycle on.
    """

    @abstractmethod
    def _running(self) -> SimulatorAssembly:
        """The parts of the running simulation."""

    def where(self, name: str) -> PartPlace:
        """Say where a part is: its pose, whether the gripper holds it, and what it touches.

            assert sim.where("part").touches == ("tray",)

        Raises:
            ParameterError: there is no such part.
        """
        assembly = self._running()
        return assembly.world.parts.where(name, assembly.runtime.snapshot.positions)

    def drop_part(self, after: float | None = None) -> None:
        """Have the gripper lose what it holds: the part falls, as soon as nothing else holds it.

        The gripper grips as usual again with its next order.

        Args:
            after: it loses, once, what it has held for so many seconds; None for what it holds now.

        Raises:
            RuntimeError: there is no gripper, or it holds nothing now.
            ParameterError: `after` is out of range.
        """
        hand = self._hand()
        if after is None and hand.reading.caught != 1:
            raise RuntimeError("the gripper holds nothing: nothing was dropped")
        wait = 0.0 if after is None else _AFTER("after", after)
        self._running().runtime.change_world(lambda: hand.drop(wait))

    def set_grip(self, share: float) -> None:
        """Have the gripper grip worse from now on: greasy parts, worn fingers, a leaking cup.

        Args:
            share: share of the usual friction of the fingers, or of a cup's force, 0 to 1; 1 for as
                usual.

        Raises:
            RuntimeError: there is no gripper.
            ParameterError: `share` is out of range.
        """
        hand, share = self._hand(), _SHARE("share", share)
        self._running().runtime.change_world(lambda: hand.set_grip(share))

    def put_part(self, name: str, pose: PoseLike) -> None:
        """Put a part at a pose in the world, at rest: where it should not be, or turned.

        It sticks to nothing any more.

        Args:
            name: the part.
            pose: its new pose [m, rad].

        Raises:
            ParameterError: there is no such part, or `pose` is not a pose.
        """
        parts, at = self._running().world.parts, Pose.of(pose)
        parts.place(name)
        self._running().runtime.change_world(lambda: parts.put(name, at))

    def remove_part(self, name: str) -> None:
        """Take a part away, so that it is missing; `put_part` brings it back.

        Raises:
            ParameterError: there is no such part.
        """
        self._running().world.parts.place(name)
        # apart from other removed ones
        self.put_part(name, (_FAR, 2.0 * self.parts.index(name), 1.0, 0.0, 0.0, 0.0))

    def stick_parts(self, one: str, other: str, *, stuck: bool = True) -> None:
        """Have two parts stick together as they lie, so that one comes with the other.

        Args:
            one: a part.
            other: another one. In a scene of more than twelve parts none can be stuck.
            stuck: false to part them.

        Raises:
            ParameterError: there is no such part, it is the same one, or there are too many.
        """
        parts = self._running().world.parts
        weld = parts.weld_of(one, other)
        self._running().runtime.change_world(lambda: parts.stick(weld, stuck=stuck))

    def part_mass(self, name: str) -> float:
        """Mass of a part [kg].

        Raises:
            ParameterError: there is no such part.
        """
        return self._running().world.parts.mass(name)

    def set_part_mass(self, name: str, mass: float) -> None:
        """Give a part another mass than the one that was said.

        Args:
            name: the part.
            mass: its mass, above 0 to 1000 [kg].

        Raises:
            ParameterError: there is no such part, or `mass` is out of range.
        """
        parts, mass = self._running().world.parts, _MASS("mass", mass)
        parts.place(name)
        self._running().runtime.change_world(lambda: parts.set_mass(name, mass))

    def wear_tool(self, by: float) -> None:
        """Have the tool or the gripper be worn: its tip is nearer to the flange.

        Args:
            by: how much shorter it is than it was at first, 0 to 0.05 [m].

        Raises:
            RuntimeError: there is no tool.
            ParameterError: `by` is out of range.
        """
        world, by = self._running().world, _WORN("by", by)
        if world.tool_body < 0:
            raise RuntimeError("there is no tool and no gripper: nothing was worn")
        self._running().runtime.change_world(lambda: world.wear_tool(by))

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of the parts: the things of the scene that may move on their own."""
        return tuple(self._running().world.parts.names)

    def _hand(self) -> Hand:
        hand = self._running().world.hand
        if hand is None:
            raise RuntimeError("there is no gripper: Simulator(gripper=...) has one")
        return hand
