"""The variation of one run of a program, from its seed."""

from __future__ import annotations

import random
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.errors import ParameterError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from aioduco.kinematics import Arm
    from aioduco.models.pose import JointsLike

__all__ = ["KINDS", "Variation"]

#: quantities that can be varied
KINDS = ("start", "latency", "faults", "payload")
#: largest offset of each start joint [rad], largest delay of an answer [s], and largest mass at the
#: flange that the program does not declare [kg]
_TURN, _LATENCY, _PAYLOAD = 0.15, 0.05, 0.5
#: the connection is cut at one of the first calls that change something: number of these
_CALLS = 40


@dataclass(frozen=True, slots=True)
class Variation:
    """Variation of a run; a quantity that is zero or empty is not varied.

    Attributes:
        seed: seed that reproduces the variation.
        start: offsets of the start joints [rad].
        latency: largest delay of the controller's answer to a command [s].
        faults: commands at which the connection is cut, counted from 1.
        payload: mass at the flange, unknown to the controller [kg].
    """

    seed: int = 0
    start: tuple[float, ...] = ()
    latency: float = 0.0
    faults: tuple[int, ...] = ()
    payload: float = 0.0

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
            if kind not in KINDS:
                raise ParameterError("vary", kind, f"one of {', '.join(KINDS)}")
        # all are drawn in a fixed order: leaving one out does not change the others
        draw = random.Random(seed)
        start = tuple(draw.uniform(-_TURN, _TURN) for _ in range(6))
        latency, fault = draw.uniform(0.0, _LATENCY), draw.randint(1, _CALLS)
        payload = draw.uniform(0.0, _PAYLOAD)
        return cls(
            seed,
            start if "start" in kinds else (),
            latency if "latency" in kinds else 0.0,
            (fault,) if "faults" in kinds else (),
            payload if "payload" in kinds else 0.0,
        )

    def started(self, joints: JointsLike, arm: Arm) -> list[float]:
        """The varied start joints of the arm [rad], within its limits."""
        turned = np.asarray(joints, dtype=float) + np.array(self.start)
        return [float(each) for each in np.clip(turned, arm.lower, arm.upper)]

    def as_json(self) -> dict[str, Any]:
        """The variation as values for JSON."""
        return asdict(self)
