"""How the arms look: housings, caps, tubes and a flange, turned and lofted from an arm's lengths.

The vendor's meshes may not be shipped, so these are made from the same numbers as the bodies that
collide: what is drawn reaches at most 30 mm beyond them. Each joint has on its moving link a dark
ring, and where its axis ends a dark cap, both with a light mark; a second mark on the link before
shows where the joint is at zero.
"""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from aioduco.kinematics.arm import Arm
    from aioduco.models.rotation import Array

    Faces: TypeAlias = NDArray[np.int32]

__all__ = ["COLOURS", "Faces", "Look", "looks", "merged"]

COLOURS: Final = {
    "body": (0.87, 0.88, 0.89),
    "cap": (0.19, 0.27, 0.36),
    "mark": (0.98, 0.62, 0.16),
    "metal": (0.58, 0.60, 0.62),
}
"""Colours by name, as red, green and blue from 0 to 1: of no maker."""

_ROUND = 32  # edges of a round shape
_SHARP = math.cos(math.radians(30.0))  # above this angle an edge is seen as one
_X, _Y, _Z = np.eye(3)


class Look(NamedTuple):
    """A closed surface of a link.

    Attributes:
        colour: name of its colour, in `COLOURS`.
        vertices: points in the link's frame [m]; doubled along sharp edges, so that normals that
            are averaged at points show them. Shape (n, 3).
        faces: triangles as indices of points, counterclockwise seen from outside. Shape (m, 3).
        start: one end of the axis of a cylinder of about this shape [m]. Shape (3,).
        end: the other end [m]. Shape (3,).
        radius: the cylinder's radius [m].
    """

    colour: str
    vertices: Array
    faces: Faces
    start: Array
    end: Array
    radius: float


class _Place(NamedTuple):
    """A frame in that of a link."""

    at: Array
    x: Array
    z: Array

    def put(self, points: Array) -> Array:
        placed: Array = self.at + points @ np.array([self.x, np.cross(self.z, self.x), self.z])
        return placed


@cache
def looks(arm: Arm) -> tuple[tuple[Look, ...], ...]:
    """Return the surfaces of the base and the six links of an arm."""
    return _base(arm), *_shoulder_and_arms(arm), *_wrist(arm)


def merged(parts: Iterable[Look]) -> dict[str, tuple[Array, Faces]]:
    """Return the points and triangles of a link's surfaces, by their colour."""
    found: dict[str, tuple[Array, Faces]] = {}
    for part in parts:
        points, faces = part.vertices, part.faces
        if part.colour in found:
            before, triangles = found[part.colour]
            faces = np.concatenate([triangles, faces + np.int32(len(before))])
            points = np.concatenate([before, points])
        found[part.colour] = points, faces
    return found


class _Sizes(NamedTuple):
    """Radii, and where links meet on the axes of their joints [m]."""

    shoulder: float
    tube: float
    wrist: float
    upper: float
    fore: float
    joint1: float
    joint2: float
    joint3: float
    joint4: float
    joint5: float
    joint6: float


def _sizes(arm: Arm) -> _Sizes:
    g = arm.geometry
    # The radii of `bodies`.
    shoulder, tube, wrist = 0.7 * g.d5, 0.5 * g.d5, 0.42 * g.d5
    upper, fore = arm.centres[2][2], arm.centres[3][2]
    return _Sizes(
        shoulder, tube, wrist, upper, fore,
        joint1=g.d1 - 1.02 * shoulder,  # along z of the base
        joint2=g.d2 + upper - 1.05 * tube,  # along y of link 1
        joint3=0.5 * (upper + fore) - 0.075 * tube,  # along z of links 2 and 3
        joint4=fore + 0.95 * wrist,  # along z of links 3 and 4
        joint5=g.d5 - 0.95 * wrist,  # along -y of link 4
        joint6=g.d6 - 0.62 * wrist,  # along y of link 5
    )  # fmt: skip


