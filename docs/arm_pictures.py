"""Draw the pictures of arms in `docs/scene.md` and `docs/planning.md`.

    python docs/arm_pictures.py               writes docs/images/scene.png and planning*.png
    python docs/arm_pictures.py FOLDER        writes there, and a picture of each of the arms

It needs the extras sim, plan and plot, and OpenGL.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image

from aioduco.cli.demo_plan import SIDE, A, V, obstacle
from aioduco.kinematics import arm as arm_of
from aioduco.kinematics import models
from aioduco.models.pose import Joints, Pose
from aioduco.planning import Planner, Scene
from aioduco.sim import Simulator
from aioduco.sim.scene import Box, Pad, Rod, Table, Thing
from aioduco.sim.view.camera import Camera

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Picture = NDArray[np.uint8]

IMAGES = Path(__file__).resolve().parent / "images"
MODEL = "gcr5_910"
#: the scene of docs/scene.md
AROUND: list[Thing] = [
    Table(at=(0.55, 0.0, 0.3), size=(0.5, 0.9)),
    Box(at=(0.6, 0.25, 0.35), size=(0.1, 0.1, 0.1), mass=0.5, colour=(0.8, 0.3, 0.2), name="part"),
    Pad(at=(0.5, -0.2, 0.33), stiffness=20_000.0),
]
PROBE = [Rod(length=0.12, radius=0.012, mass=0.2)]
#: joints that show each arm from the side, all of them bent [rad]
BENT = tuple(np.radians((-25.0, -20.0, 100.0, 15.0, -70.0, 0.0)).tolist())


def scene_picture() -> Picture:
    """A GCR5-910 with a probe over a table."""
    with Simulator(MODEL, scene=AROUND, tool=PROBE) as sim:
        camera = Camera(target=(0.35, 0.0, 0.3), distance=2.0, azimuth=2.5, elevation=-0.42)
        return sim.render(width=720, height=480, camera=camera)


def planning_pictures() -> dict[str, Picture]:
    """A way round a board, and the arm before and after it."""
    arm = arm_of(MODEL)
    scene = Scene(arm, [obstacle(arm)])
    above = Pose.from_matrix(arm.fkine(Joints(SIDE, 0.0, np.pi / 2, 0.0, -np.pi / 2, 0.0)))
    start = Joints.of(arm.ikine(above, (SIDE, 0.0, np.pi / 2, 0.0, -np.pi / 2, 0.0)))
    with Planner(scene) as planner:
        plan = planner.plan_blocking(start, Joints(start.j1 - 2.0 * SIDE, *start[1:]), v=V, a=A)
    camera = Camera(target=(0.3, 0.0, 0.4), distance=2.0, azimuth=2.8, elevation=-0.45)
    before, after = scene.pictures([plan.start, plan.end], camera=camera)
    shown = plan.picture(scene, camera=camera)
    return {"planning-before": before, "planning": shown, "planning-after": after}


def each_arm() -> dict[str, Picture]:
    """Every arm, with all its joints bent."""
    pictures = {}
    for model in models():
        with Simulator(model, joints=BENT) as sim:
            pictures[model] = sim.render(width=480, height=400)
    return pictures


def save(pictures: dict[str, Picture], folder: Path) -> None:
    """Write pictures as PNG files."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, picture in pictures.items():
        path = folder / f"{name}.png"
        Image.fromarray(picture).quantize(128).save(path, optimize=True)
        sys.stdout.write(f"written: {path}\n")


def main() -> None:
    """Draw the pictures."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    save({"scene": scene_picture()} | planning_pictures(), folder or IMAGES)
    if folder is not None:
        save(each_arm(), folder)


if __name__ == "__main__":
    main()
