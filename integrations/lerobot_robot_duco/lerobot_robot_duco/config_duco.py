"""What is chosen on LeRobot's command line; the names of the classes are those that it expects.

No postponed annotations here: LeRobot's parser reads the types of the fields.
"""

from dataclasses import dataclass, field

from lerobot.cameras import CameraConfig
from lerobot.configs.types import FeatureType, PolicyFeature
from lerobot.envs.configs import EnvConfig
from lerobot.robots import RobotConfig
from lerobot.teleoperators import TeleoperatorConfig
from lerobot.utils.constants import ACTION, OBS_ENV_STATE, OBS_IMAGE, OBS_STATE

from aioduco.errors import ParameterError
from aioduco.integrations.gym import TASKS
from aioduco.integrations.gym.names import EPISODE

__all__ = [
    "DucoConfig",
    "DucoEnvConfig",
    "DucoGamepadConfig",
    "DucoKeyboardConfig",
    "DucoLeaderConfig",
    "DucoSpaceMouseConfig",
]


@RobotConfig.register_subclass("duco")
@dataclass(kw_only=True)
class DucoConfig(RobotConfig):
    """A DUCO arm that follows joint angles.

    Attributes:
        host: name or address of the controller.
        port: its TCP port.
        v: largest speed of each joint [rad/s].
        a: largest acceleration of each joint [rad/s²].
        jerk: largest jerk of each joint [rad/s³].
        rate: set-points to the controller per second [Hz].
        hold: time without an action after which the arm is brought to rest [s]; the next action
            sets it going again.
        max_step: how far one action may be from the one before it [rad]; farther ones are cut.
        state_rate: samples of the state per second [Hz]; observations are the newest one.
        heartbeat: time without a sign of life of this program after which the controller stops
            the arm [s].
        timeout: most time for an answer of the controller [s].
        max_age: how old an observation may be [s]; an older one is an error.
        bring_up: whether connecting powers and enables the arm.
        record: a file to which the robot is recorded, such as run.mcap; empty for none.
        cameras: LeRobot's cameras, by name.
    """

    host: str
    port: int = 7003
    v: float = 1.0
    a: float = 5.0
    jerk: float = 50.0
    rate: float = 500.0
    hold: float = 0.5
    max_step: float = 0.05
    state_rate: float = 100.0
    heartbeat: float = 1.0
    timeout: float = 1.0
    max_age: float = 0.5
    bring_up: bool = True
    record: str = ""
    cameras: dict[str, CameraConfig] = field(default_factory=dict)


@TeleoperatorConfig.register_subclass("duco_leader")
@dataclass(kw_only=True)
class DucoLeaderConfig(TeleoperatorConfig):
    """A second DUCO arm whose joint angles are the actions.

    Attributes:
        host: name or address of its controller.
        port: its TCP port.
        guide: whether it is put into hand guiding; otherwise it is only looked at, and something
            else moves it.
        state_rate: samples of its state per second [Hz].
        max_age: how old its sample may be [s]; an older one is an error.
    """

    host: str
    port: int = 7003
    guide: bool = True
    state_rate: float = 100.0
    max_age: float = 0.5


@dataclass(kw_only=True)
class _DeviceConfig(TeleoperatorConfig):
    """An input device that leads the arm.

    Attributes:
        host: name or address of the controller of the arm that is led; it is only looked at.
        port: its TCP port.
        max_age: how old the sample of its state may be [s]; an older one is an error.
        model: the arm, as in `aioduco.kinematics.models()`; empty: what the controller tells.
        frame: along and about whose axes the flange moves: "base" or "tool".
        joints: whether the six axes of the device turn joints 1 to 6 instead.
        speed: at full deflection [m/s].
        turn_speed: at full deflection [rad/s].
        joint_speed: of a joint at full deflection [rad/s].
    """

    host: str
    port: int = 7003
    max_age: float = 0.5
    model: str = ""
    frame: str = "base"
    joints: bool = False
    speed: float = 0.05
    turn_speed: float = 0.2
    joint_speed: float = 0.1

    def __post_init__(self) -> None:
        if self.frame not in ("base", "tool"):
            raise ValueError(f"frame is 'base' or 'tool', not {self.frame!r}")


