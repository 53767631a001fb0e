"""How corners are blended, from set-points of motions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from aioduco.kinematics import arm
from aioduco.models.rotation import Array
from aioduco.sim.calibration.blends import estimate_blends
from aioduco.sim.calibration.evidence import Corner, Evidence, Motions
from aioduco.sim.planner.blending import CornerLaw, Corners
from aioduco.sim.planner.mover import Mover
from aioduco.sim.planner.segments import Segment, joint_move, line_move

from .made import MODEL, READY, SPEED_STEP, STEP, empty

ARM = arm(MODEL)
RADII = (0.02, 0.035)
JOINT_PACE, LINE_PACE = (0.47, 1.0), (0.22, 1.0)


def set_points(kind: str, places: tuple[Array, Array], radius: float, law: CornerLaw) -> Array:
    """Set-points and their speeds of two motions, every 8 ms. Shape (n, 2, 6)."""
    mover = Mover(ARM, READY, 1e-3, corners=Corners(law, law))
    for number, (place, r) in enumerate(zip(places, (radius, 0.0), strict=True)):

        def plan(q: Array, to: Array = place, r: float = r) -> Segment:
            if kind == "joint":
                return joint_move(ARM, q, to, *JOINT_PACE, r)
            return line_move(ARM, q, to, *LINE_PACE, r)

        mover.append(number, plan)
    rows = [(READY, np.zeros(6))] * 16
    while mover.moving:
        told = mover.tick().setpoint
        rows.append((told.q, told.qd))
    return np.array(rows)[::8]


@cache
def cut(
    kind: str, law: CornerLaw, radii: Sequence[float] = RADII, *, blended: bool = True
) -> Evidence:
    """Two corners with each radius, the other way round the second time."""
    rows, corners, now = [], [], 0.0
    for radius in radii:
        for ways in ((0, 2), (2, 0)) if kind == "joint" else ((2, 1), (1, 2)):
            if kind == "joint":
                first = READY + 0.3 * np.eye(6)[ways[0]]
                places = first, first + 0.3 * np.eye(6)[ways[1]]
                where = places
            else:
                first, second = ARM.fkine(READY), ARM.fkine(READY)
                first[ways[0], 3] += 0.1
                second[list(ways), 3] += 0.1
                places, where = (first, second), (first[:3, 3], second[:3, 3])
            pace = JOINT_PACE if kind == "joint" else LINE_PACE
            found = set_points(kind, places, radius if blended else 0.0, law)
            rows.append(found)
            end = now + 0.008 * len(found)
            corners.append(Corner(kind, now - 1e-4, end - 1e-4, *where, radius, *pace))
            now = end
    together = np.concatenate(rows)
    wanted = np.round(together[:, 0] / STEP) * STEP
    speed = np.round(together[:, 1] / SPEED_STEP) * SPEED_STEP
    time = 0.008 * np.arange(len(wanted), dtype=np.float64)
    motions = Motions(time, wanted, speed, wanted, speed)
    return replace(empty(), motions=motions, corners=tuple(corners), tool=np.eye(4))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["joint", "line"])
@pytest.mark.parametrize("law", [CornerLaw(), CornerLaw(0.6, 0.4), CornerLaw(1.1, 0.9)])
def test_reach_and_share_are_found_within_their_intervals(kind: str, law: CornerLaw) -> None:
    radii = (0.02, 0.027, 0.035)
    found = estimate_blends(ARM, [cut(kind, law, radii)])
    for name in law._fields:
        value, low, high = found.values[f"{kind}_{name}"]
        assert value == pytest.approx(getattr(law, name), rel=0.01)
        assert low <= getattr(law, name) <= high
    other = {"joint": "line", "line": "joint"}[kind]
    (said,) = found.missing
    assert said.startswith(f"blends, {other}: 0 corners were recorded, and 0 of them cut")
    assert f"{2 * len(radii)} corners" in found.notes[0]


@pytest.mark.slow
def test_a_share_is_not_claimed_where_the_speed_was_the_limit() -> None:
    run = cut("joint", CornerLaw())
    quick = tuple(each._replace(speed=0.1) for each in run.corners)
    found = estimate_blends(ARM, [replace(run, corners=quick)])
    assert found.values.keys() == {"joint_reach"}
    assert "the speed was the limit, or not reached, in 4 of 4 corners" in found.missing[0]


def test_corners_of_another_shape_are_left_out() -> None:
    run = cut("joint", CornerLaw())
    wanted = run.motions.wanted.copy()
    for corner in run.corners:  # a path that is nearer to the first line than to the second
        during = (run.motions.time > corner.begin) & (run.motions.time < corner.end)
        way = wanted[during] - corner.place
        both = (np.abs(way[:, [0, 2]]) > 1e-6).all(axis=1)
        way[both] *= 1.0 + 0.3 * np.sin(6.0 * np.arange(both.sum()) / both.sum())[:, None]
        wanted[during] = corner.place + way
    found = estimate_blends(ARM, [replace(run, motions=run.motions._replace(wanted=wanted))])
    assert found.values == {}
    assert "in another way than the simulator" in found.missing[0]


def wide() -> Evidence:
    run = cut("joint", CornerLaw())
    corners = tuple(each._replace(radius=each.radius / 3.0) for each in run.corners)
    return replace(run, corners=corners)


def about_the_tip() -> Evidence:
    run = cut("joint", CornerLaw())
    corners = (each._replace(after=each.place + 0.3 * np.eye(6)[5]) for each in run.corners)
    return replace(run, corners=tuple(corners))


@pytest.mark.parametrize(
    ("run", "said"),
    [
        pytest.param(
            lambda: cut("joint", CornerLaw(), blended=False),
            "4 corners were recorded, and 0 of them cut",
            id="the arm stopped",
        ),
        pytest.param(
            lambda: cut("joint", CornerLaw(), (0.03, 0.03)), "of two radii", id="one radius"
        ),
        pytest.param(wide, "which the simulator does not play", id="not in a profile"),
        pytest.param(about_the_tip, "", id="no radius"),
        pytest.param(lambda: replace(cut("line", CornerLaw()), tool=None), "", id="unknown tool"),
    ],
)
def test_corners_that_show_nothing_are_not_counted(run: Callable[[], Evidence], said: str) -> None:
    found = estimate_blends(ARM, [run()])
    assert found.values == {}
    assert said in found.missing[0]
