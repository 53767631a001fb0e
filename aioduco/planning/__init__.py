"""Plans of an arm through a scene, without a robot: needs `aioduco[plan]`.

    from aioduco.planning import Planner, Scene
    from aioduco.sim.scene import Box

    scene = Scene("gcr5_910", [Box(at=(0.5, 0, 0.3), size=(0.04, 0.6, 0.6), name="wall")])
    async with Planner(scene) as planner:
        plan = await planner.plan(start, goal, v=1.0, a=2.0)

It uses the kinematics, the simulator's physics and the streams' joint trajectories, but no robot:
`robot.motion.execute` carries out a plan.
"""

from __future__ import annotations

from aioduco.planning.motion_limits import MotionLimits
from aioduco.planning.plan import Plan, PlanCheck
from aioduco.planning.planner import Planner
from aioduco.planning.problem import Region
from aioduco.planning.scene import Scene
from aioduco.planning.shapes import Ground, Mesh, PointCloud

__all__ = [
    "Ground",
    "Mesh",
    "MotionLimits",
    "Plan",
    "PlanCheck",
    "Planner",
    "PointCloud",
    "Region",
    "Scene",
]
