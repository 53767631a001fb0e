"""Which links of an arm can touch each other, found by trying random configurations."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.descriptions.tree import ArmTree, LinkDescription
    from aioduco.models.rotation import Array

__all__ = ["SAMPLES", "LinkPair", "disabled_pairs", "pair_distances"]

SAMPLES = 20_000
"""Configurations that are tried."""

_SEED = 7
_CLEAR = 0.01  # nearer than this, a pair may touch between the samples [m]
_SAME = 1e-9  # by how much a distance differs that no joint changes [m]


class LinkPair(NamedTuple):
    """Two links whose collisions need no check.

    Attributes:
        link1: one of them.
        link2: the other.
        reason: as MoveIt calls it: "Adjacent", "Never" or "Always".
    """

    link1: str
    link2: str
    reason: str


def disabled_pairs(tree: ArmTree) -> tuple[LinkPair, ...]:
    """Give the pairs of links that need no check for collisions.

    Links beside each other in the chain overlap at their joint. Of the others, those pairs are
    given that touch in every configuration that was tried, those that never come within 10 mm of
    each other, and those whose distance is the same in all of them. The same arm gives the same
    pairs each time.

    Args:
        tree: the arm.
    """
    solid = [link.name for link in tree.links if link.parts]
    limits = np.array([limit[:2] for _, limit in tree.turning])
    random = np.random.default_rng(_SEED)
    q = random.uniform(limits[:, 0], limits[:, 1], (SAMPLES, len(limits)))
    pairs = []
    for (i, j), distance in pair_distances(tree, q).items():
        near, far = float(distance.min()), float(distance.max())
        if j == i + 1:
            pairs.append(LinkPair(solid[i], solid[j], "Adjacent"))
        elif near > _CLEAR or (near > 0.0 and far - near < _SAME):
            pairs.append(LinkPair(solid[i], solid[j], "Never"))
        elif far < 0.0:
            pairs.append(LinkPair(solid[i], solid[j], "Always"))
    return tuple(pairs)


def pair_distances(tree: ArmTree, q: Array) -> dict[tuple[int, int], Array]:
    """Give the distances between the links of an arm.

    Args:
        tree: the arm.
        q: joint angles [rad]. Shape (n, 6).

    Returns:
        By the numbers of two links among those that have a shape, from the base on, the distance
        of their capsules in each configuration, negative where they overlap [m]. Shape (n,).
    """
    frames = tree.frames(q)
    placed = [_placed(link, frames[link.name]) for link in tree.links if link.parts]
    return {
        (i, j): np.min(
            [
                _between(start, along, start2, along2) - radius - radius2
                for start, along, radius in placed[i]
                for start2, along2, radius2 in placed[j]
            ],
            axis=0,
        )
        for i, j in combinations(range(len(placed)), 2)
    }


def _placed(link: LinkDescription, frames: Array) -> Sequence[tuple[Array, Array, float]]:
    """The axes of a link's capsules in the base frame, as start and direction, and radii."""
    turn, at = frames[:, :3, :3], frames[:, :3, 3]
    return [
        (turn @ part.start + at, turn @ np.subtract(part.end, part.start), part.radius)
        for part in link.parts
    ]


def _between(start1: Array, along1: Array, start2: Array, along2: Array) -> Array:
    """The distances of line segments [m]. Shapes (n, 3) each; result (n,).

    The nearest point of one line to the other is brought onto its segment, then the nearest point
    to that onto the other segment, and back: with straight segments that is the nearest pair.
    """
    between = start1 - start2
    a, b, e = _dot(along1, along1), _dot(along1, along2), _dot(along2, along2)
    c, f = _dot(along1, between), _dot(along2, between)
    # A point, as a segment of no length, and parallel segments have no nearest point of their own.
    tiny = 1e-12
    s = np.clip((b * f - c * e) / np.maximum(a * e - b * b, tiny), 0.0, 1.0)
    t = np.clip((b * s + f) / np.maximum(e, tiny), 0.0, 1.0)
    s = np.clip((b * t - c) / np.maximum(a, tiny), 0.0, 1.0)
    gap = between + s[:, None] * along1 - t[:, None] * along2
    return np.sqrt(_dot(gap, gap))


def _dot(one: Array, other: Array) -> Array:
    product: Array = np.einsum("ij,ij->i", one, other)
    return product
