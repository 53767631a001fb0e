"""Aioduco's environments of Gymnasium, with the names of observations that LeRobot expects."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.envs.registration import WrapperSpec, register, registry

from aioduco.integrations.gym import TASKS
from aioduco.integrations.gym.names import EPISODE

__all__ = ["DESCRIPTIONS", "LeRobotObservations", "register_environments"]

#: what is to be done, as it is told to policies that read
DESCRIPTIONS: dict[str, str] = {
    "Reach": "move the tip of the tool to the goal",
    "Push": "push the box to the goal",
    "PickPlace": "pick up the box and put it at the goal",
    "Press": "press on the pad with the wanted force",
}
_JOINTS = 6


class LeRobotObservations(gymnasium.ObservationWrapper[dict[str, Any], Any, dict[str, Any]]):
    """Names observations as LeRobot does.

    "agent_pos" is the joints [rad], the same numbers as the robot's `observation.state`.
    "environment_state" is all else that the environment tells, and the goal behind it. "pixels" is
    the picture.

    Args:
        env: one of aioduco's environments.
        task: what is to be done; a key of `DESCRIPTIONS`.
    """

    def __init__(self, env: gymnasium.Env[dict[str, Any], Any], task: str) -> None:
        super().__init__(env)
        #: what is to be done, for policies that read
        self.task_description = DESCRIPTIONS[task]
        self.task = task
        inner = env.observation_space
        assert isinstance(inner, spaces.Dict)
        shown = self.observation(
            {name: np.zeros(space.shape or (), space.dtype) for name, space in inner.items()}
        )
        found: dict[str, spaces.Space[Any]] = {
            name: spaces.Box(-np.inf, np.inf, value.shape, np.float64)
            for name, value in shown.items()
            if name != "pixels"
        }
        if "pixels" in inner.spaces:
            found["pixels"] = inner["pixels"]
        self.observation_space = spaces.Dict(found)

    def observation(self, observation: dict[str, Any]) -> dict[str, Any]:
        """One observation, by LeRobot's names."""
        found: dict[str, Any] = {}
        if "observation" in observation:
            state = observation["observation"]
            found["agent_pos"] = state[:_JOINTS]
            rest = (state[_JOINTS:], observation["desired_goal"])
            found["environment_state"] = np.concatenate(rest)
        if "pixels" in observation:
            found["agent_pos"] = observation["joints"][:_JOINTS]
            found["pixels"] = observation["pixels"]
        return found


def register_environments() -> None:
    """Register them with Gymnasium, such as "lerobot_robot_duco/Reach-v0"; nothing is made."""
    for task in TASKS:
        for wire in (False, True):
            name = f"lerobot_robot_duco/{task}{'-wire' if wire else ''}-v0"
            if name not in registry:
                register(
                    name,
                    entry_point="aioduco.integrations.gym.environment:ArmEnv",
                    max_episode_steps=EPISODE,
                    kwargs={"task": task, "wire": wire},
                    # around all others: LeRobot looks for the task's description on the outermost
                    additional_wrappers=(
                        WrapperSpec(
                            name=LeRobotObservations.__name__,
                            entry_point=f"{__name__}:{LeRobotObservations.__name__}",
                            kwargs={"task": task},
                        ),
                    ),
                )
