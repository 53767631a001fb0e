"""How far the arm is from what stands around it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from aioduco.models.rotation import Array
    from aioduco.sim.physics.world import World

    mujoco: Any  # its bindings are compiled, without types
else:
    import mujoco

__all__ = ["ArmDistance", "Nearest"]

#: what is further away than this is not looked at [m]
FARTHEST = 0.5


class Nearest(NamedTuple):
    """The smallest distance of the arm.

    Attributes:
        distance: between the two [m]; at most `FARTHEST`, negative where they overlap.
        body: what of the arm, or "".
        other: what of the scene, or "".
    """

    distance: float
    body: str
    other: str


class ArmDistance:
    """Distances between the moving parts of an arm, with what it carries, and all else.

    Args:
        world: the arm in its scene; its state is left alone.
    """

    def __init__(self, world: World) -> None:
        model = self._model = world.model
        self._data: Any = mujoco.MjData(model)
        self._world = world
        root, turning = model.body("base").id, model.body("link1").id
        arm, rest = [], []
        for geom in range(model.ngeom):
            body = int(model.geom_bodyid[geom])
            if not (model.geom_contype[geom] or model.geom_conaffinity[geom]):
                continue
            if int(model.body_rootid[body]) != root:
                rest.append(geom)
            elif body not in (root, turning):  # which stay where they are
                arm.append(geom)
        self._pairs = [(one, other) for one in arm for other in rest]

    def at(self, positions: Array) -> Nearest:
        """The smallest distance at some positions, as `Simulator.positions` gives them."""
        model, data = self._model, self._data
        data.qpos[:] = positions
        mujoco.mj_kinematics(model, data)
        nearest, which = FARTHEST, (-1, -1)
        for one, other in self._pairs:
            distance = mujoco.mj_geomDistance(model, data, one, other, nearest, None)
            if distance < nearest:
                nearest, which = distance, (one, other)
        if which[0] < 0:
            return Nearest(FARTHEST, "", "")
        return Nearest(float(nearest), *(self._world.called(geom) for geom in which))
