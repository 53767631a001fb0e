"""Cameras: what they see and when, and where they are."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from for_each import for_each
from interpreter import python
from numpy.typing import NDArray

from aioduco import Pose
from aioduco.devices.cameras import (
    BoardSize,
    CameraDevice,
    CameraFrame,
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

Matrix = NDArray[np.float64]

BOARD = BoardSize(6, 5, 0.03)
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


def views(rng: Any, turns: Any) -> tuple[Matrix, Matrix, Matrix, Matrix]:
    """Flanges with rotations about their own axes, a hidden camera, a board, and what is seen."""
    down = pose((np.pi, 0, 0), (0, 0, 0))
    flanges = np.array([down @ pose(turn, (0, 0, 0)) for turn in turns])
    flanges[:, :3, 3] = rng.normal((0.4, 0, 0.5), 0.1, (len(flanges), 3))
    camera, board = (
        pose(rng.normal(0, 1.0, 3), rng.normal(0, 0.05, 3)),
        pose((0, 0, 0.3), (0.5, 0.1, 0)),
    )
    return flanges, camera, board, np.linalg.inv(flanges @ camera) @ board


def with_half_turns(tilts: Any) -> list[Any]:
    """Tilts about x and y, each without and with joint 6 turned by half a turn."""
    made = [pose((*tilt, 0), (0, 0, 0)) @ pose((0, 0, k * np.pi), (0, 0, 0))
            for tilt in tilts for k in (0, 1)]  # fmt: skip
    return [rotvec_from_matrix(one[:3, :3]) for one in made]


@for_each(
    "seed, tilts",
    product(
        range(5),
        [
            [(0, 0), (0.35, 0), (0, 0.35)],
            [(-0.4, 0), (-0.2, 0), (0.2, 0), (0, 0.4)],
            [(np.pi, 0), (0.3, 0), (0, 0.3)],
        ],
    ),
)
def test_half_turns_of_the_wrist_are_views_like_others(tilts: Any, seed: int) -> None:
    flanges, camera, board, seen = views(np.random.default_rng(seed), with_half_turns(tilts))
    found = calibrate_hand_eye(flanges, seen)
    assert max(apart(camera, found.camera)) < 1e-9
    assert max(apart(board, found.board)) < 1e-9
    rng = np.random.default_rng(seed)
    noisy = [one @ pose(rng.normal(0, 1e-3, 3), rng.normal(0, 5e-4, 3)) for one in seen]
    found = calibrate_hand_eye(flanges, noisy)
    assert apart(camera, found.camera)[0] < found.uncertainty[0] < 0.05


@pytest.mark.parametrize("mounted", ["flange", "beside"])
@pytest.mark.parametrize(
    "turns",
    [
        np.pi * np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]),
        np.pi * np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 0), (0, 0, 0)]),
        # One half turn, and turns about another axis, which is square to it.
        [(0, 0, 0), (0, 0, np.pi), (0.3, 0, 0), (-0.5, 0, 0)],
    ],
)
@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_half_turns_alone_say_what_is_missing(mounted: Any, turns: Any, noise: float) -> None:
    rng = np.random.default_rng(1)
    flanges, camera, board, seen = views(rng, turns)
    if mounted == "beside":
        flanges = np.linalg.inv(flanges).astype(np.float64)
        seen = np.linalg.inv(np.linalg.inv(flanges) @ camera) @ board
    noisy = [one @ pose(rng.normal(0, noise, 3), rng.normal(0, noise, 3)) for one in seen]
    with pytest.raises(CalibrationError, match=r"half turns alone.*add views"):
        calibrate_hand_eye(flanges, noisy, mounted=mounted)


@pytest.mark.slow
@pytest.mark.parametrize("noise", ["of the board", "in the camera", "in depth", "of the flange"])
def test_the_uncertainty_holds_for_hidden_cameras(noise: str) -> None:
    """In 95 % of the calibrations at least, whatever is noisy; and it is of the error's size."""
    arm, counts = arm_of("gcr5_910"), (4, 7, 15)
    within, ratios = np.zeros((300, 2), dtype=bool), np.zeros(300)
    for seed in range(300):
        rng, count = np.random.default_rng(seed), counts[seed % 3]
        flanges = arm.fkine(READY + rng.uniform(-0.5, 0.5, (count, 6)))
        camera = pose(rng.normal(0, 1.0, 3), rng.normal(0, 0.06, 3))
        board = pose(rng.normal(0, 1.0, 3), (flanges @ camera)[:, :3, 3].mean(axis=0) - 0.3)
        seen = np.linalg.inv(flanges @ camera) @ board
        small = [pose(rng.normal(0, 1e-3, 3), rng.normal(0, 3e-4, 3)) for _ in seen]
        if noise == "of the board":
            seen = seen @ small
        elif noise == "in the camera":
            seen = small @ seen
        elif noise == "in depth":
            seen[:, 2, 3] += rng.normal(0, 1e-3, count)
            seen = seen @ [pose(rng.normal(0, 1e-3, 3), (0, 0, 0)) for _ in seen]
        else:
            flanges = flanges @ small
        found = calibrate_hand_eye(flanges, seen, limits=(0.05, 0.2))
        error = np.array(apart(camera, found.camera))
        within[seed], ratios[seed] = error <= found.uncertainty, found.uncertainty[0] / error[0]
    assert within.mean(axis=0).min() >= 0.95
    for each, _ in enumerate(counts):
        assert within[each::3].mean(axis=0).min() >= 0.91
        assert np.median(ratios[each::3]) < 12.0


