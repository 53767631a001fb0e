"""Gymnasium environments: the simulated arm, its physics alone or with its whole controller.

    import gymnasium
    import aioduco.integrations.gym

    env = gymnasium.make("aioduco/Reach-v0")             # the physics, without the wire: fast
    env = gymnasium.make("aioduco/Reach-wire-v0")        # and the controller: true to life

The tasks are Reach, Push, PickPlace and Press. Importing this module registers their names, as
Gymnasium requires, and does nothing else. It needs the extra `gym`.
"""

from __future__ import annotations

from aioduco.errors import MissingExtra
from aioduco.integrations.gym.names import EPISODE, TASKS

with MissingExtra.named("an environment", "gym"):
    from gymnasium.envs.registration import register, registry

__all__ = ["TASKS", "register_envs"]


def register_envs() -> None:
    """Register the environments with Gymnasium, except those that are already registered."""
    for task in TASKS:
        for wire in (False, True):
            name = f"aioduco/{task}-{'wire-' if wire else ''}v0"
            if name not in registry:
                register(
                    name,
                    entry_point="aioduco.integrations.gym.environment:ArmEnv",
                    max_episode_steps=EPISODE,
                    kwargs={"task": task, "wire": wire},
                )


register_envs()
