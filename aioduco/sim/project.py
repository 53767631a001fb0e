"""The project's folder on the controller, and its files (manual 1.3.4)."""

from __future__ import annotations

import posixpath

__all__ = ["NoSuchFolder", "Project"]

FOLDER, FILE = 0, 1


class NoSuchFolder(Exception):
    """A path is no folder of the project."""


class Project:
    """A tree of names: nothing of this computer's files can be seen through it.

    Attributes:
        path: of the project, with a slash at its end, as the manual's example needs it.
        files: paths of the files in it, such as "program/pick.lua".
    """

    def __init__(self) -> None:
        self.path = "/project/"
        self.files: set[str] = set()

    def list(self, path: str) -> dict[str, int]:
        """The names in a folder, 0 for each folder and 1 for each file.

        Args:
            path: of the folder; the project's, when it is relative.

        Raises:
            NoSuchFolder: There is none, or it is not in the project.
        """
        root = posixpath.normpath(self.path)
        whole = posixpath.normpath(posixpath.join(root, path))
        if whole != root and not whole.startswith(f"{root}/"):
            raise NoSuchFolder(f"{path!r} is not in the project {self.path}")
        inside = whole[len(root) + 1 :]
        start = f"{inside}/" if inside else ""
        found: dict[str, int] = {}
        for file in self.files:
            if file.startswith(start):
                name, slash, _ = file[len(start) :].partition("/")
                found[name] = FOLDER if slash else FILE
        if not found and inside not in ("", "program"):
            raise NoSuchFolder(f"there is no folder {path!r}")
        return found
