"""The names of the tasks, and the length of an episode."""

from __future__ import annotations

from typing import Final

TASKS: Final = ("Reach", "Push", "PickPlace", "Press")

EPISODE: Final = 100
"""Steps of an episode, each of 40 ms."""
