"""Environments of Gymnasium: the simulated arm, its physics alone or with its whole controller.

    import gymnasium
    import aioduco.integrations.gym

    env = gymnasium.make("aioduco/Reach-v0")             # the physics, without the wire: fast
    env = gymnasium.make("aioduco/Reach-wire-v0")        # and the controller: true to life

The tasks are Reach, Push, PickPlace and Press. Importing this registers their names, as Gymnasium
asks of such packages, and does nothing else; it needs the extra `gym`.
"""

from __future__ import annotations

from gymnasium.envs.registration import register, registry

from aioduco.integrations.gym.names import EPISODE, TASKS

__all__ = ["TASKS", "register_envs"]


def register_envs() -> None:
    """Register the environments with Gymnasium; those that are registered stay as they are."""
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
