"""Tip and axes of simulated tools, and the stated uncertainty."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from for_each import for_each

from aioduco import Pose
from aioduco.errors import CalibrationError, ParameterError
from aioduco.kinematics import arm, calibrate_tool_axes, calibrate_tool_tip
from aioduco.models.rotation import matrix_from_rotvec

DOWN = matrix_from_rotvec(np.array([np.pi, 0.0, 0.0]))


def touching(count: int = 6, tilt: float = 0.8) -> np.ndarray:
    """Orientations of a flange that is tilted to all sides, and turned in between."""
    sides = 2 * np.pi * np.arange(count) / count
    tilts = tilt * np.column_stack([np.cos(sides), np.sin(sides), 0.0 * sides])
    turns = np.outer(1.9 * np.arange(count), [0.0, 0.0, 1.0])
    return DOWN @ matrix_from_rotvec(tilts) @ matrix_from_rotvec(turns)


def touches(
    turns: np.ndarray, tip: np.ndarray, point: np.ndarray, noise: np.ndarray | float
) -> np.ndarray:
    """Poses of a flange whose tool touches a point."""
    frames = np.tile(np.eye(4), (len(turns), 1, 1))
    frames[:, :3, :3] = turns
    frames[:, :3, 3] = point - turns @ tip + noise
    return frames


def test_a_hidden_tip_is_found_within_what_is_stated(thorough: bool) -> None:
    turns, off, stated = touching(), [], []
    for seed in range(400 if thorough else 100):
        draw = np.random.default_rng(seed)
        tip, point = draw.uniform(-0.2, 0.2, 3), draw.uniform(-0.5, 0.5, 3)
        noise = draw.normal(0.0, 0.1e-3 / np.sqrt(3.0), (6, 3))  # 0.1 mm together
        found = calibrate_tool_tip(touches(turns, tip, point, noise))
        off.append(np.linalg.norm(found.tip - tip))
        stated.append(found.uncertainty)
        assert np.linalg.norm(found.point - point) < 0.2e-3
    assert max(off) < 0.2e-3
    low, high = (0.92, 0.98) if thorough else (0.88, 1.0)
    assert low < np.mean(np.array(off) < stated) < high
    assert np.median(stated) < 0.12e-3


@pytest.mark.slow
def test_an_uneven_set_states_its_uncertainty_too() -> None:
    turns, held = touching(5, 0.5), 0
    for seed in range(400):
        draw = np.random.default_rng(seed)
        tip = draw.uniform(-0.2, 0.2, 3)
        given = touches(turns, tip, np.ones(3), draw.normal(0.0, 0.1e-3, (5, 3)))
        found = calibrate_tool_tip(given)
        held += bool(np.linalg.norm(found.tip - tip) < found.uncertainty)
    assert 0.92 < held / 400 < 0.99


@pytest.mark.slow
def test_the_axes_are_found_within_what_is_stated() -> None:
    turns, held = touching(), np.zeros(2)
    for seed in range(200):
        draw = np.random.default_rng(seed)
        tip, point = draw.uniform(-0.2, 0.2, 3), draw.uniform(-0.5, 0.5, 3)
        tool = matrix_from_rotvec(draw.uniform(-1.0, 1.0, 3))
        found = calibrate_tool_tip(touches(turns, tip, point, draw.normal(0.0, 5e-5, (6, 3))))
        ahead, beside = (
            touches(turns[:1], tip + tool @ to, point, draw.normal(0.0, 5e-5, 3))[0]
            for to in ((0.0, 0.0, 0.06), (0.05, 0.0, 0.06))
        )
        axes = calibrate_tool_axes(found, ahead, beside)
        assert np.allclose(axes.frame.position, found.tip)
        error = tool.T @ axes.frame.rotation
        tilt, turn = np.arccos(min(1.0, error[2, 2])), np.arctan2(error[1, 0], error[0, 0])
        held += np.array([tilt, abs(turn)]) < axes.uncertainty
        assert max(axes.uncertainty) < 0.02
    assert (held / 200 > 0.93).all()


def test_poses_and_joints_of_an_arm_serve_as_touches() -> None:
    gcr5, tip = arm("gcr5_910"), np.array([0.01, -0.02, 0.15])
    point = gcr5.fkine([0.0, 0.0, 1.57, 0.0, -1.57, 0.0])[:3, 3] - (0.0, 0.0, 0.1)
    frames = touches(touching(), tip, point, 0.0)
    reached = [gcr5.fkine(gcr5.ikine(frame, [0.0, 0.0, 1.57, 0.0, -1.57, 0.0])) for frame in frames]
    found = calibrate_tool_tip([Pose.from_matrix(frame) for frame in reached])
    assert np.allclose(found.tip, tip)
    assert max(found.distances) < 1e-9


@for_each(
    "turns, said",
    [
        (np.tile(DOWN, (6, 1, 1)), "hardly turn the tool"),
        (touching(6, 0.05) @ np.swapaxes(touching(6, 0.0), 1, 2) @ DOWN, "hardly turn the tool"),
        (touching(6, 0.0), "about one axis alone"),
        (matrix_from_rotvec(np.outer(np.linspace(-1, 1, 6), [0.0, 1.0, 0.0])), "one axis alone"),
    ],
)
def test_touches_that_leave_the_tip_open_are_refused(turns: np.ndarray, said: str) -> None:
    draw = np.random.default_rng(0)
    given = touches(turns, np.full(3, 0.1), np.ones(3), draw.normal(0.0, 1e-4, (6, 3)))
    with pytest.raises(CalibrationError, match=said) as caught:
        calibrate_tool_tip(given)
    assert "tilt" in str(caught.value)


def test_a_touch_that_slipped_is_named() -> None:
    given = touches(touching(), np.full(3, 0.1), np.ones(3), 0.0)
    given[3, :3, 3] += (0.0, 0.01, 0.0)
    with pytest.raises(CalibrationError, match="in touch 4 it is"):
        calibrate_tool_tip(given)


def test_axes_from_positions_too_close_are_refused() -> None:
    found = calibrate_tool_tip(touches(touching(), np.full(3, 0.1), np.ones(3), 0.0))

    def at(*to: float) -> np.ndarray:
        found: np.ndarray = touches(touching()[:1], np.full(3, 0.1) + to, np.ones(3), 0.0)[0]
        return found

    with pytest.raises(CalibrationError, match=r"drawn back by only 5\.0 mm"):
        calibrate_tool_axes(found, at(0.0, 0.0, 0.005), at(0.05, 0.0, 0.05))
    with pytest.raises(CalibrationError, match=r"only 2\.0 mm beside"):
        calibrate_tool_axes(found, at(0.0, 0.0, 0.05), at(0.002, 0.0, 0.05))


def test_wrong_arguments_are_refused() -> None:
    given = touches(touching(), np.full(3, 0.1), np.ones(3), 0.0)
    with pytest.raises(ParameterError, match="3 touches"):
        calibrate_tool_tip(given[:3])
    for limit in (0.0, np.inf, None, "2 mm"):
        with pytest.raises(ParameterError, match="limit"):
            calibrate_tool_tip(given, limit=limit)  # type: ignore[arg-type]  # what is tested
    missing: Any = [given[0], None, *given[2:]]
    with pytest.raises(ParameterError, match="in touch 1 a rigid frame"):
        calibrate_tool_tip(missing)
