"""The project's folder on the controller: files, programs and tracks (manual 1.3.4)."""

from __future__ import annotations

import posixpath
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from aioduco.models.enums import FileKind
from aioduco.sim.cabinet.script import Script, checked, read

if TYPE_CHECKING:
    from collections.abc import Mapping


#: most points of a track, in either mode; the manual gives no number
CAPACITY = 1000


@dataclass(slots=True, eq=False)
class RecordedTrack:
    """A recorded track.

    Attributes:
        tool: name of the tool whose poses were recorded.
        wobj: name of the work object in whose frame the poses are.
        joints: joint angles of each point [rad].
        poses: pose of each point, as six numbers [m, rad].
    """

    tool: str
    wobj: str
    joints: list[tuple[float, ...]] = field(default_factory=list)
    poses: list[tuple[float, ...]] = field(default_factory=list)

    @property
    def full(self) -> bool:
        """Whether no further point fits."""
        return len(self.joints) >= CAPACITY


class NoSuchFolder(Exception):
    """A path is not a folder of the project."""


class Project:
    """A tree of names: it gives no access to this computer's files.

    Attributes:
        path: path of the project, with a slash at its end, as the manual's example needs it.
        files: paths of further files in it, such as "notes.txt".
        programs: by name; each is listed as "program/" and its name.
        tracks: recorded ones, by name; each is listed as "track/" and its name.
    """

    def __init__(self) -> None:
        self.path: str = "/project/"
        self.files: set[str] = set()
        self.programs: dict[str, Script] = {}
        self.tracks: dict[str, RecordedTrack] = {}

    def add(self, programs: Mapping[str, Script] | str | Path) -> None:
        """Add programs.

        Args:
            programs: programs by name, or a folder in which each file "<name>.json" is a program.

        Raises:
            ValueError: One of them is not a program.
            OSError: The folder or a file cannot be read.
        """
        given = read(programs) if isinstance(programs, (str, Path)) else programs
        for name, script in given.items():
            if not name:
                raise ValueError("the name of a program must not be empty")
            self.programs[name] = checked(f"program {name!r}", script)

    def list(self, path: str) -> dict[str, int]:
        """List the names in a folder, with 0 for each folder and 1 for each file.

        Args:
            path: path of the folder; a relative path starts at the project's.

        Raises:
            NoSuchFolder: There is no such folder, or it is not in the project.
        """
        root = posixpath.normpath(self.path)
        whole = posixpath.normpath(posixpath.join(root, path))
        if whole != root and not whole.startswith(f"{root}/"):
            raise NoSuchFolder(f"{path!r} is not in the project {self.path}")
        inside = whole[len(root) + 1 :]
        start = f"{inside}/" if inside else ""
        found: dict[str, int] = {}
        paths = {*self.files, *(f"program/{name}" for name in self.programs)}
        for file in paths | {f"track/{name}" for name in self.tracks}:
            if file.startswith(start):
                name, slash, _ = file[len(start) :].partition("/")
                found[name] = int(FileKind.FOLDER if slash else FileKind.FILE)
        if not found and inside not in ("", "program"):
            raise NoSuchFolder(f"there is no folder {path!r}")
        return found
