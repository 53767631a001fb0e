"""Cameras: what they see and when, and where they are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
import pytest

from aioduco.devices.cameras import (
    BoardSize,
    CameraDevice,
    Intrinsics,
    OpenCvCamera,
    SimulatedCamera,
    calibrate_hand_eye,
    find_board,
)
from aioduco.errors import CalibrationError, CameraError, ParameterError
from aioduco.kinematics import arm as arm_of
from aioduco.models.rotation import matrix_from_rotvec, rotvec_from_matrix
from aioduco.sim import Simulator
from aioduco.sim.scene import Box, mjcf_of

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

READY = np.array((0.0, 0.0, np.pi / 2, 0.0, -np.pi / 2, 0.0))


def pose(rotvec: Any, place: Any) -> Matrix:
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = matrix_from_rotvec(np.asarray(rotvec, dtype=float)), place
    return made


def apart(one: Matrix, other: Matrix) -> tuple[float, float]:
    difference = np.linalg.inv(one) @ other
    angle = np.linalg.norm(rotvec_from_matrix(difference[:3, :3]))
    return float(np.linalg.norm(difference[:3, 3])), float(angle)


@pytest.mark.parametrize("mounted", ["flange", "beside"])
def test_the_camera_is_found_from_noisy_views(mounted: Any) -> None:
    """On the flange or beside the arm, within a millimetre; wrong views are told."""
    rng = np.random.default_rng(7)
    arm = arm_of("gcr5_910")
    hands = arm.fkine(READY + rng.uniform(-0.5, 0.5, (20, 6)))
    camera, board = pose((0.1, -0.2, 1.5), (0.03, -0.05, 0.06)), pose((3.0, 0.2, 0.1), (0.5, 0, 0))
    moved = hands if mounted == "flange" else np.linalg.inv(hands)
    exact = np.linalg.inv(moved @ camera) @ board
    seen = np.array([one @ pose(rng.normal(0, 1e-3, 3), rng.normal(0, 5e-4, 3)) for one in exact])
    found = calibrate_hand_eye(hands, seen, mounted=mounted)
    distance, angle = apart(camera, found.camera)
    assert distance < 1.5e-3
    assert angle < 1.5e-3
    assert apart(board, found.board)[0] < 2e-3
    assert 1e-5 < max(found.distances) < 5e-3
    perfect = calibrate_hand_eye(hands, exact, mounted=mounted)
    assert apart(camera, perfect.camera)[0] < 1e-6

    swapped = seen.copy()
    swapped[[3, 4]] = seen[[4, 3]]
    with pytest.raises(CalibrationError, match="disagree"):
        calibrate_hand_eye(hands, swapped, mounted=mounted)


def test_views_that_tell_nothing_are_refused() -> None:
    arm = arm_of("gcr5_910")
    around = np.array([READY + 0.1 * i * np.eye(6)[0] for i in range(6)])
    hands = arm.fkine(around)
    with pytest.raises(CalibrationError, match="one axis"):
        calibrate_hand_eye(hands, hands)
    with pytest.raises(ParameterError, match="flanges"):
        calibrate_hand_eye(hands[:3], hands[:3])
    with pytest.raises(ParameterError, match="boards"):
        calibrate_hand_eye(hands, hands[:5])
    with pytest.raises(ParameterError, match="mounted"):
        calibrate_hand_eye(hands, hands, mounted="above")  # type: ignore[arg-type]  # a wrong value is the point


def test_pixels_and_points() -> None:
    lens = Intrinsics(width=64, height=48, fx=50.0, fy=52.0, cx=31.5, cy=23.5)
    there = lens.point(10.0, 40.0, 0.7)
    np.testing.assert_allclose(lens.project(there), (10.0, 40.0))
    assert there[2] == 0.7
    with pytest.raises(ParameterError, match="fx"):
        Intrinsics(width=64, height=48, fx=0.0, fy=52.0, cx=31.5, cy=23.5)


class StoodClock:
    """A robot's clock that stands."""

    def now(self) -> float:
        return 12.5

    def hold(self, at: float) -> Any:
        raise AssertionError