def _base(arm: Arm) -> tuple[Look, ...]:
    s = _sizes(arm)
    stand = _Place(np.zeros(3), _X, _Z)
    foot = 0.16 * s.shoulder
    return (
        _can("metal", stand, 1.12 * s.shoulder, 0.0, foot, 0.0, 0.02 * s.shoulder),
        _can("body", stand, 0.97 * s.shoulder, 0.9 * foot, s.joint1 - 0.001, 0.0, 0.002),
        _tick(stand, 0.97 * s.shoulder, s.joint1 - 0.16 * s.shoulder, s.joint1 - 0.003),
    )


def _shoulder_and_arms(arm: Arm) -> tuple[tuple[Look, ...], ...]:
    g, s = arm.geometry, _sizes(arm)
    t = s.tube
    up = _Place(np.zeros(3), _X, _Z)
    across = _Place(np.zeros(3), _Z, _Y)  # link 1: along the axis of joint 2, x upwards
    bottom = s.joint1 - g.d1
    shoulder = (
        *_ring(up, 0.99 * s.shoulder, bottom, 0.24 * s.shoulder),
        _can("body", up, 0.95 * s.shoulder, bottom + 0.22 * s.shoulder, 0.0, 0.0, 0.0),
        _turned(
            "body",
            across,
            [
                *_fillet(0.98 * s.shoulder, -0.98 * s.shoulder, 0.35 * s.shoulder),
                (0.98 * s.shoulder, 0.4 * s.joint2),
                (1.2 * t, 0.9 * s.joint2),
                (1.2 * t, s.joint2 - 0.003),
                (1.2 * t - 0.002, s.joint2 - 0.001),
            ],
        ),
        _tick(across, 1.2 * t, s.joint2 - 0.18 * s.shoulder, s.joint2 - 0.004),
    )
    # Upper arm and forearm turn about z and extend along x.
    near, far = s.joint2 - g.d2, s.upper + 0.95 * t
    elbow = _Place(np.array([g.a2, 0.0, 0.0]), _X, _Z)
    upper = (
        *_ring(up, 1.2 * t, near, 0.24 * t),
        _can("body", up, 1.16 * t, near + 0.22 * t, far - 0.2 * t, 0.0, 0.02 * t),
        *_cap(up, 1.08 * t, far - 0.2 * t, far),
        _tube(
            s.upper, 0.3 * t, g.a2 - 0.2 * t,
            [(0.0, 1.05, 0.82), (0.12, 0.98, 0.8), (0.3, 0.82, 0.72), (0.7, 0.74, 0.68),
             (0.9, 0.86, 0.74), (1.0, 0.9, 0.76)], t,
        ),
        _turned(
            "body",
            elbow,
            [
                (1.08 * t - 0.002, s.joint3 + 0.001),
                (1.08 * t, s.joint3 + 0.003),
                *reversed(_mirrored(_fillet(1.08 * t, -(s.upper + 0.85 * t), 0.3 * t))),
            ],
        ),
        _tick(elbow, 1.08 * t, s.joint3 + 0.004, s.joint3 + 0.22 * t),
    )  # fmt: skip
    w = s.wrist
    wrist = _Place(np.array([g.a3, 0.0, 0.0]), _X, _Z)
    down = _Place(np.zeros(3), _X, -_Z)
    low = s.fore - 0.85 * t
    fore = (
        *_ring(down, 1.04 * t, -s.joint3, 0.24 * t),
        _can("body", down, t, 0.22 * t - s.joint3, -low - 0.2 * t, 0.0, 0.02 * t),
        *_cap(down, 0.92 * t, -low - 0.2 * t, -low),
        _tube(
            s.fore, 0.25 * t, g.a3 - 0.2 * w,
            [(0.0, 0.88, 0.72), (0.12, 0.82, 0.7), (0.35, 0.66, 0.62), (0.75, 0.58, 0.56),
             (0.92, 0.68, 0.6), (1.0, 0.7, 0.6)], t,
        ),
        _turned(
            "body",
            wrist,
            [
                *_fillet(1.02 * w, s.fore - 0.85 * w, 0.3 * w),
                (1.02 * w, s.joint4 - 0.003),
                (1.02 * w - 0.002, s.joint4 - 0.001),
            ],
        ),
        _tick(wrist, 1.02 * w, s.joint4 - 0.26 * w, s.joint4 - 0.004),
    )  # fmt: skip
    return shoulder, upper, fore