@TeleoperatorConfig.register_subclass("duco_keyboard")
@dataclass(kw_only=True)
class DucoKeyboardConfig(_DeviceConfig):
    """The keys of the terminal in which LeRobot runs; no display is needed."""


@TeleoperatorConfig.register_subclass("duco_gamepad")
@dataclass(kw_only=True)
class DucoGamepadConfig(_DeviceConfig):
    """A gamepad.

    Attributes:
        device: its file.
    """

    device: str = "/dev/input/js0"


@TeleoperatorConfig.register_subclass("duco_spacemouse")
@dataclass(kw_only=True)
class DucoSpaceMouseConfig(_DeviceConfig):
    """A SpaceMouse.

    Attributes:
        device: its file; empty: the first one.
    """

    device: str = ""


@EnvConfig.register_subclass("duco")
@dataclass(kw_only=True)
class DucoEnvConfig(EnvConfig):
    """A simulated arm with a task: one of aioduco's environments of Gymnasium.

    Attributes:
        task: "Reach", "Push", "PickPlace" or "Press"; with "-wire" behind it through the whole
            simulated controller, such as "Reach-wire".
        fps: steps per second of simulated time [Hz]; it is that of the environments.
        episode_length: steps of an episode.
        actions: "joints" or "cartesian".
        observations: "state", "pixels" or "both".
        reward: "sparse" or "dense".
        model: the arm.
        height: of pictures [pixels].
        width: of pictures [pixels].
        render_mode: "rgb_array", which `lerobot-eval` makes its videos of; None to draw nothing.

    Raises:
        ParameterError: an argument is none of these.
    """

    task: str | None = "Reach"
    fps: int = 25
    episode_length: int = EPISODE
    actions: str = "joints"
    observations: str = "state"
    reward: str = "sparse"
    model: str = "gcr5_910"
    height: int = 84
    width: int = 84
    render_mode: str | None = "rgb_array"
    features_map: dict[str, str] = field(
        default_factory=lambda: {
            ACTION: ACTION,
            "agent_pos": OBS_STATE,
            "environment_state": OBS_ENV_STATE,
            "pixels": OBS_IMAGE,
        }
    )

    def __post_init__(self) -> None:
        name = (self.task or "").removesuffix("-wire")
        if name not in TASKS:
            raise ParameterError("task", self.task, f"one of {TASKS}, also with -wire")
        # needs the extra `sim`, which who only leads an arm need not have
        from aioduco.integrations.gym.tasks import task_of  # noqa: PLC0415

        task = task_of(name, 1.0)
        count = (6 if self.actions == "joints" else 3) + bool(task.gripper)
        self.features = {
            ACTION: PolicyFeature(type=FeatureType.ACTION, shape=(count,)),
            "agent_pos": PolicyFeature(type=FeatureType.STATE, shape=(6,)),
        }
        if self.observations != "pixels":
            rest = 9 + 3 * task.feels + bool(task.gripper) + 10 * bool(task.moved) + task.size
            self.features["environment_state"] = PolicyFeature(type=FeatureType.ENV, shape=(rest,))
        if self.observations != "state":
            self.features["pixels"] = PolicyFeature(
                type=FeatureType.VISUAL, shape=(self.height, self.width, 3)
            )

    @property
    def package_name(self) -> str:
        """What is imported so that Gymnasium knows the environments."""
        return "lerobot_robot_duco"

    @property
    def gym_id(self) -> str:
        """Gymnasium's name of the environment."""
        return f"{self.package_name}/{self.task}-v0"

    @property
    def gym_kwargs(self) -> dict[str, object]:
        """What the environment is made with."""
        return {
            "actions": self.actions,
            "observations": self.observations,
            "reward": self.reward,
            "model": self.model,
            "size": (self.height, self.width),
            "render_mode": self.render_mode,
            "max_episode_steps": self.episode_length,
        }
