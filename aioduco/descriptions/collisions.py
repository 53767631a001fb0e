"""Which links of an arm can touch each other, found by trying random configurations."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from aioduco.descriptions.tree import ArmTree, LinkDescription
    from aioduco.models.rotation import Array

__all__ = ["SAMPLES", "LinkPair", "disabled_pairs", "pair_distances"]

SAMPLES = 10_000
"""Configurations that are tried."""

_SEED = 7
_FEW = 500
_CLEAR = 0.01  # nearer than this, a pair may touch between the samples [m]
_SAME = 1e-9  # what is only rounding of a distance [m]


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
    reasons = {(i, i + 1): "Adjacent" for i in range(len(solid) - 1)}
    left = [pair for pair in combinations(range(len(solid)), 2) if pair not in reasons]
    # Most pairs are seen both to touch and not to touch at once, and the rest is for few.
    for some in (q[:_FEW], q):
        decided = {
            pair: _reason(float(distance.min()), float(distance.max()))
            for pair, distance in pair_distances(tree, some, left).items()
        }
        left = [pair for pair in left if decided[pair]]
    reasons |= {pair: decided[pair] for pair in left}
    return tuple(LinkPair(solid[i], solid[j], why) for (i, j), why in sorted(reasons.items()))


def _reason(near: float, far: float) -> str:
    if far - near < _SAME:
        return "Always" if near < _SAME else "Never"
    return "Never" if near > _CLEAR else "Always" if far < 0.0 else ""


def pair_distances(
    tree: ArmTree, q: Array, pairs: Iterable[tuple[int, int]]
) -> dict[tuple[int, int], Array]:
    """Give the distances between links of an arm.

    Args:
        tree: the arm.
        q: joint angles [rad]. Shape (n, 6).
        pairs: two links each, by their numbers among those that have a shape, from the base on.

    Returns:
        By pair, the distance of their capsules in each configuration, negative where they
        overlap [m]. Shape (n,).
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
        for i, j in pairs
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
