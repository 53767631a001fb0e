"""The variation of one run of a program, from its seed."""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from aioduco.models.words import one_of
from aioduco.sim.physics.parts import MOST_STUCK

if TYPE_CHECKING:
    from collections.abc import Iterable

    from aioduco.kinematics import Arm
    from aioduco.models.pose import JointsLike
    from aioduco.sim import Simulator


#: quantities that can be varied
KINDS = ("start", "latency", "faults", "payload", "parts")
#: largest offset of each start joint [rad], largest delay of an answer [s], and largest mass at the
#: flange that the program does not declare [kg]
_TURN, _LATENCY, _PAYLOAD = 0.15, 0.05, 0.5
#: longest time for which a part is held before it is dropped [s], largest mass that is added to a
#: part [kg], largest wear of a tool [m]
_HELD, _HEAVIER, _WORN = 3.0, 2.0, 0.003
#: the connection is cut at one of the first calls that change something: number of these
_CALLS = 40
#: what may be wrong with a part, the gripper or the tool
_PART_FAULTS = ("dropped", "missing", "stuck", "slipping", "heavy", "worn")


@dataclass(frozen=True, slots=True)
class Variation:
    """Variation of a run; a quantity that is zero or empty is not varied.

    Attributes:
        seed: seed that reproduces the variation.
        start: offsets of the start joints [rad].
        latency: largest delay of the controller's answer to a command [s].
        faults: commands at which the connection is cut, counted from 1.
        payload: mass at the flange, unknown to the controller [kg].
        parts: what is wrong with a part, the gripper or the tool: "dropped", "missing", "stuck",
            "slipping", "heavy" or "worn".
        part: which part, as a share of their number, 0 to 1.
        extent: how far it is wrong, 0 to 1.
    """

    seed: int = 0
    start: tuple[float, ...] = ()
    latency: float = 0.0
    faults: tuple[int, ...] = ()
    payload: float = 0.0
    parts: str = ""
    part: float = 0.0
    extent: float = 0.0

    @classmethod
    def of(cls, kinds: Iterable[str], seed: int) -> Variation:
        """Make the variation of a seed.

        Args:
            kinds: quantities to vary, from `KINDS`.
            seed: the same seed gives the same variation.

        Raises:
            ParameterError: there is no such kind.
        """
        kinds = tuple(kinds)
        for kind in kinds:
            one_of("vary", kind, KINDS)
        # all are drawn in a fixed order: leaving one out does not change the others
        draw = random.Random(seed)
        start = tuple(draw.uniform(-_TURN, _TURN) for _ in range(6))
        latency, fault = draw.uniform(0.0, _LATENCY), draw.randint(1, _CALLS)
        payload = draw.uniform(0.0, _PAYLOAD)
        parts, part, extent = draw.choice(_PART_FAULTS), draw.random(), draw.random()
        wrong = "parts" in kinds
        return cls(
            seed,
            start if "start" in kinds else (),
            latency if "latency" in kinds else 0.0,
            (fault,) if "faults" in kinds else (),
            payload if "payload" in kinds else 0.0,
            parts if wrong else "",
            part if wrong else 0.0,
            extent if wrong else 0.0,
        )

    def started(self, joints: JointsLike, arm: Arm) -> list[float]:
        """The varied start joints of the arm [rad], within its limits."""
        turned = np.asarray(joints, dtype=float) + np.array(self.start)
        return [float(each) for each in np.clip(turned, arm.lower, arm.upper)]

    def apply(self, simulator: Simulator) -> None:
        """Apply payload and faults of parts to the cell of a program that begins."""
        if self.payload:
            simulator.load(self.payload)
        names, gripper = simulator.parts, simulator.gripper is not None
        name = names[int(self.part * len(names))] if names else ""
        match self.parts:
            case "dropped" if gripper:
                simulator.drop_part(after=_HELD * self.extent)
            case "slipping" if gripper:
                simulator.set_grip(self.extent)
            case "missing" if names:
                simulator.remove_part(name)
            case "heavy" if names:
                simulator.set_part_mass(name, simulator.part_mass(name) + _HEAVIER * self.extent)
            case "stuck" if 1 < len(names) <= MOST_STUCK:
                other = min(
                    (each for each in names if each != name),
                    key=lambda each: simulator.thing(name).distance(simulator.thing(each))[0],
                )
                simulator.stick_parts(name, other)
            case "worn" if gripper or simulator.tool is not None:
                simulator.wear_tool(_WORN * self.extent)
