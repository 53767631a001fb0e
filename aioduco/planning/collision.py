"""Collision checks of an arm in its scene, by MuJoCo and the simulator's model of the arm."""

from __future__ import annotations

import contextlib
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.models.rotation import quaternion_from_matrix, transform
from aioduco.planning.clearance import FURTHEST, Clearance
from aioduco.sim.physics.model import assemble, mjcf, part

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.models.pose import Pose

    Vector = NDArray[np.float64]

    mujoco: Any  # its bindings are compiled, without types
else:
    import mujoco


_PREFIXES = ("scene/", "tool/")
PART = "/\x01"
"""Between the name of a body and what tells its parts apart; no name has it."""
#: what the arm stands on; a scene's plane "floor" replaces the arm's
_STANDS_ON = ("floor", "scene/floor", "plate", "pedestal")
_THING, _ARM, _FLOOR = 1, 2, 4  # bits of what may touch
_CONTACT, _MEMORY = 1024, 2**24  # for one contact, and for all else; used only if needed [bytes]
_SHARE = 0.9  # of the distance at an end that is kept near it
_BESIDE = 0.01  # from an end, up to which no more is kept than there [m of the furthest point]
_ROUNDING = 1e-7  # by which a distance at an end may be exceeded all the same [m]


def specification(
    arm: Arm,
    mounting: Pose,
    *,
    pedestal: bool,
    around: str | None,
    tool: str | None,
    things: str,
    attached: Mapping[str, NDArray[np.float64]],
    allowed: Iterable[tuple[str, str]],
) -> Any:
    """Build MuJoCo's specification of an arm with its scene.

    Args:
        arm: the arm.
        mounting: pose of its base in the world.
        pedestal: whether it stands on a column there.
        around: scene as MJCF, or a file of it.
        tool: what the flange carries, likewise.
        things: more of the scene, as MJCF.
        attached: poses in the flange's frame of the bodies of the scene that it holds, by name.
            Shape (4, 4) each.
        allowed: pairs of bodies that may touch.

    Raises:
        SceneError: MuJoCo rejects the scene, or there is no such body.
    """
    spec = assemble(mjcf(arm, 0.001, mounting, pedestal=pedestal), around, tool)
    spec.attach(part("scene", things, spec), prefix="scene/", frame=spec.worldbody.add_frame())
    spec.copy_during_attach = True
    for name, place in attached.items():
        body = spec.body(f"scene/{name}")
        held = spec.body("flange").add_frame().attach_body(body, "held/", "")
        spec.delete(body)
        for joint in list(held.joints):
            spec.delete(joint)
        held.name = f"scene/{name}"
        held.pos, held.quat = place[:3, 3], quaternion_from_matrix(place[:3, :3])
        for carried in held.find_all(mujoco.mjtObj.mjOBJ_BODY):
            carried.name = carried.name.removeprefix("held/")
    _name_parts(spec)
    beside = ["link5", "link6", *(["tool"] if tool is not None else [])]
    touching = [(f"scene/{name}", other) for name in attached for other in beside]
    if tool is not None:
        touching.append(("tool", "link6"))
    for pair in (*touching, *allowed):
        for one, other in product(*(_parts(spec, _body(spec, name)) for name in pair)):
            spec.add_exclude(bodyname1=one, bodyname2=other)
    # Pairs touch whatever the geoms' bits and margins say: things on one another would collide.
    for pair in list(spec.pairs):
        spec.delete(pair)
    # With too little memory MuJoCo leaves contacts out, so that what is nearest may be missing.
    moving = len(spec.body("base").find_all(mujoco.mjtObj.mjOBJ_GEOM))
    spec.memory = _MEMORY + _CONTACT * moving * len(spec.geoms)
    return spec


def _name_parts(spec: Any) -> None:
    """Name what MuJoCo leaves out of a contact by its body's name alone.

    The floor becomes a body: with the world, all that stands in it without a body would be left
    out. Bodies without a name are parts of the one that carries them.
    """
    floor = spec.geom("scene/floor") or spec.geom("floor")
    if floor is not None and floor.parent.name == "world":
        alone = spec.worldbody.add_body(name="floor")
        same = ("type", "size", "pos", "quat", "material", "rgba", "group", "contype",
                "conaffinity", "meshname", "hfieldname")  # fmt: skip
        values = {each: getattr(floor, each) for each in same}
        name = floor.name
        spec.delete(floor)
        alone.add_geom(name=name, **values)
    for number, body in enumerate(spec.bodies):
        if not body.name and body.parent.name not in ("", "world"):
            body.name = f"{body.parent.name}{PART}{number}"


