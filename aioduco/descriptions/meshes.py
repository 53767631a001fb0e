"""Files of meshes: the user's own, found by the names of links, and those of the arms' looks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from aioduco.errors import ParameterError
from aioduco.kinematics.looks import merged
from aioduco.models.ranges import FOLDER

if TYPE_CHECKING:
    import os
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from aioduco.descriptions.tree import ArmTree
    from aioduco.kinematics.looks import Faces
    from aioduco.models.rotation import Array


#: a triangle of a binary STL
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def find_meshes(
    folder: str | os.PathLike[str] | None, trees: Iterable[ArmTree], kinds: Sequence[str]
) -> dict[str, Path]:
    """Return the files in a folder that are named like links, such as `link_1.stl`.

    Meshes are in the frames of the links and in metres. A name may have the arm's prefix.

    Args:
        folder: folder of the meshes; None for no meshes.
        trees: the arms.
        kinds: file extensions, the preferred one first, such as ".dae".

    Returns:
        Absolute paths by the name of the link.

    Raises:
        ParameterError: the folder has no mesh for any link.
    """
    if folder is None:
        return {}
    place = FOLDER("meshes", folder).resolve()
    files = {path.name.lower(): path for path in sorted(place.glob("*")) if path.is_file()}
    found: dict[str, Path] = {}
    for tree in trees:
        for link in tree.links:
            for name in (link.name, link.name.removeprefix(tree.arm.prefix)):
                file = next(
                    (files[f] for kind in kinds if (f := name.lower() + kind) in files), None
                )
                if file is not None:
                    found.setdefault(link.name, file)
    if not found:
        wanted = f"a folder with base_link, link_1, … as one of {', '.join(kinds)}"
        raise ParameterError("meshes", str(folder), wanted)
    return found


def own_meshes(trees: Iterable[ArmTree]) -> dict[str, dict[str, str]]:
    """Return the names of the files of the arms' looks: by link, by colour."""
    return {
        link.name: {colour: f"{link.name}_{colour}.stl" for colour in merged(link.looks)}
        for tree in trees
        for link in tree.links
        if link.looks
    }


def stl(points: Array, faces: Faces) -> bytes:
    """Return a mesh as binary STL.

    Args:
        points: points [m]. Shape (n, 3).
        faces: triangles as indices of points. Shape (m, 3).
    """
    corners = points[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    triangles = np.zeros(len(faces), _TRIANGLE)
    triangles["corners"] = corners
    triangles["normal"] = across / np.linalg.norm(across, axis=1, keepdims=True)
    return bytes(80) + len(faces).to_bytes(4, "little") + bytes(triangles.tobytes())
