"""Pairs of links that can collide, found by sampling random configurations."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from aioduco.descriptions.tree import ArmTree, LinkDescription
    from aioduco.models.rotation import Array


SAMPLES = 10_000
"""Configurations that are tried."""

_SEED = 7
_FEW = 500
_CLEAR = 0.01  # below this distance, a pair may touch between the samples [m]
_SAME = 1e-9  # rounding error of a distance [m]


class LinkPair(NamedTuple):
    """Two links whose collisions need no check.

    Attributes:
        link1: name of one link.
        link2: name of the other.
        reason: MoveIt's word for the reason: "Adjacent", "Never" or "Always".
    """

    link1: str
    link2: str
    reason: str


def disabled_pairs(tree: ArmTree) -> tuple[LinkPair, ...]:
    """Return the pairs of links that need no check for collisions.

    Neighbouring links in the chain overlap at their joint. Of the others, a pair is returned if it
    touches in every sampled configuration, if it never comes within 10 mm, or if its distance is
    the same in all of them. The same arm always has the same result.

    Args:
        tree: the arm.
    """
    solid = [link.name for link in tree.links if link.parts]
    limits = np.array([limit[:2] for _, limit in tree.turning])
    random = np.random.default_rng(_SEED)
    q = random.uniform(limits[:, 0], limits[:, 1], (SAMPLES, len(limits)))
    reasons = {(i, i + 1): "Adjacent" for i in range(len(solid) - 1)}
    left = [pair for pair in combinations(range(len(solid)), 2) if pair not in reasons]
    # For most pairs the first samples already show that they need a check; only the few others need
    # all samples.
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
    """Return the distances between links of an arm.

    Args:
        tree: the arm.
        q: joint angles [rad]. Shape (n, 6).
        pairs: pairs of indices of links; only links with a shape count, from the base on.

    Returns:
        For each pair, the distance of their capsules in each configuration, negative if they
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
    """Return start, direction and radius of a link's capsules, in the base frame."""
    turn, at = frames[:, :3, :3], frames[:, :3, 3]
    return [
        (turn @ part.start + at, turn @ np.subtract(part.end, part.start), part.radius)
        for part in link.parts
    ]


def _between(start1: Array, along1: Array, start2: Array, along2: Array) -> Array:
    """Return the distances of line segments [m]. Shapes (n, 3) each; result (n,).

    The nearest point of the first line is clipped to its segment. Then the point of the second
    segment nearest to it is found, and the same again for the first segment. For straight segments
    this is the nearest pair of points.
    """
    between = start1 - start2
    a, b, e = _dot(along1, along1), _dot(along1, along2), _dot(along2, along2)
    c, f = _dot(along1, between), _dot(along2, between)
    # Avoids division by zero for segments of length zero and for parallel segments.
    tiny = 1e-12
    s = np.clip((b * f - c * e) / np.maximum(a * e - b * b, tiny), 0.0, 1.0)
    t = np.clip((b * s + f) / np.maximum(e, tiny), 0.0, 1.0)
    s = np.clip((b * t - c) / np.maximum(a, tiny), 0.0, 1.0)
    gap = between + s[:, None] * along1 - t[:, None] * along2
    return np.sqrt(_dot(gap, gap))


def _dot(one: Array, other: Array) -> Array:
    product: Array = np.einsum("ij,ij->i", one, other)
    return product