@pytest.mark.slow
def test_it_is_not_worse_than_any_method_of_opencv() -> None:
    """On the same noisy views, with half turns of the wrist and without."""
    methods = [getattr(cv2, f"CALIB_HAND_EYE_{name}")
               for name in ("TSAI", "PARK", "HORAUD", "ANDREFF", "DANIILIDIS")]  # fmt: skip
    ours, theirs = [], []
    tilts = [(0, 0), (0.35, 0), (0, 0.35), (-0.4, 0), (0, -0.3)]
    for seed in range(30):
        rng = np.random.default_rng(seed)
        turns = with_half_turns(tilts) if seed % 2 else rng.normal(0, 0.4, (10, 3))
        flanges, camera, _, seen = views(rng, turns)
        seen = np.array([one @ pose(rng.normal(0, 1e-3, 3), rng.normal(0, 5e-4, 3))
                         for one in seen])  # fmt: skip
        ours.append(apart(camera, calibrate_hand_eye(flanges, seen).camera)[0])
        row = []
        for method in methods:
            turn, place = cv2.calibrateHandEye(
                list(flanges[:, :3, :3]), list(flanges[:, :3, 3]),
                list(seen[:, :3, :3]), list(seen[:, :3, 3]), method=method,
            )  # fmt: skip
            other = np.eye(4)
            other[:3, :3], other[:3, 3] = turn, np.ravel(place)
            row.append(np.linalg.norm(other[:3, 3] - camera[:3, 3]))
        theirs.append(row)
    assert np.median(ours) <= 1.02 * np.median(np.array(theirs), axis=0).min()


def test_flanges_are_poses_or_matrices() -> None:
    flanges, camera, _, seen = views(
        np.random.default_rng(2), np.random.default_rng(3).normal(0, 0.4, (6, 3))
    )
    poses = [Pose.from_matrix(one) for one in flanges]
    given: list[Any] = [poses, [*poses[:3], *flanges[3:]], [tuple(one) for one in poses],
                        [one.array for one in poses], flanges.astype(np.float32),
                        flanges.tolist()]  # fmt: skip
    for hands in given:
        found = calibrate_hand_eye(hands, [Pose.from_matrix(one) for one in seen])
        assert max(apart(camera, found.camera)) < 1e-5


def test_frames_that_are_none_are_refused() -> None:
    flanges, _, _, seen = views(
        np.random.default_rng(2), np.random.default_rng(3).normal(0, 0.4, (6, 3))
    )
    scaled, mirrored, transposed, none = (flanges.copy() for _ in range(4))
    scaled[2, :3, :3] *= 1.01
    mirrored[2, :3, 0] *= -1.0
    transposed[2] = transposed[2].T
    none[2, 0, 0] = np.nan
    wrong: list[Any] = [scaled, mirrored, transposed, none, [*flanges[:2], "pose", *flanges[3:]],
                        [*flanges[:2], None, *flanges[3:]], flanges[:, :3]]  # fmt: skip
    for hands in wrong:
        with pytest.raises(ParameterError, match="flanges"):
            calibrate_hand_eye(hands, seen)
        with pytest.raises(ParameterError, match="boards"):
            calibrate_hand_eye(flanges, hands)
    for limits in ((0.0, 0.02), (np.nan, 0.02), (0.005,), 0.005, ("5 mm", 0.02)):
        with pytest.raises(ParameterError, match="limits"):
            calibrate_hand_eye(flanges, seen, limits=limits)  # type: ignore[arg-type]  # wrong values are the point


def drawn(lens: Intrinsics) -> Any:
    """An image of a board, and the board's pose."""
    place = (np.array([0.2, 0.1, 0.05]), np.array([-0.08, -0.06, 0.5]))
    image = np.full((lens.height, lens.width, 3), 255, np.uint8)
    for i in range(-1, 6):
        for j in range(-1, 5):
            if (i + j) % 2 == 0:
                corners = np.array([[i, j, 0], [i + 1, j, 0], [i + 1, j + 1, 0], [i, j + 1, 0]])
                pixels = cv2.projectPoints(0.03 * corners, *place, lens.matrix, None)[0]
                cv2.fillPoly(image, [pixels.astype(np.int32)], (0, 0, 0))
    return image, pose(*place)


