"""Smallest distances of the arm from its limits, from samples of its positions."""

from __future__ import annotations

import copy
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.kinematics import arm as arm_of
from aioduco.kinematics.forward import singular_values
from aioduco.planning.clearance import Clearance
from aioduco.planning.collision import CollisionChecker
from aioduco.testing.preflight.findings import PreflightFinding, running

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from aioduco.sim.physics.world import World


#: largest number of samples that are compared with the scene
_LOOKS = 400
#: obstacles at a larger distance are not reported [m]
_FURTHEST = 0.5
#: measure of a singularity below which a path of the tool is a finding: there a controller turns
#: joints at their largest speed
_NEAR = 0.02
_PATHS = frozenset(
    {
        *("movel", "movec", "move_circle", "move_spiral", "spline", "spline_op"),
        *("tcp_move", "tcp_move_2p", "wobj_move", "wobj_move_2p"),
        *("movel_eaxis", "movec_eaxis", "move_circle_eaxis"),
    }
)
_SINGULAR = ("shoulder", "elbow", "wrist")


@dataclass(frozen=True, slots=True)
class Margin:
    """The smallest distance of the whole run from one kind of limit.

    Attributes:
        of: kind of limit: "joint limit", "speed", "singularity" or "obstacle".
        what: name of the joint, the singularity or the bodies.
        value: the distance; for a speed, the remaining share of the limit.
        unit: unit of the value; "" for a share.
        time: the program's time [s].
        file, line: the program's line that moved the arm then; "" and 0 if it is not known.
    """

    of: str
    what: str
    value: float
    unit: str
    time: float
    file: str
    line: int

    def __str__(self) -> str:
        shown = f"{self.value:.0%}" if not self.unit else f"{self.value:.3f} {self.unit}"
        where = f", line {self.line}" if self.line else ""
        return f"{self.of}: {shown} ({self.what}) at {self.time:.2f} s{where}"

    def as_json(self) -> dict[str, Any]:
        """The margin as values for JSON."""
        return asdict(self)


def near_singularities(
    run: Mapping[str, Any], samples: Mapping[str, NDArray[np.float64]], model: str
) -> tuple[PreflightFinding, ...]:
    """Find the straight and round paths of the tool that pass close to a singularity.

    Args:
        run: recorded data of the run.
        samples: positions of the arm.
        model: name of the arm.
    """
    times, q = samples["time"], samples["q"]
    if not len(times):
        return ()
    values = np.abs(singular_values(arm_of(model).geometry, q))
    nearest: dict[int, tuple[float, int, Mapping[str, Any]]] = {}
    for sample in np.flatnonzero(values.min(axis=1) < _NEAR).tolist():
        call = running(run["calls"], float(times[sample]))
        if call is None or call["name"] not in _PATHS or call["ended"] < times[sample]:
            continue
        value = float(values[sample].min())
        if value < nearest.get(call["task"], (_NEAR,))[0]:
            nearest[call["task"]] = value, sample, call
    found = []
    for value, sample, call in nearest.values():
        kind = _SINGULAR[int(values[sample].argmin())]
        text = f"{call['text']} passes the {kind} singularity at {value:.3f} of 1"
        at = float(times[sample])
        found.append(PreflightFinding("singularity", text, at, **call["where"], sample=sample))
    return tuple(found)


def margins(
    run: Mapping[str, Any], samples: Mapping[str, NDArray[np.float64]], model: str, world: World
) -> tuple[Margin, ...]:
    """Find the smallest margins of a run.

    Args:
        run: recorded data of the run.
        samples: "time", "q", "qd" and "positions" of the arm, a row for each sample.
        model: name of the arm.
        world: the arm in its scene.

    Returns:
        One margin of each kind; empty if the arm did not move.
    """
    times, q, qd = samples["time"], samples["q"], samples["qd"]
    if not len(times):
        return ()
    arm = arm_of(model)

    def made(of: str, what: str, value: float, unit: str, sample: int) -> Margin:
        time = float(times[sample])
        call = running(run["calls"], time)
        where = (call and call["where"]) or {"file": "", "line": 0}
        return Margin(of, what, float(value), unit, time, where["file"], where["line"])

    limits = np.minimum(q - arm.lower, np.array(arm.upper) - q)
    left = 1.0 - np.abs(qd) / np.array(arm.velocity)
    singular = np.abs(singular_values(arm.geometry, q))
    found = []
    for of, table, unit in (("joint limit", limits, "rad"), ("speed", left, "")):
        at, joint = divmod(int(table.argmin()), table.shape[1])
        found.append(made(of, f"joint {joint + 1}", table[at, joint], unit, at))
    at, kind = divmod(int(singular.argmin()), singular.shape[1])
    found.append(made("singularity", _SINGULAR[kind], singular[at, kind], "of 1", at))
    positions = samples["positions"]
    if len(positions) == len(times) and positions.shape[1] == world.model.nq:
        checker = CollisionChecker(copy.copy(world.model), 0.0)
        near, sample = Clearance(_FURTHEST), 0
        for n in np.unique(np.linspace(0, len(times) - 1, _LOOKS).astype(int)).tolist():
            checker.loose = positions[n, 6:]
            # The same distance as in a planning scene, without those between the arm's links.
            seen = checker.clearance(positions[n, :6], _FURTHEST, itself=False)
            near, sample = min((near, sample), (seen, n), key=lambda look: look[0].distance)
        if near.pair is not None:
            found.append(made("obstacle", " and ".join(near.pair), near.distance, "m", sample))
    return tuple(found)
