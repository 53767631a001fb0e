"""The Gymnasium environment: actions, observations, rewards."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, Literal

import gymnasium
import numpy as np
from gymnasium import spaces

from aioduco._process.copying import Uncopied
from aioduco.errors import ParameterError, Unreachable
from aioduco.integrations.gym.arms import ControllerArm, PhysicsArm
from aioduco.integrations.gym.names import TASKS
from aioduco.integrations.gym.tasks import TaskReading, task_of
from aioduco.kinematics import arm as arm_of
from aioduco.models.numpy_on_use import number_array
from aioduco.models.rotation import transform
from aioduco.models.rules import is_whole
from aioduco.models.words import one_of
from aioduco.sim.simulator import READY
from aioduco.sim.view.camera import Camera, PictureMark

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]

_STEP = 0.015  # distance of the tip for the largest action [m]
_TURN = 0.04  # angle of a joint for the largest action [rad]
_JUMP = 0.5  # largest change of a joint between two targets; more is another configuration [rad]
_MOST = 1e6  # bound on the numbers of an observation, which Gymnasium requires
_REACH = 0.817  # reach of the arm that the lengths of the tasks suit [m]


class ArmEnv(Uncopied, gymnasium.Env[dict[str, Any], Any]):
    """A simulated arm with a task, in steps of 40 ms.

    An observation is a dict, as in environments with goals: "observation" (joints [rad], joint
    speeds [rad/s], the tip [m]; then, if the task uses them, the force at the tip [N], whether the
    gripper holds something, the thing's place [m] and quaternion, and the vector from the tip to
    the thing [m]), "achieved_goal",
    "desired_goal". Pictures are "pixels", with "joints" (positions and speeds).

    Args:
        task: "Reach", "Push", "PickPlace" or "Press".
        wire: whether to use the whole simulated controller.
        actions: "cartesian": step of the tip along x, y, z, where 1 is 15 mm for an arm of 910 mm,
            the tool upright; or "joints", where 1 is 0.04 rad. Targets outside the space of the
            task are not reached: cartesian ones are clipped to it, joint ones ignored. With a
            gripper there is one more number: above 0 it opens, below 0 it closes.
        observations: "state", "pixels", or "both".
        reward: "sparse": 0 at the goal, else -1; or "dense": minus the distance to the goal.
        model: the arm; `aioduco.kinematics.models()` lists them.
        size: height and width of pictures [pixels].
        camera: camera of the pictures; None for one in front of the table.
        render_mode: "rgb_array", for `render`; or None.

    Raises:
        ParameterError: an argument has another value.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 25}  # noqa: RUF012 - Gymnasium's

    _instead: ClassVar[str] = "call `gymnasium.make` there: a function that makes it can be pickled"
    _SHOWN: ClassVar[tuple[int, int]] = (480, 480)

    def __init__(
        self,
        task: str,
        *,
        wire: bool = False,
        actions: Literal["cartesian", "joints"] = "cartesian",
        observations: Literal["state", "pixels", "both"] = "state",
        reward: Literal["sparse", "dense"] = "sparse",
        model: str = "gcr5_910",
        size: tuple[int, int] = (84, 84),
        camera: Camera | None = None,
        render_mode: str | None = None,
    ) -> None:
        one_of("task", task, TASKS)
        one_of("actions", actions, ("cartesian", "joints"))
        one_of("observations", observations, ("state", "pixels", "both"))
        one_of("reward", reward, ("sparse", "dense"))
        if render_mode is not None:
            one_of("render_mode", render_mode, ("rgb_array",), besides="None")
        self.render_mode = render_mode
        self._arm = arm_of(model)
        scale = self._scale = self._arm.reach / _REACH
        self._task = task_of(task, scale)
        self._by_joints = actions == "joints"
        self._observed = observations
        self._dense = reward == "dense"
        self._size = _checked_size(size)
        self._camera = camera or Camera(
            target=(0.5 * scale, 0.0, 0.2 * scale), distance=0.95 * scale,
            azimuth=np.pi, elevation=-0.6,
        )  # fmt: skip
        self._upright = self._arm.fkine(np.array(READY))[:3, :3]
        self._home = self._joints(self._task.home, np.array(READY), None)
        self._backend: ControllerArm | PhysicsArm = (ControllerArm if wire else PhysicsArm)(
            self._arm, self._task, self._home
        )
        self._target, self._tip = self._home, self._task.home
        self._goal = np.zeros(self._task.size)
        self._begun = self._closed = False
        count = (6 if self._by_joints else 3) + bool(self._task.gripper)
        self.action_space: spaces.Space[Any] = spaces.Box(-1.0, 1.0, (count,), np.float32)
        self.observation_space: spaces.Space[Any] = spaces.Dict(self._spaces())

    def reset(
        self,
        *,
        seed: int | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin an episode; the same seed gives the same episode.

        Args:
            seed: as in Gymnasium.
            options: None, or empty: there are none.

        Raises:
            ParameterError: options were given; nothing was done.
        """
        if options:
            raise ParameterError("options", options, "None, or empty: there are no options")
        super().reset(seed=seed)
        setup = self._task.begin(self.np_random)
        self._goal = setup.goal
        self._target, self._tip = self._home, self._task.home
        self._closed = False
        self._backend.restart(setup.things)
        self._begun = True
        reading = self._backend.reading()
        return self._observation(reading), self._info(reading, "")

    def step(self, action: Any) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Advance by 40 ms.

        Args:
            action: numbers from -1 to 1; others are clipped.

        Returns:
            Observation, reward, whether the arm was stopped, False, and a dict: "is_success" and,
            if the arm was stopped, the reason as "stopped".

        Raises:
            ParameterError: the action is not valid; nothing was done.
        """
        shape = self.action_space.shape
        given = number_array("action", action, f"numbers of the shape {shape}")
        if given.shape != shape:
            raise ParameterError("action", action, f"numbers of the shape {shape}")
        self._require_episode()
        self._aim(np.clip(given, -1.0, 1.0))
        if self._task.gripper and given[-1]:
            self._closed = bool(given[-1] < 0.0)
        stopped = self._backend.follow(self._target, closed=self._closed)
        reading = self._backend.reading()
        info = self._info(reading, stopped)
        achieved = self._task.achieved(reading)
        reward = float(self.compute_reward(achieved, self._goal, info))
        return self._observation(reading), reward, bool(stopped), False, info

    def compute_reward(self, achieved_goal: Any, desired_goal: Any, info: Any) -> Any:  # noqa: ARG002 - as environments with goals have it
        """Compute the reward for achieved goals, also for many steps at once.

        Args:
            achieved_goal: shape (..., n).
            desired_goal: shape (..., n).
            info: infos of the steps; not used.

        Returns:
            Shape (...,).
        """
        distance = self._task.distance(np.asarray(achieved_goal), np.asarray(desired_goal))
        if self._dense:
            return -distance
        return np.where(distance < self._task.tolerance, 0.0, -1.0)

    def render(self) -> Any:
        """Draw the arm and its goal: red, green, blue. Shape (480, 480, 3).

        Raises:
            RenderError: this computer has no OpenGL for drawing off screen.
        """
        if self.render_mode is None:
            raise RuntimeError('nothing is drawn: make it with render_mode="rgb_array"')
        self._require_episode()  # or, after close(), a process that nothing ends would draw
        return self._picture(self._SHOWN)

    def close(self) -> None:
        """Release all resources."""
        self._begun = False
        self._backend.close()

    # -- inside --------------------------------------------------------------------------------

    def _require_episode(self) -> None:
        if not self._begun:
            raise RuntimeError("there is no episode: call reset() first")

    def _aim(self, action: Vector) -> None:
        """Set the target; outside the task's space, clip it (cartesian) or ignore it (joints)."""
        task, arm = self._task, self._arm
        if self._by_joints:
            q = np.clip(self._target + _TURN * action[:6], arm.lower, arm.upper)
            flange = arm.fkine(q)
            tip = flange[:3, 3] + task.tip * flange[:3, 2]
            if ((tip >= task.low) & (tip <= task.high)).all():
                self._target, self._tip = q, tip
            return
        tip = np.clip(self._tip + _STEP * self._scale * action[:3], task.low, task.high)
        try:
            self._target = self._joints(tip, self._target, _JUMP)
        except Unreachable:
            return
        self._tip = tip

    def _joints(self, tip: Vector, near: Vector, most: float | None) -> Vector:
        flange = transform(self._upright, tip - self._task.tip * self._upright[:, 2])
        return self._arm.ikine(flange, near, max_jump=most)

    def _observation(self, reading: TaskReading) -> dict[str, Any]:
        found: dict[str, Any] = {}
        if self._observed != "pixels":
            found["observation"] = self._state(reading)
            found["achieved_goal"] = np.array(self._task.achieved(reading))
            found["desired_goal"] = self._goal.copy()
        if self._observed != "state":
            found["joints"] = np.concatenate([reading.q, reading.qd])
            found["pixels"] = self._picture(self._size)
        return found

    def _state(self, reading: TaskReading) -> Vector:
        parts = [reading.q, reading.qd, reading.tip]
        if self._task.feels:
            parts.append(reading.force)
        if self._task.gripper:
            parts.append(np.array((reading.holds,)))
        if self._task.moved:
            parts += [reading.thing, reading.thing[:3] - reading.tip]
        return np.concatenate(parts)

    def _spaces(self) -> dict[str, spaces.Space[Any]]:
        task = self._task

        def numbers(count: int) -> spaces.Box:
            return spaces.Box(-_MOST, _MOST, (count,), np.float64)

        found: dict[str, spaces.Space[Any]] = {}
        if self._observed != "pixels":
            count = 15 + 3 * task.feels + bool(task.gripper) + 10 * bool(task.moved)
            found["observation"] = numbers(count)
            found["achieved_goal"] = found["desired_goal"] = numbers(task.size)
        if self._observed != "state":
            found["joints"] = numbers(12)
            found["pixels"] = spaces.Box(0, 255, (*self._size, 3), np.uint8)
        return found

    def _info(self, reading: TaskReading, stopped: str) -> dict[str, Any]:
        distance = self._task.distance(self._task.achieved(reading), self._goal)
        info: dict[str, Any] = {"is_success": bool(distance < self._task.tolerance)}
        if stopped:
            info["stopped"] = stopped
        return info

    def _picture(self, size: tuple[int, int]) -> Any:
        at = self._task.mark(self._goal)
        marks = () if at is None else (PictureMark(at=at, radius=0.015 * self._scale),)
        return self._backend.picture(size[1], size[0], self._camera, marks)


def _checked_size(size: object) -> tuple[int, int]:
    """Height and width of pictures, if they are that."""
    numbers = tuple(np.atleast_1d(size)) if isinstance(size, (tuple, list, np.ndarray)) else ()
    if len(numbers) != 2 or not all(is_whole(n) and n > 0 for n in numbers):
        raise ParameterError("size", size, "height and width, two whole numbers above 0 [pixels]")
    return int(numbers[0]), int(numbers[1])
