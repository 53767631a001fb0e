"""A planning scene: an arm, what it carries, and the things around it."""

from __future__ import annotations

import copy
import dataclasses
import itertools
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.errors import MissingExtra, ParameterError, SceneError
from aioduco.kinematics.catalogue import arm_given
from aioduco.models.pose import JointsLike, Pose, PoseLike
from aioduco.models.ranges import JOINTS
from aioduco.models.rules import Number
from aioduco.planning.clearance import FURTHEST, TOUCHING, Clearance
from aioduco.planning.problem import WorkerScene
from aioduco.planning.shapes import OWN_NAME, OWN_NAMES, Ground
from aioduco.sim.scene import MountingLike, SceneLike, Thing, mjcf_of, mounting_of

if TYPE_CHECKING:
    import os
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.planning.collision import CollisionChecker
    from aioduco.sim.simulator import Simulator
    from aioduco.sim.view.camera import Camera


_PADDING = Number(0.0005, 0.1, "m", source="this package")


class Scene:
    """An arm among things, for planning and for checks of plans (规划场景).

        scene = Scene("gcr5_910", [Box(at=(0.5, 0, 0.3), size=(0.04, 0.6, 0.6), name="wall")])
        scene.clearance(joints)

    Positions are in the world's frame, as in `aioduco.sim.scene`: z is up, the floor is at -0.01,
    and an arm on the floor has its base at the origin. Things stay where they are put; their masses
    have no effect. Several threads may use it at once.

    Args:
        model: the arm, such as "gcr5_910", or an `Arm`.
        things: what stands around it.
        around: more things: the path of an MJCF file, or MJCF as text.
        tool: what the flange carries, in its frame: things, or MJCF.
        mounting: where the base is: "floor", "wall", "ceiling", or a pose [m, rad].
        pedestal: height of a column under an arm on the floor [m].
        padding: distance that plans keep from everything [m], from 0.0005. It is reduced near the
            start and the goal of a plan if these are closer.

    Raises:
        ParameterError: there is no such model, or `padding` is out of range.
        SceneError: the mounting is not valid, or two things have the same name.
    """

    def __init__(
        self,
        model: str | Arm = "gcr5_910",
        things: Sequence[Thing] = (),
        *,
        around: str | os.PathLike[str] | None = None,
        tool: SceneLike | None = None,
        mounting: MountingLike = "floor",
        pedestal: float = 0.0,
        padding: float = 0.005,
    ) -> None:
        self.arm: Arm = arm_given("model", model)
        self.mounting: Pose = mounting_of(mounting, self.arm, pedestal)
        self.padding: float = _PADDING("padding", padding)
        self._pedestal = pedestal > 0.0
        self._around = None if around is None else mjcf_of(around)
        self._tool = None if tool is None else mjcf_of(tool, free=False)
        self._things: dict[str, Thing] = {}
        self._attached: dict[str, NDArray[np.float64]] = {}
        self._allowed: set[tuple[str, str]] = set()
        self._loose: NDArray[np.float64] | None = None
        self._model: Any = None
        self._checker: CollisionChecker | None = None
        self._revision = 0
        #: programs and executions of plans use the scene in other threads, too
        self._lock = threading.RLock()
        try:
            listed = [*things]
        except TypeError:
            raise SceneError(f"{things!r} is no list of things") from None
        self.add(*listed)

    @classmethod
    def from_simulator(cls, simulator: Simulator, *, padding: float = 0.005) -> Scene:
        """Give the scene of a running simulator: its loose things and gripper are as they are now.

        Args:
            simulator: the simulator; it is not changed.
            padding: distance that plans keep from everything [m].

        Raises:
            RuntimeError: it is not running.
        """
        tool = simulator.tool
        if simulator.gripper is not None:
            from aioduco.sim.physics.gripper import gripper_mjcf  # noqa: PLC0415 - for it alone

            tool = gripper_mjcf(simulator.gripper)
        scene = cls(simulator.arm, around=simulator.scene, mounting=simulator.mounting,
                    tool=tool, padding=padding)  # fmt: skip
        scene._pedestal = simulator.pedestal
        loose = simulator.positions[6:]
        scene._loose = loose if loose.size else None
        return scene

    def __repr__(self) -> str:
        held = f", holds {', '.join(self._attached)}" if self._attached else ""
        return f"<Scene of {self.arm.name} with {len(self._things)} things{held}>"

    def __getstate__(self) -> dict[str, Any]:
        # for a copy or a pickle: it changes by itself, and compiles its model when it needs it
        with self._lock:
            state = {**self.__dict__, "_model": None, "_checker": None}
            for name in ("_things", "_attached", "_allowed"):
                state[name] = state[name].copy()
        del state["_lock"]
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._lock = threading.RLock()

    def __iter__(self) -> Iterator[Thing]:
        return iter(self._things.values())

    def __getitem__(self, name: str) -> Thing:
        return self._things[name]

    def __contains__(self, name: object) -> bool:
        return name in self._things

    @property
    def revision(self) -> int:
        """Number of changes of the scene so far."""
        return self._revision

    @property
    def attached(self) -> tuple[str, ...]:
        """Names of the things that the flange holds."""
        return tuple(self._attached)

    # -- changes -------------------------------------------------------------------------------

    def add(self, *things: Thing) -> None:
        """Put things into the scene.

        Args:
            things: each with a name of its own; one without gets a number.

        Raises:
            SceneError: there is a thing of this name already, or it is that of a part of the arm;
                or an argument is not a thing.
        """
        with self._changing():
            named = dict(self._things)
            taken = {*named, *(thing.name for thing in things if isinstance(thing, Thing))}
            for thing in things:
                if not isinstance(thing, Thing):
                    raise SceneError(f"{thing!r} is no thing: give boxes, meshes, point clouds, …")
                numbers = map("thing{}".format, itertools.count(len(named) + 1))
                name = thing.name or next(each for each in numbers if each not in taken)
                taken.add(name)
                if name in named:
                    raise SceneError(f"there is a thing called {name!r} already; nothing was added")
                if name in OWN_NAMES:
                    raise SceneError(f"{OWN_NAME.format(name)}; nothing was added")
                named[name] = dataclasses.replace(thing, name=name)
            self._things = named

    def remove(self, name: str) -> None:
        """Remove a thing from the scene, also one that is held.

        Raises:
            SceneError: there is no thing of this name.
        """
        with self._changing():
            self._known(name)
            # another dict: a thread may be going through this one
            self._things = {own: thing for own, thing in self._things.items() if own != name}
            self._attached.pop(name, None)
            self._allowed = {pair for pair in self._allowed if name not in pair}

    def move(self, name: str, at: PoseLike) -> None:
        """Move a thing to another position.

        Args:
            name: name of the thing.
            at: x, y, z [m], or a pose of six numbers [m, rad].

        Raises:
            SceneError: there is no thing of this name.
        """
        with self._changing():
            self._things[name] = dataclasses.replace(self._known(name), at=at)
            self._attached.pop(name, None)

    def attach(self, name: str, joints: JointsLike) -> None:
        """Attach a thing to the flange where it is, as a closing gripper does.

        From now on the thing moves with the arm. It may touch the tool, the flange and the last
        two links.

        Args:
            name: name of the thing, also one of a simulator's scene.
            joints: configuration of the arm when it grips the thing [rad].

        Raises:
            SceneError: there is no thing of this name, it is a part of the arm, or a `Ground`.
            ParameterError: the configuration is not six joint angles, or out of range.
        """
        q = np.array(JOINTS("joints", joints))
        with self._changing():
            if isinstance(self._things.get(name), Ground):
                raise SceneError(f"{name!r} is a plane without an end: no flange can hold it")
            place = self._own.place(q, self._thing(name))
            self._loose = None if self._loose is None else self._loose_without(name)
            self._attached[name] = place

    def detach(self, name: str, joints: JointsLike) -> None:
        """Detach a thing from the flange; it stays where it is.

        Args:
            name: name of the held thing.
            joints: configuration of the arm when it releases the thing [rad].

        Raises:
            SceneError: nothing of this name is held, or the thing is from a simulator's scene.
            ParameterError: the configuration is not six joint angles, or out of range.
        """
        flange = self.mounting.matrix @ self.arm.fkine(np.array(JOINTS("joints", joints)))
        with self._changing():
            if name not in self._attached:
                held = ", ".join(self._attached)
                raise SceneError(f"nothing called {name!r} is held; held: {held}")
            thing = self._known(name)
            at = Pose.from_matrix(flange @ self._attached[name])
            self._things[name] = dataclasses.replace(thing, at=tuple(at))
            del self._attached[name]

    def allow(self, one: str, other: str) -> None:
        """Let two bodies touch, such as "tool" and a thing that it grasps.

        Args:
            one: name of a thing, "link1" to "link6", "flange", "tool", "base" or "floor".
            other: name of the other body, likewise.
        """
        with self._changing():
            self._allowed.add((self._body(one), self._body(other)))

    def forbid(self, one: str, other: str) -> None:
        """Undo `allow` for two bodies.

        Raises:
            SceneError: there is no body of one of the names.
        """
        with self._changing():
            pair = self._body(one), self._body(other)
            self._allowed -= {pair, pair[::-1]}

    # -- questions -----------------------------------------------------------------------------

    def clearance(self, joints: JointsLike) -> Clearance:
        """Tell how far the arm is from the nearest thing, itself included.

        Args:
            joints: joint angles [rad]. Shape (6,).

        Returns:
            The distance [m], below zero in a collision, and the names of the two bodies.

        Raises:
            SceneError: MuJoCo rejects the scene.
            ParameterError: the configuration is not six joint angles, or out of range.
        """
        return self._clearance(joints, FURTHEST)

    def collides(self, joints: JointsLike) -> bool:
        """Tell whether the arm collides with something, without padding.

        Bodies that touch within 0.001 mm, such as a part that stands on a table, do not collide.

        Args:
            joints: joint angles [rad]. Shape (6,).

        Raises:
            SceneError: MuJoCo rejects the scene.
            ParameterError: the configuration is not six joint angles, or out of range.
        """
        return self._clearance(joints, 1e-9).distance < -TOUCHING

    def picture(
        self,
        joints: JointsLike,
        *,
        width: int = 640,
        height: int = 480,
        camera: Camera | None = None,
    ) -> NDArray[np.uint8]:
        """Draw the arm in its scene, without a display.

        It blocks for some seconds, since a process is started that draws. In an async program:
        `await anyio.to_thread.run_sync(scene.picture, joints)`.

        Args:
            joints: joint angles [rad]. Shape (6,).
            width: width of the picture, at most 1920 [pixels].
            height: height of the picture, at most 1080 [pixels].
            camera: the camera; None for one that sees the whole arm.

        Returns:
            Red, green, blue. Shape (height, width, 3).

        Raises:
            RenderError: this computer has no OpenGL that draws off screen.
        """
        return next(self.pictures([joints], width=width, height=height, camera=camera))

    def pictures(
        self,
        configurations: Sequence[JointsLike],
        *,
        width: int = 640,
        height: int = 480,
        camera: Camera | None = None,
    ) -> Iterator[NDArray[np.uint8]]:
        """Draw several configurations, one after another, by one process: see `picture`."""
        shown = [JOINTS("joints", joints) for joints in configurations]
        spec = self._specification()
        from aioduco.sim.physics.model import dressed  # noqa: PLC0415 - for pictures alone
        from aioduco.sim.view.camera import towards  # noqa: PLC0415
        from aioduco.sim.view.render import PictureProcess  # noqa: PLC0415

        seen = towards(self.arm, self.mounting) if camera is None else camera
        model = dressed(spec, self.arm)
        studio = PictureProcess(lambda: model)
        try:
            for joints in shown:
                positions = np.concatenate([joints, self.loose])
                yield studio.picture(positions, width, height, seen)
        finally:
            studio.close()

    # -- inside --------------------------------------------------------------------------------

    def compiled(self) -> Any:
        """MuJoCo's model of the arm in its scene. Callers must not change it."""
        with self._lock:
            if self._model is None:
                spec = self._specification()
                from aioduco.sim.physics.model import compiled  # noqa: PLC0415

                self._model = compiled(spec)
            return self._model

    def _specification(self) -> Any:
        with MissingExtra.named("a planning scene", "plan"):
            from aioduco.planning.collision import specification  # noqa: PLC0415 - needs an extra

        with self._lock:
            return specification(
                self.arm,
                self.mounting,
                pedestal=self._pedestal,
                around=self._around,
                tool=self._tool,
                things=mjcf_of([*self._things.values()], free=False),
                attached=self._attached,
                allowed=sorted(self._allowed),
            )

    def checker(self) -> CollisionChecker:
        """Make a new collision checker of the scene as it is now, for one thread."""
        with self._lock:
            model = self.compiled()
            from aioduco.planning.collision import CollisionChecker  # noqa: PLC0415

            return CollisionChecker(copy.copy(model), self.padding, self.loose)

    def for_worker(self) -> tuple[int, WorkerScene]:
        """The scene as it is now for the process that plans, with its revision."""
        with self._lock:
            return self._revision, WorkerScene(self.compiled(), self.loose)

    def _clearance(self, joints: JointsLike, within: float) -> Clearance:
        """Measure the clearance up to a distance [m]."""
        q = np.array(JOINTS("joints", joints))
        with self._lock:
            return self._own.clearance(q, within)

    @property
    def _own(self) -> CollisionChecker:
        """The scene's own checker, until it changes. Used under the lock: it is for one thread."""
        if self._checker is None:
            self._checker = self.checker()
        return self._checker

    @property
    def loose(self) -> NDArray[np.float64]:
        """Positions of the loose things in a simulator's scene; empty if there are none."""
        if self._loose is not None:
            return self._loose
        rest: NDArray[np.float64] = np.array(self.compiled().qpos0[6:])
        return rest

    def _loose_without(self, name: str) -> NDArray[np.float64]:
        """Positions of the loose things once the flange holds one: without those of its own joints.

        What moves on the held things, such as a lid, comes first then, as in the compiled model.
        """
        from aioduco.planning.collision import belongs  # noqa: PLC0415 - needs an extra

        model, loose = self.compiled(), self._loose
        assert loose is not None
        flange, own = (model.body(body).id for body in ("flange", f"scene/{name}"))
        starts = [*model.jnt_qposadr.tolist(), model.nq]
        held: list[int] = []
        added: list[int] = []
        others: list[int] = []
        for joint in range(6, model.njnt):
            body = int(model.jnt_bodyid[joint])
            if body != own:
                carried = belongs(model, body, {own})
                part = held if belongs(model, body, {flange}) else added if carried else others
                part += range(starts[joint] - 6, starts[joint + 1] - 6)
        return loose[[*held, *added, *others]]

    def _known(self, name: str) -> Thing:
        if name not in self._things:
            own = ", ".join(self._things) or "none"
            raise SceneError(
                f"nothing is called {name!r} of what was added to this scene: {own}. A thing of a "
                "simulator's scene or of an MJCF file can be attached, but not moved or detached"
            )
        return self._things[name]

    def _thing(self, name: str) -> str:
        things = [each[len("scene/") :] for each in self._bodies() if each.startswith("scene/")]
        if name not in things:
            there = ", ".join(sorted(filter(None, things))) or "none"
            raise SceneError(f"nothing is called {name!r} of what the flange could hold: {there}")
        return name

    def _bodies(self) -> list[str]:
        model = self.compiled()
        from aioduco.planning.collision import PART  # noqa: PLC0415 - needs an extra

        names = [model.body(i).name for i in range(1, model.nbody)]
        return [name for name in names if PART not in name]

    def _body(self, name: str) -> str:
        names = self._bodies()
        known = {"floor", *names, *(each.partition("/")[2] for each in names)} - {""}
        if name not in known:
            raise SceneError(f"nothing is called {name!r}; there are {', '.join(sorted(known))}")
        return name

    @contextmanager
    def _changing(self) -> Iterator[None]:
        """For each change as a whole: what it is made from is that of no other thread's change.

        If the block raises, the scene is as before.
        """
        with self._lock:
            yield
            self._model = self._checker = None
            self._revision += 1


def require_scene(name: str, scene: object, arm: Arm) -> None:
    """Check that an argument is a scene of an arm.

    Args:
        name: the parameter's name.
        scene: the argument, of any type.
        arm: the arm.

    Raises:
        ParameterError: it is no scene, or that of another arm.
    """
    if not isinstance(scene, Scene) or scene.arm.name != arm.name:
        raise ParameterError(name, scene, f"a Scene of the plan's arm, {arm.name}")
