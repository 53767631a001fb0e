"""The tasks: scene, tool, goals, and the distance to a goal.

Places are those of the tool's tip or of a thing, in the world's frame [m]. Lengths suit an arm of
910 mm, and are scaled for other arms.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from aioduco.models.gripper_models import gripper_model
from aioduco.sim.scene import Box, Pad, Rod, Table, Thing

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    Vector = NDArray[np.float64]


TABLE = 0.1
"""Height of the table [m]."""

_ROD = 0.15  # distance from the flange to the tip [m]
_SIDE = 0.05  # edge length of the box [m]
_LOW = np.array((0.38, -0.22, TABLE + 0.005))
_HIGH = np.array((0.66, 0.22, TABLE + 0.25))


class TaskReading(NamedTuple):
    """State of arm and scene after a step.

    Attributes:
        q: joints [rad]. Shape (6,).
        qd: joint speeds [rad/s]. Shape (6,).
        tip: the tool's tip in the world [m]. Shape (3,).
        force: force on the tip, along the world's axes [N]; zeros if the task does not use it.
        holds: 1 if the gripper holds something, else 0.
        thing: pose of the thing to move: x, y, z [m], a quaternion; empty if there is none.
    """

    q: Vector
    qd: Vector
    tip: Vector
    force: Vector
    holds: float
    thing: Vector


class TaskSetup(NamedTuple):
    """Initial state of an episode.

    Attributes:
        things: poses of things in the scene [m, rad], by name.
        goal: the desired value of `ArmTask.achieved`.
    """

    things: Mapping[str, tuple[float, ...]]
    goal: Vector


class ArmTask(ABC):
    """One task. It has no state: the state of an episode is in the arm and in its goal.

    Args:
        scale: scale of all lengths; 1 for an arm of 910 mm.

    Attributes:
        low, high: corners of the space in which the tool's tip is kept [m]. Shape (3,) each.
        home: place of the tip at the start [m]. Shape (3,).
        tip: distance from the flange to the tip, along the flange's z axis [m].
    """

    #: count of numbers in a goal
    size: ClassVar[int] = 3
    #: distance to the goal below which the task has succeeded, in the goal's unit
    tolerance: ClassVar[float] = 0.02
    #: name of the thing to move; empty for nothing
    moved: ClassVar[str] = ""
    #: whether the force at the tip is observed
    feels: ClassVar[bool] = False
    #: gripper instead of the rod; the last number of an action opens and closes it
    gripper: ClassVar[str] = ""
    #: cycle of controller and physics [s]
    cycle: ClassVar[float] = 0.004

    def __init__(self, scale: float) -> None:
        self.scale = scale
        self.low: Vector = _LOW * scale
        self.high: Vector = _HIGH * scale
        self.home: Vector = np.array((0.5, 0.0, TABLE + 0.15)) * scale
        self.tip: float = _ROD * scale

    def scene(self) -> list[Thing]:
        """Things around the arm."""
        s = self.scale
        return [Table(at=(0.52 * s, 0.0, TABLE * s), size=(0.5 * s, 0.7 * s))]

    def tool(self) -> list[Thing] | None:
        """The tool at the flange: a rod without weight, whose round end is the tip."""
        if self.gripper:
            return None
        return [Rod(length=self.tip, radius=0.012 * self.scale)]

    @abstractmethod
    def begin(self, rng: np.random.Generator) -> TaskSetup:
        """Draw the initial state of an episode."""

    def achieved(self, reading: TaskReading) -> Vector:
        """The actual value, for comparison with the goal. Shape (size,)."""
        return reading.tip if not self.moved else reading.thing[:3]

    def distance(self, achieved: Vector, goal: Vector) -> Vector:
        """Distance to the goal, in the goal's unit. Shapes (..., size), (...,)."""
        distance: Vector = np.linalg.norm(np.subtract(achieved, goal), axis=-1)
        return distance

    def mark(self, goal: Vector) -> tuple[float, ...] | None:
        """Place at which the goal is drawn [m]; None to draw none."""
        return tuple(goal.tolist())

    def _place(self, rng: np.random.Generator, margin: float, z: float) -> Vector:
        """Draw a place on the table."""
        s = self.scale
        low, high = self.low[:2] + margin * s, self.high[:2] - margin * s
        return np.array((*rng.uniform(low, high), z * s))