def _parts(spec: Any, name: str) -> list[str]:
    """The names of a body and of its parts; of a tool, all of its bodies."""
    body = spec.body(name)
    if body is None:  # a floor that is a geom of another body
        return []
    inside = body.find_all(mujoco.mjtObj.mjOBJ_BODY)
    return [name, *(b.name for b in inside if b.name.startswith(f"{name}/"))]


def _body(spec: Any, name: str) -> str:
    return next((f"{p}{name}" for p in ("", *_PREFIXES) if spec.body(f"{p}{name}")), name)


class CollisionChecker:
    """Tells whether an arm in a configuration touches its scene or itself. For use in one thread.

    Args:
        model: MuJoCo model of a `specification`; it is modified.
        padding: distance below which bodies count as touching [m].
        positions: positions of the loose things in the scene; None for where they were put.

    Attributes:
        radii: how far a turn of each joint can move a point, at most [m/rad]. Shape (6,).
        count: number of configurations that were checked.
    """

    def __init__(self, model: Any, padding: float, positions: Vector | None = None) -> None:
        self._model, self._data = model, mujoco.MjData(model)
        if positions is not None:
            self.loose = positions
        self._qpos: Vector = self._data.qpos[:6]
        arm = {model.body(name).id for name in ("base", *(f"link{i}" for i in range(1, 7)))}
        moving = np.array([belongs(model, body, arm) for body in range(model.nbody)])
        still = ~moving[model.geom_bodyid]
        solid = (model.geom_contype | model.geom_conaffinity).astype(bool)
        # Things of the scene are not checked against one another. Link 1 is not checked against
        # what the arm stands on: it turns above that at a constant height.
        model.geom_contype[still & solid], model.geom_conaffinity[still] = _THING, 0
        model.geom_contype[~still & solid] = _ARM
        model.geom_conaffinity[~still & solid] = _ARM | _THING | _FLOOR
        for geom in range(model.ngeom):
            if model.geom(geom).name in _STANDS_ON:
                model.geom_contype[geom], model.geom_conaffinity[geom] = _FLOOR, 0
            elif model.geom_bodyid[geom] == model.body("link1").id:
                model.geom_conaffinity[geom] &= ~_FLOOR
        self._moves = ~still
        self.radii: Vector = _radii(model)
        self.count: int = 0
        self._ends: Vector | None = None
        self._kept: Vector = np.zeros(0)
        self._growth = 0.0
        self.padding = padding

    @property
    def padding(self) -> float:
        """Distance below which bodies count as touching [m]."""
        return self._padding

    @padding.setter
    def padding(self, padding: float) -> None:
        self._padding = padding
        self._ends = None
        self._within(padding)

    def ease(self, ends: Iterable[tuple[Vector, float]], growth: float) -> None:
        """Reduce the padding near configurations that are closer to something, until it is set.

        Beside such an end nine tenths of its distance are enough, further on more: a path may begin
        and end where the arm is close to something, and keeps all of the padding elsewhere.

        Args:
            ends: configurations [rad], shape (6,), each with its distance to the nearest thing [m].
            growth: increase of the distance that is kept, on the way from an end, as a share of
                how far a point of the arm moves at most; 0 for the same along the whole path.
        """
        near = [(q, distance) for q, distance in ends if _SHARE * distance < self._padding]
        self._ends = np.array([q for q, _ in near]) * self.radii if near else None
        self._kept = np.array([min(_SHARE * each, each - _ROUNDING) for _, each in near])
        self._growth = growth

    def kept(self, q: Any) -> float:
        """Distance below which bodies count as touching in a configuration [m].

        Args:
            q: six joint angles [rad].
        """
        if self._ends is None:
            return self._padding
        away = np.abs(self._ends - np.asarray(q) * self.radii).sum(axis=1)
        kept = self._kept + self._growth * np.maximum(away - _BESIDE, 0.0)
        return min(self._padding, float(kept.min()))

    def free(self, q: Any) -> bool:
        """Tell whether the arm is further than the padding from everything, itself included.

        Args:
            q: six joint angles [rad]: an array, or anything with an index.
        """
        if self._nothing_near(q):
            return True
        return self._ends is not None and self._nearest() > self.kept(q)

    def _nothing_near(self, q: Any) -> bool:
        model, data, qpos = self._model, self._data, self._qpos
        for joint in range(6):
            qpos[joint] = q[joint]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        self.count += 1
        return not data.ncon

    @contextlib.contextmanager
    def looking_within(self, within: float) -> Iterator[Callable[[Any], float]]:
        """Give a fast function for distances alone.

        Args:
            within: largest distance that is measured [m].

        Returns:
            A function that takes six joint angles [rad] and gives the distance of the arm from the
            nearest thing, at most `within` [m].
        """

        def distance(q: Any) -> float:
            return within if self._nothing_near(q) else self._nearest()

        self._within(within)
        try:
            yield distance
        finally:
            self._within(self._padding)

    @property
    def loose(self) -> Vector:
        """Positions of the loose things in the scene."""
        found: Vector = self._data.qpos[6:]
        return found

    @loose.setter
    def loose(self, positions: Vector) -> None:
        self._data.qpos[6:] = positions

    def clearance(self, q: Vector, within: float = FURTHEST, *, itself: bool = True) -> Clearance:
        """Tell how far the arm is from the nearest thing, and which two bodies that are.

        Args:
            q: joint angles [rad]. Shape (6,).
            within: largest distance that is measured [m].
            itself: whether distances between parts of the arm count too.
        """
        self._within(within)
        try:
            if self._nothing_near(q):
                return Clearance(within)
            contact = self._data.contact
            distances, geoms = contact.dist, contact.geom
            if not itself:
                distances = np.where(self._moves[geoms].all(axis=1), within, distances)
            nearest = int(np.argmin(distances))
            if distances[nearest] >= within:
                return Clearance(within)
            pair = sorted(geoms[nearest].tolist(), key=lambda geom: not self._moves[geom])
            one, other = (self._name(geom) for geom in pair)
            x, y, z = contact.pos[nearest].tolist()
            return Clearance(float(distances[nearest]), (one, other), (x, y, z))
        finally:
            self._within(self._padding)

    def place(self, q: Vector, name: str) -> NDArray[np.float64]:
        """Give the pose of a body in the flange's frame.

        Args:
            q: joint angles [rad]. Shape (6,).
            name: name of a thing in the scene.

        Returns:
            Shape (4, 4).
        """
        self._qpos[:] = q
        mujoco.mj_kinematics(self._model, self._data)
        body = self._data.body(f"scene/{name}")
        flange = self._data.site("flange")
        turn = flange.xmat.reshape(3, 3).T
        return transform(turn @ body.xmat.reshape(3, 3), turn @ (body.xpos - flange.xpos))

    def _nearest(self) -> float:
        return float(self._data.contact.dist.min())

    def _within(self, distance: float) -> None:
        # MuJoCo adds the margins of two geoms; a body's margin is the largest of its geoms'.
        self._model.geom_margin[:] = self._model.body_margin[:] = 0.5 * distance

    def _name(self, geom: int) -> str:
        model = self._model
        body = int(model.geom_bodyid[geom])
        name = str(model.body(body).name if body else model.geom(geom).name)
        while body and not name:
            body = int(model.body_parentid[body])
            name = str(model.body(body).name)
        if model.geom(geom).name in ("plate", "pedestal"):
            name = str(model.geom(geom).name)
        if name.startswith("tool/"):
            return "tool"
        return name.removeprefix("scene/").partition(PART)[0] or "a thing without a name"


def belongs(model: Any, body: int, others: set[int]) -> bool:
    """Whether a body is one of others, or is carried by one."""
    while body:
        if body in others:
            return True
        body = int(model.body_parentid[body])
    return False


def _radii(model: Any) -> Vector:
    """For each joint, an upper bound of the distance of the points that it moves from its axis."""
    furthest = np.zeros(model.nbody)
    for body in range(model.nbody - 1, 0, -1):
        first = int(model.body_geomadr[body])
        for geom in range(first, first + int(model.body_geomnum[body])):
            if model.geom_rbound[geom] > 0.0 and model.geom_conaffinity[geom]:
                away = float(np.linalg.norm(model.geom_pos[geom])) + model.geom_rbound[geom]
                furthest[body] = max(furthest[body], away)
        parent = int(model.body_parentid[body])
        reach = float(np.linalg.norm(model.body_pos[body])) + furthest[body]
        if furthest[body] > 0.0:
            furthest[parent] = max(furthest[parent], reach)
    return np.array([furthest[model.body(f"link{i}").id] for i in range(1, 7)])