@pytest.mark.parametrize(
    "distortion",
    [(), None, np.zeros((1, 5)), np.zeros((5, 1)), np.zeros(14, np.float32), [0, 0, 0, 0]],
)
def test_a_board_is_found_with_any_form_of_a_lens_and_of_a_picture(distortion: Any) -> None:
    width: Any = np.int64(640)  # as arrays give them
    focus: Any = np.float32(600)
    lens = Intrinsics(
        width=width,
        height=480, fx=focus, fy=600, cx=320, cy=240, distortion=distortion,
    )  # fmt: skip
    image, truth = drawn(lens)
    grey = image[:, :, 0]
    for one in (image, grey, grey[:, :, None], np.dstack([image, grey]), image[:, ::-1][:, ::-1]):
        found = find_board(CameraFrame(one, None, 0.0, lens), BOARD)
        assert found is not None
        assert apart(truth, found)[0] < 5e-3
    for wrong in (image[:400], image / 255.0, image[:, :, :2], image[0], image.astype(np.uint16)):
        with pytest.raises(ParameterError, match="frame"):
            find_board(CameraFrame(wrong, None, 0.0, lens), BOARD)
    with pytest.raises(ParameterError, match="frame"):
        find_board(image, BOARD)
    with pytest.raises(ParameterError, match="size"):
        find_board(CameraFrame(image, None, 0.0, lens), (6, 5))  # type: ignore[arg-type]


@pytest.mark.parametrize("smaller", [4, 9])
def test_a_small_board_is_as_far_away_as_it_is(smaller: int) -> None:
    """Each corner was looked for among its neighbours: a board of small squares was elsewhere."""
    lens = Intrinsics(width=144 * 8, height=90 * 8, fx=900, fy=900, cx=575.5, cy=359.5)
    image, truth = drawn(lens)
    size = lens.width // smaller, lens.height // smaller
    small = Intrinsics(
        width=size[0], height=size[1], fx=900 / smaller, fy=900 / smaller,
        cx=576 / smaller - 0.5, cy=360 / smaller - 0.5,
    )  # fmt: skip
    shown = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)
    found = find_board(CameraFrame(shown, None, 0.0, small), BOARD)
    assert found is not None
    assert apart(truth, found)[0] < 3e-3


@for_each("name, value", [
        *((name, value) for name in ("width", "height", "fx", "fy", "cx", "cy")
          for value in (np.nan, np.inf, "a", None, np.zeros(2))),
        *((name, value) for name in ("width", "height") for value in (0, -1, 1.5)),
        *(("distortion", value) for value in ((0.1,), np.zeros((2, 3)), (0, 0, 0, np.nan), "none")),
        *(("distortion", value) for value in ([[0, 0], [0, 0, 0]], 4 * [np.timedelta64(1, "ns")])),
    ])  # fmt: skip
def test_intrinsics_that_are_none_are_refused(name: str, value: Any) -> None:
    good = {"width": 64, "height": 48, "fx": 50.0, "fy": 52.0, "cx": 31.5, "cy": 23.5}
    with pytest.raises(ParameterError, match=name):
        Intrinsics(**{**good, name: value})


@for_each(
    "size",
    [
        (2, 5, 0.03),
        (6.5, 5, 0.03),
        (6, 4, 0.03),
        (7, 5, 0.03),
        (6, 5, 0),
        (6, 5, np.nan),
        (6, 5, "a"),
        (6, 5, 30),
    ],
)
def test_boards_that_are_none_are_refused(size: Any) -> None:
    with pytest.raises(ParameterError):
        BoardSize(*size)


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


@for_each("simulator", [Simulator.spawn(), None])
def test_a_simulated_camera_is_of_a_simulator_of_this_process(simulator: Any) -> None:
    with pytest.raises(ParameterError, match="a Simulator of this process"):
        SimulatedCamera(simulator, "eye")


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


_MANY_THREADS = """
import sys, threading
import cv2, numpy as np
from aioduco.devices.cameras import Intrinsics, OpenCvCamera
from aioduco.errors import CameraError

lens = Intrinsics(width=640, height=480, fx=500, fy=500, cx=320, cy=240)
writer = cv2.VideoWriter(sys.argv[1], cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (640, 480))
for _ in range(300):
    writer.write(np.zeros((480, 640, 3), np.uint8))
writer.release()
seen = []

def look():
    try:
        while True:
            seen.append(camera.read().image.shape)
    except CameraError:
        return

with OpenCvCamera(sys.argv[1], lens) as camera:
    threads = [threading.Thread(target=look) for _ in range(4)]
    for each in threads:
        each.start()
    threads[0].join(0.05)
for each in threads:
    each.join()
print(set(seen))
"""


@pytest.mark.slow
def test_threads_may_read_a_camera_at_once_and_while_it_is_closed(tmp_path: Path) -> None:
    """OpenCV's capture is for one thread: the interpreter crashed."""
    found = python("-c", _MANY_THREADS, str(tmp_path / "film.avi"))
    assert (found.returncode, found.stdout.strip()) == (0, "{(480, 640, 3)}"), found.stderr
