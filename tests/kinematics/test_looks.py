"""The visual shapes of the arms: closed, near those that collide, in distinct colours."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from for_each import for_each

import aioduco.kinematics
from aioduco.kinematics import arm, models
from aioduco.kinematics.bodies import Capsule, bodies
from aioduco.kinematics.looks import COLOURS, Look, looks, merged
from aioduco.models.rotation import Array

WHERE = Path(aioduco.kinematics.__file__).parent


def volume(look: Look) -> float:
    a, b, c = np.moveaxis(look.vertices[look.faces], 1, 0)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def beyond(points: Array, parts: tuple[Capsule, ...]) -> float:
    """How far points lie outside capsules, at most [m]."""
    distances = []
    for start, end, radius, _ in parts:
        along = np.subtract(end, start)
        length = float(along @ along)
        share = (
            np.clip((points - start) @ along / length, 0, 1) if length else np.zeros(len(points))
        )
        near = np.asarray(start) + share[:, None] * along
        distances.append(np.linalg.norm(points - near, axis=1) - radius)
    return float(np.min(distances, axis=0).max())


@pytest.mark.parametrize("model", models())
def test_each_surface_is_closed_and_points_outwards(model: str) -> None:
    for look in (look for link in looks(arm(model)) for look in link):
        # points that are doubled along sharp edges are one place
        _, place = np.unique(look.vertices.round(7), axis=0, return_inverse=True)
        a, b, c = np.moveaxis(place.reshape(-1)[look.faces], 1, 0)
        edges = list(zip([*a, *b, *c], [*b, *c, *a], strict=True))
        assert len(set(edges)) == len(edges)
        assert {(end, start) for start, end in edges} == set(edges)
        assert volume(look) > 1e-8


@for_each("model", models())
def test_what_is_drawn_is_near_what_collides(model: str) -> None:
    known = arm(model)
    for link, body in zip(looks(known), bodies(known), strict=True):
        assert beyond(np.concatenate([look.vertices for look in link]), body.parts) < 0.0305


@for_each("model", models())
def test_the_arm_stands_on_its_foot_and_ends_at_its_flange(model: str) -> None:
    *_, flange = links = looks(arm(model))
    assert min(look.vertices[:, 2].min() for look in links[0]) == 0.0
    assert max(look.vertices[:, 2].max() for look in flange) == pytest.approx(0.0, abs=1e-12)


@for_each("model", models())
def test_each_joint_has_a_mark_that_turns_and_one_that_shows_its_zero(model: str) -> None:
    """On a dark ring about the axis; at zero both are in one direction from the axis."""
    known = arm(model)
    for (fixed, moving), body in zip(pairwise(looks(known)), bodies(known)[1:], strict=True):
        rings = [look for look in moving if look.colour == "cap"]
        on_axis = [ring for ring in rings if np.abs(ring.start[:2]).max() < 1e-9]
        assert on_axis
        turned = [look.vertices.mean(axis=0) for look in moving if look.colour == "mark"]
        shown = [
            (look.vertices.mean(axis=0) - body.position) @ body.rotation
            for look in fixed
            if look.colour == "mark"
        ]
        assert all(np.hypot(*mark[:2]) > 0.015 for mark in turned[:1])
        assert any(np.linalg.norm(mark - other) < 0.03 for mark in turned for other in shown)


def luminance(colour: tuple[float, float, float]) -> float:
    parts = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour]
    return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2]


def contrast(one: str, other: str) -> float:
    """Contrast of two colours, as in WCAG 2."""
    low, high = sorted(luminance(COLOURS[name]) for name in (one, other))
    return (high + 0.05) / (low + 0.05)


def test_caps_stand_out_from_bodies_and_marks_from_caps() -> None:
    assert contrast("cap", "body") > 4.5
    assert contrast("mark", "cap") > 4.5


def test_all_arms_take_less_than_200_kb() -> None:
    assert sum((WHERE / name).stat().st_size for name in ("looks.py", "arms.json")) < 200_000
    assert len(models()) == 13


def test_surfaces_of_one_colour_are_merged() -> None:
    link = looks(arm("gcr5_910"))[2]
    found = merged(link)
    assert list(found) == list(dict.fromkeys(look.colour for look in link))
    for colour, (points, faces) in found.items():
        same = [look for look in link if look.colour == colour]
        whole = Look(colour, points, faces, *same[0][3:])
        assert volume(whole) == pytest.approx(sum(map(volume, same)))
