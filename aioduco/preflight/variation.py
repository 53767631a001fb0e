"""How one run of a program differs from the others, by its seed."""

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

#: what can be varied
KINDS = ("start", "latency", "faults", "payload")
#: most by which each joint starts elsewhere [rad], an answer comes later [s], and the load at the
#: flange is heavier than the program says [kg]
_TURN, _LATENCY, _PAYLOAD = 0.15, 0.05, 0.5
#: the connection is cut at one of so many calls that change something
_CALLS = 40


@dataclass(frozen=True, slots=True)
class Variation:
    """One way in which a run differs; everything that is zero or empty is as it was.

    Attributes:
        seed: makes all of it again.
        start: by how much each joint starts elsewhere [rad].
        latency: up to how much later the controller answers a command [s].
        faults: at which commands the connection is cut, counted from 1.
        payload: hangs at the flange, unknown to the controller [kg].
    """

    seed: int = 0
    start: tuple[float, ...] = ()
    latency: float = 0.0
    faults: tuple[int, ...] = ()
    payload: float = 0.0

    @classmethod
    def of(cls, kinds: Iterable[str], seed: int) -> Variation:
        """The variation of a seed.

        Args:
            kinds: what is varied, of `KINDS`.
            seed: the same one makes the same variation.

        Raises:
            ParameterError: there is no such kind.
        """
        kinds = tuple(kinds)
        for kind in kinds:
            if kind not in KINDS:
                raise ParameterError("vary", kind, f"one of {', '.join(KINDS)}")
        # one after the other, whatever is chosen: leaving one out changes no other
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
        """The joints that the arm stands at first [rad], within its limits."""
        turned = np.asarray(joints, dtype=float) + np.array(self.start)
        return [float(each) for each in np.clip(turned, arm.lower, arm.upper)]

    def as_json(self) -> dict[str, Any]:
        """As JSON takes it."""
        return asdict(self)
