"""A scene or a tool as MJCF: from a file, from text, or of things."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TypeAlias
from xml.etree import ElementTree as ET

from aioduco.errors import SceneError
from aioduco.sim.scene.things import Thing

__all__ = ["SceneLike", "mjcf_of"]

SceneLike: TypeAlias = str | os.PathLike[str] | Sequence[Thing]
"""Path of an MJCF file, MJCF as text, or things."""


def mjcf_of(scene: SceneLike, *, free: bool = True) -> str:
    """Give a scene as one text: MJCF, or the absolute path of a file of it.

    Args:
        scene: a path, MJCF text (what begins with "<"), or things.
        free: whether things with a mass may move on their own; not so in a tool.

    Raises:
        SceneError: It is none of these.
    """
    if isinstance(scene, str) and scene.lstrip().startswith("<"):
        return scene
    if isinstance(scene, str | os.PathLike):
        return os.path.abspath(scene)  # noqa: PTH100 - a path that need not exist here
    root = ET.Element("mujoco")
    world = ET.SubElement(root, "worldbody")
    for thing in scene:
        if not isinstance(thing, Thing):
            raise SceneError(f"{thing!r} is no thing: give things, or one file, or MJCF as text")
        world.append(thing.mjcf(free=free))
    return ET.tostring(root, encoding="unicode")
