"""Loose things of a scene: where they are, and changes to them while the simulation runs."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from aioduco.errors import ParameterError
from aioduco.models.pose import Pose
from aioduco.models.rotation import Array, matrix_from_quaternion, quaternion_from_matrix, transform

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from aioduco.sim.physics.gripper import Hand

    mujoco: Any  # its bindings are compiled, without types
else:
    import mujoco


MOST_STUCK = 12
"""Largest number of loose things of which any two can be stuck together."""


_STUCK = "stuck: "  # begins the names of what `add_welds` adds


class PartPlace(NamedTuple):
    """Where a loose thing of the scene is.

    Attributes:
        pose: its pose in the world [m, rad].
        held: whether the gripper holds it.
        touches: what it touches, such as "the floor" or "tray"; empty if it hangs in the air.
    """

    pose: Pose
    held: bool
    touches: tuple[str, ...]


def pose_of(position: Array) -> Pose:
    """Give the pose of a thing from its part of `World.positions`: see `World.place`."""
    return Pose.from_matrix(transform(matrix_from_quaternion(position[3:]), position[:3]))


def add_welds(spec: Any) -> None:
    """Prepare a specification so that any two of its loose things can be stuck together."""
    free = [body.name for body in spec.bodies if _is_free(body)]
    if len(free) > MOST_STUCK:
        return
    for one, other in combinations(free, 2):
        spec.add_equality(
            name=_weld(one, other), type=mujoco.mjtEq.mjEQ_WELD,
            objtype=mujoco.mjtObj.mjOBJ_BODY, name1=one, name2=other, active=False,
        )  # fmt: skip


def _is_free(body: Any) -> bool:
    return bool(body.name) and any(each.type == mujoco.mjtJoint.mjJNT_FREE for each in body.joints)


def _weld(one: str, other: str) -> str:
    return f"{_STUCK}{one} {other}"


class Parts:
    """The loose things of a compiled model.

    `where` and `place` may be called from any thread, all else on the world's thread alone.

    Args:
        model, data: MuJoCo model, of which `add_welds` has prepared the specification, and data.
        hand: the gripper; None for none.
        label: gives the name of a geom, for messages.
    """

    def __init__(
        self, model: Any, data: Any, hand: Hand | None, label: Callable[[int], str]
    ) -> None:
        self._model, self._data, self._hand, self._label = model, data, hand, label
        self._joints = {
            model.body(int(model.jnt_bodyid[i])).name.removeprefix("scene/"): i
            for i in range(model.njnt)
            if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_FREE
        }

        #: which equalities are those of `add_welds`
        self._between_parts: NDArray[np.bool_] = np.array(
            [model.equality(i).name.startswith(_STUCK) for i in range(model.neq)], dtype=bool
        )

    @property
    def names(self) -> list[str]:
        """The names, in the order of the scene."""
        return list(self._joints)

    def place(self, name: str) -> slice:
        """Find a thing in the positions: x, y, z [m], a quaternion.

        Raises:
            ParameterError: there is no such thing.
        """
        start = int(self._model.jnt_qposadr[self._joint(name)])
        return slice(start, start + 7)

    def where(self, name: str, positions: Array) -> PartPlace:
        """Say where a thing is, at positions of everything that moves."""
        at = positions[self.place(name)]
        data = mujoco.MjData(self._model)
        data.qpos[:] = positions
        mujoco.mj_forward(self._model, data)
        body = self._body(name)
        touched, by_gripper = set(), False
        for pair in data.contact.geom.tolist():
            mine = [int(self._model.geom_bodyid[geom]) == body for geom in pair]
            if mine[0] != mine[1]:
                other = pair[0] if mine[1] else pair[1]
                touched.add(self._label(other))
                by_gripper = by_gripper or (self._hand is not None and self._hand.is_pad(other))
        held = by_gripper and self._hand is not None and self._hand.reading.caught == 1
        return PartPlace(pose_of(at), held, tuple(sorted(touched)))

    def put(self, name: str, pose: Pose) -> None:
        """Put a thing at a pose in the world, at rest; it sticks to nothing any more.

        Raises:
            ParameterError: there is no such thing.
        """
        body = self._body(name)
        mine = (self._model.eq_obj1id == body) | (self._model.eq_obj2id == body)
        self._data.eq_active[mine & self._between_parts] = False
        rotation = quaternion_from_matrix(pose.matrix[:3, :3])
        self._data.qpos[self.place(name)] = [*pose[:3], *rotation]
        start = int(self._model.jnt_dofadr[self._joint(name)])
        self._data.qvel[start : start + 6] = 0.0

    def mass(self, name: str) -> float:
        """Give a thing's mass [kg].

        Raises:
            ParameterError: there is no such thing.
        """
        return float(self._model.body_mass[self._body(name)])

    def set_mass(self, name: str, mass: float) -> None:
        """Give a thing another mass [kg]; its inertia grows with it."""
        body = self._body(name)
        self._model.body_inertia[body] *= mass / self._model.body_mass[body]
        self._model.body_mass[body] = mass
        # Computes what depends on the masses; it leaves the data that it gets at the zero pose.
        mujoco.mj_setConst(self._model, mujoco.MjData(self._model))

    def weld_of(self, one: str, other: str) -> int:
        """Find what can stick two things together.

        Raises:
            ParameterError: there is no such thing, or there are too many.
        """
        kind, bodies = mujoco.mjtObj.mjOBJ_EQUALITY, [self._body(name) for name in (one, other)]
        first, second = (self._model.body(body).name for body in bodies)
        found = max(
            mujoco.mj_name2id(self._model, kind, _weld(*pair))
            for pair in ((first, second), (second, first))
        )
        if found < 0:
            raise ParameterError(
                "other", other, f"another thing, of at most {MOST_STUCK} that may move"
            )
        return int(found)

    def stick(self, weld: int, *, stuck: bool) -> None:
        """Stick two things together as they lie, or part them.

        Args:
            weld: from `weld_of`.
            stuck: whether they stick.
        """
        model, data = self._model, self._data
        # After a step, and after `put`, the frames are those of before.
        mujoco.mj_kinematics(model, data)
        first, second = int(model.eq_obj1id[weld]), int(model.eq_obj2id[weld])
        turns = [data.xmat[body].reshape(3, 3) for body in (first, second)]
        model.eq_data[weld, :3] = 0.0
        model.eq_data[weld, 3:6] = turns[0].T @ (data.xpos[second] - data.xpos[first])
        model.eq_data[weld, 6:10] = quaternion_from_matrix(turns[0].T @ turns[1])
        data.eq_active[weld] = stuck

    def _joint(self, name: str) -> int:
        if not isinstance(name, str) or name not in self._joints:
            names = sorted(self._joints)
            raise ParameterError("name", name, f"one of the things that may move: {names}")
        return self._joints[name]

    def _body(self, name: str) -> int:
        return int(self._model.jnt_bodyid[self._joint(name)])
