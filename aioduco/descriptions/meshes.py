"""The user's own meshes, found by the names of links."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from aioduco.errors import ParameterError

if TYPE_CHECKING:
    import os
    from collections.abc import Iterable, Sequence

    from aioduco.descriptions.tree import ArmTree

__all__ = ["find_meshes"]


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
    place = Path(folder).resolve()
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
