"""The plan that programs carry out, and the scene that they watch meanwhile.

    python -m hostile.freeze.planned FILE

It makes the plan once for all runs, and pickles it.
"""

from __future__ import annotations

import pickle
import sys
from pathlib import Path

from aioduco import Joints
from aioduco.planning import Plan, Planner, Scene
from aioduco.sim.scene import Box

from .cells import FAR, SPEED, turned

#: where the box is, far from the arm [m]
_AT = (3.0, 3.0, 0.5)


def scene() -> Scene:
    """A scene with a box that is never in the way."""
    return Scene("gcr5_910", [Box(at=_AT, size=(0.1, 0.1, 0.1), name="box")])


def change(seen: Scene, number: int) -> None:
    """Change the scene, so that who watches it checks the way again."""
    seen.move("box", (*_AT[:2], _AT[2] + number % 2))


def made() -> Plan:
    """Plan the whole way of joint 1."""
    with Planner(scene()) as planner:
        return planner.plan_blocking(Joints.of(turned(0.0)), Joints.of(turned(FAR)), v=SPEED, a=1.0)


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(pickle.dumps(made()))
