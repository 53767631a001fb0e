"""Arm, tool and scene in one MuJoCo model."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from aioduco.errors import SceneError

if TYPE_CHECKING:
    mujoco: Any  # its bindings are compiled, without types
else:
    import mujoco

__all__ = ["compose"]


def compose(arm: str, scene: str | None, tool: str | None) -> Any:
    """Compile an arm, with what it carries and what stands around it.

    The arm comes first, so that its joints, drives and sensors have the first indices. Names of a
    scene get the prefix "scene/", those of a tool "tool/". Options of both are without effect,
    since the arm's hold: its drives are made for its time step. A plane that a scene calls "floor"
    takes the place of the arm's.

    Args:
        arm: the arm as MJCF, with a body "flange" and a geom "floor".
        scene: MJCF, or the path of a file of it; placed in the world.
        tool: likewise, rigidly placed at the flange.

    Returns:
        The compiled model.

    Raises:
        SceneError: MuJoCo does not take the scene or the tool; it says why.
    """
    spec = mujoco.MjSpec.from_string(arm)
    if tool is not None:
        body = spec.body("flange").add_body(name="tool")
        spec.attach(_part("tool", tool, spec), prefix="tool/", frame=body.add_frame())
    if scene is not None:
        part = _part("scene", scene, spec)
        if part.geom("floor") is not None:
            spec.delete(spec.geom("floor"))
        spec.attach(part, prefix="scene/", frame=spec.worldbody.add_frame())
    try:
        return spec.compile()
    except ValueError as exc:
        raise SceneError(f"scene and tool make no model: {exc}") from exc


def _part(name: str, text: str, spec: Any) -> Any:
    inline = text.lstrip().startswith("<")
    if not inline and not os.path.isfile(text):  # noqa: PTH113 - a path given as text
        raise SceneError(f"the {name}'s file {text} does not exist")
    try:
        part = (mujoco.MjSpec.from_string if inline else mujoco.MjSpec.from_file)(text)
    except ValueError as exc:
        raise SceneError(f"the {name} is no MJCF: {exc}") from exc
    for option in dir(spec.option):
        if not option.startswith("_"):
            setattr(part.option, option, getattr(spec.option, option))
    return part