def _wrist(arm: Arm) -> tuple[tuple[Look, ...], ...]:
    g, s = arm.geometry, _sizes(arm)
    w = s.wrist
    # Link 4 turns about z and extends along -y; link 5 turns about z and extends along y.
    first, onward = _Place(np.zeros(3), -_Y, _Z), _Place(np.zeros(3), _Z, -_Y)
    second, outward = _Place(np.zeros(3), _Y, _Z), _Place(np.zeros(3), _X, _Y)
    flange = _Place(np.zeros(3), _X, _Z)
    below, thick = s.joint6 - g.d6, 0.24 * w
    face = -0.0005  # the bolts end in the plane of the flange
    return (
        (
            *_ring(first, 1.02 * w, s.joint4, 0.26 * w),
            _can("body", first, 0.99 * w, s.joint4 + 0.24 * w, 0.78 * w, 0.0, 0.02 * w),
            *_cap(first, 0.92 * w, 0.78 * w, w),
            _can("body", onward, 0.96 * w, 0.0, s.joint5 - 0.001, 0.0, 0.002),
            _tick(onward, 0.96 * w, s.joint5 - 0.26 * w, s.joint5 - 0.004),
        ),
        (
            *_ring(second, 1.02 * w, -0.95 * w, 0.26 * w),
            _can("body", second, 0.99 * w, -0.71 * w, 0.78 * w, 0.0, 0.02 * w),
            *_cap(second, 0.92 * w, 0.78 * w, w),
            _can("body", outward, 0.96 * w, 0.0, s.joint6 - 0.001, 0.0, 0.002),
            _tick(outward, 0.96 * w, s.joint6 - 0.26 * w, s.joint6 - 0.004),
        ),
        (
            *_ring(flange, 0.97 * w, below, thick),
            _turned(
                "metal",
                flange,
                [
                    (0.75 * w, below + 0.8 * thick), (0.75 * w, face - 0.001),
                    (0.75 * w - 0.001, face), (0.38 * w, face), (0.38 * w, face - 0.1 * w),
                ],
            ),
            *(
                _can(
                    "cap",
                    _Place(0.56 * w * np.array([math.cos(a), math.sin(a), 0.0]), _X, _Z),
                    0.07 * w, -0.1 * w, 0.0, 0.0, 0.0,
                )
                for a in (np.arange(4) + 0.5) * math.pi / 2
            ),
        ),
    )  # fmt: skip


# -- parts ---------------------------------------------------------------------------------------


def _ring(place: _Place, radius: float, start: float, width: float) -> tuple[Look, ...]:
    """Where a link begins to turn: a dark ring with a mark at its x axis."""
    return (
        _can("cap", place, radius, start, start + width, 0.001, 0.001),
        _tick(place, radius, start + 0.002, start + width - 0.002),
    )


def _cap(place: _Place, radius: float, start: float, end: float) -> tuple[Look, ...]:
    """The dark end of a joint's axis, with a mark that points along its x axis."""
    high = np.array([0.0, 0.0, end - 0.001])
    top = _Place(place.put(high), place.x, place.z)
    edge = 0.35 * (end - start)
    return (
        _can("cap", place, radius, start - 0.1 * radius, end, 0.0, edge),
        _slot(top, 0.18 * radius, radius - 1.6 * edge, 0.2 * radius, 0.0016),
    )


def _tick(place: _Place, radius: float, start: float, end: float) -> Look:
    """A mark along a round surface, at the x axis."""
    deep = 0.05 * radius
    side = _Place(place.put(np.array([radius - deep, 0.0, 0.0])), place.z, place.x)
    return _slot(side, start, end, 0.22 * radius, deep + 0.001)


def _can(
    colour: str, place: _Place, radius: float, start: float, end: float, near: float, far: float
) -> Look:
    """A cylinder along z, with chamfers at both ends."""
    outline = [(radius, start), (radius, end)]
    if near:
        outline[:1] = [(radius - near, start), (radius, start + near)]
    if far:
        outline[-1:] = [(radius, end - far), (radius - far, end)]
    return _turned(colour, place, outline)


