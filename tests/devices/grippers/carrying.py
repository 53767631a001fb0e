"""A box is gripped, lifted, carried and put down in the simulator.

Each trial has a seed, which chooses the gripper, the box (20 to 60 mm on each side, 0.05 to 1 kg)
and how far it lies off the middle of the fingers (5 mm, 6 degrees). The arm comes down by a line,
grips through the driver, over the wire, lifts the box by 150 mm, carries it 250 mm to the side and
puts it down. A trial has succeeded if the box was held all the way and lies within 10 mm of where
it should. Another box is too heavy for its force: it must stay where it is.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

import aioduco
from aioduco.devices.grippers import (
    DhGripper,
    DigitalGripper,
    PolledGripper,
    Robotiq,
    VacuumGripper,
    gripper_model,
)
from aioduco.errors import ObjectLost, TaskError, TaskUnknown
from aioduco.kinematics import arm
from aioduco.models.pose import Joints
from aioduco.robot import Robot
from aioduco.sim import Simulator
from aioduco.sim.scene import Box, Table

READY = Joints.deg(-25, 0, 90, 0, -90, 0)
GRIPPERS = ("robotiq_2f85", "robotiq_2f140", "dh_ag95", "parallel", "vacuum")
#: with this narrow boxes that tip over are not pushed into the table as hard as a collision [N]
GRIP = 45.0
UP, ASIDE, NEAR = 0.15, 0.25, 0.010
#: time-outs in simulated time, which flies while the arm moves, for some seconds each time
PATIENT: dict[str, Any] = {"heartbeat": 60.0, "call_timeout": 60.0, "lag_limit": None}
PATIENT |= {"loop_stall_limit": 60.0, "connect_timeout": 60.0}


class Trial(NamedTuple):
    """One trial.

    Attributes:
        seed: of what follows.
        gripper: which.
        size: of the box [m].
        mass: of the box [kg].
        lifted: whether the box was held, and higher, at the end of the way.
        error: how far it ended from where it should [m].
    """

    seed: int
    gripper: str
    size: tuple[float, float, float]
    mass: float
    lifted: bool
    error: float

    @property
    def succeeded(self) -> bool:
        """Whether it was carried, and lies where it should."""
        return self.lifted and self.error < NEAR


def driver(robot: Robot, name: str) -> PolledGripper:
    """The driver of a simulated gripper."""
    if name.startswith("robotiq"):
        return Robotiq.at_tool(robot, name, answer_timeout=30.0, timeout=60.0)
    if name.startswith("dh"):
        return DhGripper.at_tool(robot, name, answer_timeout=30.0, timeout=60.0)
    if name == "vacuum":
        return VacuumGripper(
            robot, 1, vacuum=1, blow_off=2, build_up=20.0, timeout=60.0, max_age=60.0
        )
    return DigitalGripper(
        robot, 1, holds=1, opened=2, shut=3, travel_time=20.0, timeout=60.0, max_age=60.0
    )


async def carry(
    seed: int, *, gripper: str | None = None, mass: float | None = None, force: float | None = None
) -> Trial:
    """Carry out one trial.

    Args:
        seed: of gripper, box and place.
        gripper: which; None for what the seed chooses.
        mass: of the box [kg]; None likewise.
        force: to grip with [N]; None for GRIP where it can be set.
    """
    random = np.random.default_rng(seed)
    name = GRIPPERS[int(random.integers(len(GRIPPERS)))] if gripper is None else gripper
    width, depth, height = random.uniform(0.02, 0.06, 3)
    drawn = float(random.uniform(0.05, 1.0))
    off = random.uniform(-0.005, 0.005, 2)
    weight = drawn if mass is None else mass
    least, most = gripper_model(name).force
    if force is None and least < most:
        force = GRIP
    flange = arm("gcr5_910").fkine(READY)
    x, y, z = flange[:3, 3]
    grip = gripper_model(name).length + (0.5 * height if name == "vacuum" else 0.0)
    rest = float(z) - 0.12 - grip
    yaw = math.atan2(flange[1, 1], flange[0, 1]) - 0.5 * math.pi + random.uniform(-0.1, 0.1)
    part = Box(
        at=(x + off[0], y + off[1], rest, 0.0, 0.0, yaw),
        size=(float(depth), float(width), float(height)),
        mass=weight,
        name="part",
    )
    table = Table(at=(x, 0.0, rest - 0.5 * height), size=(0.4, 1.2))
    async with (
        Simulator(speed=math.inf, joints=tuple(READY), scene=[table, part], gripper=name) as sim,
        aioduco.connect(sim.host, sim.port, clock=sim.clock, **PATIENT) as robot,
        driver(robot, name) as hand,
    ):
        await robot.bring_up()
        await hand.activate()
        await hand.open()
        above = await robot.state.get_tcp_pose()
        over = above.shifted(y=ASIDE)

        async def line(pose: aioduco.Pose, v: float = 0.25) -> None:
            await robot.motion.movel(pose, v=v, a=1.0)

        await line(above.shifted(z=-0.12))
        begin = sim.positions[-7:-4].copy()
        await hand.close(force=force)
        lifted = True
        try:
            async with hand.carrying():
                await line(above.shifted(z=UP - 0.12))
                await line(over.shifted(z=UP - 0.12))
                lifted = bool(sim.positions[-5] > begin[2] + 0.9 * UP)
        except TaskUnknown:
            raise
        except (ObjectLost, TaskError):  # it fell, or the arm felt a collision
            lifted = False
        else:
            await line(over.shifted(z=-0.118), v=0.1)
        await hand.open()
        end = sim.positions[-7:-4]
    error = float(np.linalg.norm(end - begin - (0.0, ASIDE, 0.0)))
    return Trial(seed, name, (float(depth), float(width), float(height)), weight, lifted, error)
