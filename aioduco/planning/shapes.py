"""Things of a planning scene, besides those of `aioduco.sim.scene`."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar
from xml.etree import ElementTree as ET

from aioduco.errors import ParameterError, SceneError
from aioduco.models.numpy_on_use import number_array
from aioduco.models.ranges import FILE
from aioduco.sim.scene import Thing

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray


#: names of the arm's own bodies, of its tool, and of what is around them, which no thing may have
OWN_NAMES = {"world", "floor", "base", "flange", "tool", *map("link{}".format, range(1, 7))}
OWN_NAME = "{!r} is the arm's own, or what it stands on: give the thing another name"


@dataclass(frozen=True, slots=True, kw_only=True)
class Ground(Thing):
    """An infinite plane; everything below it is solid.

    Attributes:
        at: a point of the plane, or a pose; the plane is perpendicular to the pose's z axis.
    """

    def _shapes(self, body: ET.Element) -> None:
        self._geom(body, "plane", (2.0, 2.0, 0.1))


@dataclass(frozen=True, slots=True, kw_only=True)
class Mesh(Thing):
    """The convex hull of a mesh. Give a hollow thing as several meshes.

    Attributes:
        file: path of an STL or OBJ file; or
        vertices: the corners [m]. Shape (n, 3), n from 4.
        scale: factor from the numbers of the file, or of `vertices`, to metres.
    """

    file: str | Path | None = None
    vertices: Sequence[Sequence[float]] | NDArray[np.float64] | None = field(
        default=None, repr=False
    )
    scale: float = 1.0

    _sizes: ClassVar[tuple[str, ...]] = ("scale",)

    def __post_init__(self) -> None:
        # `super()` without arguments fails, because `dataclass(slots=True)` makes a new class.
        Thing.__post_init__(self)
        if (self.file is None) == (self.vertices is None):
            raise ParameterError("file", self.file, "given, or else vertices, and not both")
        if self.file is not None:
            file = FILE("file", self.file).absolute()
            if not file.is_file():
                raise SceneError(f"the mesh's file {self.file} does not exist")
            object.__setattr__(self, "file", file)
        if self.vertices is not None:
            corners = _points("vertices", self.vertices, least=4)
            object.__setattr__(self, "vertices", _kept(corners))

    def assets(self) -> list[ET.Element]:
        """The elements of MJCF for the mesh outside of the world."""
        mesh = ET.Element("mesh", name=self._asset, inertia="convex")
        if self.file is not None:
            mesh.set("file", str(Path(self.file).resolve()))
            mesh.set("scale", " ".join([f"{self.scale:.9g}"] * 3))
        else:
            corners = _points("vertices", self.vertices, least=4) * self.scale
            # MuJoCo moves a mesh to its centre of mass; the geom moves it back.
            mesh.set("vertex", " ".join(f"{value:.9g}" for value in corners.ravel().tolist()))
        return [mesh]

    @property
    def _asset(self) -> str:
        return f"{self.name}/mesh"

    def _shapes(self, body: ET.Element) -> None:
        colour = " ".join(map(str, self.colour))
        ET.SubElement(body, "geom", type="mesh", mesh=self._asset, rgba=f"{colour} 1", mass="0")


@dataclass(frozen=True, slots=True, kw_only=True)
class PointCloud(Thing):
    """Points as small spheres, such as those of a depth camera.

    Attributes:
        points: in the frame of `at` [m]. Shape (n, 3).
        radius: radius of each sphere [m]; at least half of the distance between the points, so
            that nothing passes between them.
    """

    points: Sequence[Sequence[float]] | NDArray[np.float64] = field(repr=False)
    radius: float = 0.01

    _sizes: ClassVar[tuple[str, ...]] = ("radius",)

    def __post_init__(self) -> None:
        Thing.__post_init__(self)
        object.__setattr__(self, "points", _kept(_points("points", self.points, least=1)))

    def _shapes(self, body: ET.Element) -> None:
        for point in _points("points", self.points, least=1).tolist():
            place = " ".join(f"{value:.6g}" for value in point)
            self._geom(body, "sphere", (self.radius,), pos=place, mass="0")


def _kept(points: NDArray[np.float64]) -> tuple[tuple[float, ...], ...]:
    """Points that nobody changes, and that can be compared."""
    return tuple(map(tuple, points.tolist()))


def _points(name: str, value: Any, *, least: int) -> NDArray[np.float64]:
    found = number_array(name, value, "numbers of the shape (n, 3) [m]")
    if found.ndim != 2 or found.shape[1] != 3 or len(found) < least:
        raise ParameterError(name, found.shape, f"of the shape (n, 3), n from {least} [m]")
    return found