def test_a_camera_of_opencv(tmp_path: Path) -> None:
    """A file stands for the camera: colours, times, and what goes wrong."""
    file = str(tmp_path / "pictures.avi")
    writer = cv2.VideoWriter(file, cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (64, 48))
    for _ in range(2):
        writer.write(np.full((48, 64, 3), (20, 40, 200), np.uint8))  # blue, green, red
    writer.release()
    lens = Intrinsics(width=64, height=48, fx=50.0, fy=50.0, cx=31.5, cy=23.5)
    camera = OpenCvCamera(file, lens, clock=StoodClock(), latency=0.25)
    assert isinstance(camera, CameraDevice)
    with pytest.raises(CameraError, match="not open"):
        camera.read()
    with camera:
        frame = camera.read()
        assert frame.time == 12.25
        assert frame.depth is None
        assert np.abs(frame.image.mean(axis=(0, 1)) - (200, 40, 20)).max() < 8
        with pytest.raises(CameraError, match="open already"):
            camera.__enter__()
        camera.read()  # the next picture: it was not opened again
        with pytest.raises(CameraError, match="no picture"):
            camera.read()
    with pytest.raises(CameraError, match="no camera"), OpenCvCamera("/nowhere.avi", lens):
        pass
    wide = Intrinsics(width=32, height=48, fx=50.0, fy=50.0, cx=15.5, cy=23.5)
    with OpenCvCamera(file, wide) as wrong, pytest.raises(CameraError, match="shape"):
        wrong.read()


BOARD = BoardSize(6, 5, 0.03)


def board_scene() -> str:
    """A chessboard on the floor at (0.5, 0.1), and a box beside it."""
    squares = [
        Box(at=(0.5 + 0.03 * (i - 3), 0.1 + 0.03 * (j - 2.5), 0.0112), size=(0.03, 0.03, 0.001),
            colour=(0.02, 0.02, 0.02))
        for i in range(7) for j in range(6) if (i + j) % 2
    ]  # fmt: skip
    plate = Box(at=(0.5, 0.1, 0.01), size=(0.3, 0.28, 0.002), colour=(1.0, 1.0, 1.0))
    return mjcf_of([plate, *squares])


EYE = '<mujoco><worldbody><camera name="eye" pos="0.05 0.02 0.03" quat="0 0.9962 0.0872 0" \
fovy="55"/></worldbody></mujoco>'


@pytest.mark.slow
def test_a_simulated_camera_is_found_by_its_views_of_a_board() -> None:
    """Depth and time, too; the controller's cycle goes on meanwhile."""
    rng = np.random.default_rng(3)
    arm = arm_of("gcr5_910")
    with Simulator(scene=board_scene(), tool=EYE) as sim:
        with pytest.raises(ParameterError, match="name"):
            SimulatedCamera(sim, "nose")
        eye = SimulatedCamera(sim, "eye", width=960, height=720, depth=True)
        assert isinstance(eye, CameraDevice)
        truth = np.linalg.inv(arm.fkine(sim.joints.array)) @ eye.pose
        before = sim.statistics().cycles, sim.time
        first = eye.read()
        assert before[1] <= first.time <= sim.time
        assert first.depth is not None
        seen = find_board(first, BOARD)
        assert seen is not None
        column, row = eye.intrinsics.project(seen[:3, 3]).round().astype(int)
        assert abs(first.depth[row, column] - seen[2, 3]) < 3e-3
        hands, boards = [], []
        shown = sim.positions
        for _ in range(14):
            q = READY + rng.uniform(-0.12, 0.12, 6) + (0, 0, 0, 0, 0, rng.uniform(-0.5, 0.5))
            shown[:6] = q
            image = sim.render(camera="eye", positions=shown, width=960, height=720)
            view = find_board(first._replace(image=image), BOARD)
            if view is not None:
                hands.append(arm.fkine(q))
                boards.append(view)
        assert len(hands) >= 6
        found = calibrate_hand_eye(np.array(hands), np.array(boards))
        distance, angle = apart(truth, found.camera)
        assert distance < 3e-3
        assert angle < 5e-3