def _fillet(radius: float, start: float, bend: float) -> list[tuple[float, float]]:
    """The outline of a cylinder's round beginning."""
    return [
        (radius - bend * (1.0 - math.sin(a)), start + bend * (1.0 - math.cos(a)))
        for a in np.linspace(0.0, math.pi / 2, 5)
    ]


def _mirrored(outline: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    return [(radius, -height) for radius, height in outline]


def _turned(colour: str, place: _Place, outline: Sequence[tuple[float, float]]) -> Look:
    """A body turned about z: radii and heights of its outline, which the axis closes."""
    around = np.linspace(0.0, 2 * math.pi, _ROUND, endpoint=False)
    rings = [
        np.column_stack([r * np.cos(around), r * np.sin(around), np.full(_ROUND, z)])
        for r, z in outline
    ]
    heights = [z for _, z in outline]
    ends = place.put(np.array([[0.0, 0.0, min(heights)], [0.0, 0.0, max(heights)]]))
    return _skin(colour, place, rings, ends, max(r for r, _ in outline))


def _tube(
    side: float, start: float, end: float, sections: Sequence[tuple[float, float, float]],
    unit: float,
) -> Look:  # fmt: skip
    """A body lofted along x: for each section where it is, from 0 to 1, and its half axes."""
    place = _Place(np.array([0.0, 0.0, side]), -_Z, _X)
    around = np.linspace(0.0, 2 * math.pi, _ROUND, endpoint=False)
    c, s = np.cos(around), np.sin(around)
    # a superellipse, between an ellipse and a rectangle
    c, s = np.sign(c) * np.abs(c) ** 0.8, np.sign(s) * np.abs(s) ** 0.8
    rings = [
        np.column_stack(
            [high * unit * c, wide * unit * s, np.full(_ROUND, start + at * (end - start))]
        )
        for at, wide, high in sections
    ]
    ends = place.put(np.array([[0.0, 0.0, start], [0.0, 0.0, end]]))
    thick = float(np.mean([(wide + high) / 2 for _, wide, high in sections]))
    return _skin("body", place, rings, ends, thick * unit)


def _slot(place: _Place, start: float, end: float, width: float, thick: float) -> Look:
    """A mark: a bar along x with round ends, as thick as said along z."""
    bend = np.linspace(-math.pi / 2, math.pi / 2, 6)
    half = min(width, 0.9 * (end - start)) / 2
    c, s = half * np.cos(bend), half * np.sin(bend)
    x = np.concatenate([end - half + c, start + half - c])
    y = np.concatenate([s, -s])
    rings = [np.column_stack([x, y, np.full(len(x), z)]) for z in (0.0, thick)]
    ends = place.put(np.array([[start, 0.0, thick - half], [end, 0.0, thick - half]]))
    return _skin("mark", place, rings, ends, half)


def _skin(colour: str, place: _Place, rings: Sequence[Array], ends: Array, radius: float) -> Look:
    """Stretch a surface over rings of points, and close it at both ends."""
    first, last = rings[0].mean(axis=0), rings[-1].mean(axis=0)
    between = [after - before for before, after in pairwise(rings)]
    spans = [rings[0] - first, *between, last - rings[-1]]
    count = len(rings[0])
    here = np.arange(count)
    there = np.roll(here, -1)
    points, faces = [first[None]], []
    below, new = 0, 1  # where the points of the last ring and of the next one begin
    for number, ring in enumerate(rings):
        if number == 0:
            faces.append(np.column_stack([np.zeros_like(here), new + there, new + here]))
        else:
            faces.append(np.column_stack([below + here, below + there, new + there]))
            faces.append(np.column_stack([below + here, new + there, new + here]))
        for _ in range(2 if _bent(spans[number], spans[number + 1]) else 1):
            points.append(ring)
            below, new = new, new + count
    points.append(last[None])
    faces.append(np.column_stack([below + here, below + there, np.full_like(here, new)]))
    vertices = place.put(np.concatenate(points))
    return Look(colour, vertices, np.concatenate(faces).astype(np.int32), ends[0], ends[1], radius)


def _bent(one: Array, other: Array) -> bool:
    """Whether a surface turns sharply between two spans of its rings. Shapes (n, 3)."""
    lengths = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
    return bool(((one * other).sum(axis=1) < _SHARP * lengths).any())