class ReachTask(ArmTask):
    """Move the tip to a point in the air."""

    def begin(self, rng: np.random.Generator) -> TaskSetup:
        """Draw a point away from the tip."""
        while True:
            goal = rng.uniform(self.low + 0.02 * self.scale, self.high - 0.02 * self.scale)
            if np.linalg.norm(goal - self.home) > 0.08 * self.scale:
                return TaskSetup({}, goal)


class _WithBox(ArmTask):
    """A task with a box on the table, and a place for it."""

    moved = "box"

    def __init__(self, scale: float) -> None:
        super().__init__(scale)
        #: edge length of the box [m]
        self.side: float = _SIDE * scale

    def scene(self) -> list[Thing]:
        """A table, and a box on it."""
        s = self.scale
        side = self.side
        box = Box(
            at=(0.5 * s, 0.1 * s, TABLE * s + 0.5 * side),
            size=(side, side, side),
            mass=0.1,
            colour=(0.2, 0.45, 0.8),
            name="box",
        )
        return [*super().scene(), box]

    def _begin(self, rng: np.random.Generator, height: float) -> TaskSetup:
        on_table = TABLE + 0.5 * self.side / self.scale
        while True:
            box = self._place(rng, 0.07, on_table)
            goal = self._place(rng, 0.05, on_table + height)
            apart = np.linalg.norm(box[:2] - self.home[:2]) > 0.06 * self.scale
            if apart and np.linalg.norm(box - goal) > 0.08 * self.scale:
                return TaskSetup({"box": (*box.tolist(), 0.0, 0.0, 0.0)}, goal)


class PushTask(_WithBox):
    """Push a box across the table to a place."""

    def begin(self, rng: np.random.Generator) -> TaskSetup:
        """Draw the place of the box, and its goal."""
        return self._begin(rng, 0.0)


class PickPlaceTask(_WithBox):
    """Carry a box with a gripper to a place on the table or above it.

    Gripper and box are not scaled with the arm.
    """

    gripper = "parallel"
    cycle: ClassVar[float] = 0.002  # a grip is firmer in smaller steps

    def __init__(self, scale: float) -> None:
        super().__init__(scale)
        self.side = _SIDE
        self.tip: float = gripper_model(self.gripper).length
        self.low[2] = TABLE * scale + 0.015

    def begin(self, rng: np.random.Generator) -> TaskSetup:
        """Draw the place of the box, and its goal: on the table with a probability of 1/2."""
        return self._begin(rng, rng.uniform(0.03, 0.12) if rng.random() < 0.5 else 0.0)


class PressTask(ArmTask):
    """Press the tip onto a springy pad until it has a given force."""

    size: ClassVar[int] = 1
    tolerance: ClassVar[float] = 2.0
    feels = True

    def scene(self) -> list[Thing]:
        """A table, and a pad on a spring in its middle."""
        s = self.scale
        pad = Pad(at=(0.5 * s, 0.0, (TABLE + 0.06) * s), size=(0.12 * s, 0.12 * s, 0.02 * s),
                  stiffness=4000.0, name="pad")  # fmt: skip
        return [*super().scene(), pad]

    def begin(self, rng: np.random.Generator) -> TaskSetup:
        """Draw a force [N]."""
        return TaskSetup({}, rng.uniform(8.0, 40.0, 1))

    def achieved(self, reading: TaskReading) -> Vector:
        """The upward force on the tip [N]."""
        return reading.force[2:]

    def mark(self, goal: Vector) -> None:  # noqa: ARG002 - a force has no place
        """Draw no mark."""
        return


_TASKS: dict[str, Callable[[float], ArmTask]] = {
    "Reach": ReachTask,
    "Push": PushTask,
    "PickPlace": PickPlaceTask,
    "Press": PressTask,
}


def task_of(name: str, scale: float) -> ArmTask:
    """Return the task with a name."""
    return _TASKS[name](scale)
