"""Pictures of the arm. They need an OpenGL that draws off screen, such as Mesa's in software."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from aioduco.errors import ParameterError, RenderError
from aioduco.kinematics import arm
from aioduco.models.pose import Pose
from aioduco.sim.scene import Box
from aioduco.sim.simulator import Simulator
from aioduco.sim.view.camera import Camera, towards
from aioduco.sim.view.drawing import advice
from aioduco.sim.view.film import Film

RED = Box(at=(0.4, -0.3, 0.3), size=(0.2, 0.2, 0.2), colour=(1.0, 0.0, 0.0))
CELL = f"""<mujoco><worldbody><camera name="above" pos="0.4 0 3" xyaxes="0 -1 0 1 0 0"/>
<geom type="box" pos="{RED.at[0]} {RED.at[1]} {RED.at[2]}" size=".1 .1 .1" rgba="1 0 0 1"/>
</worldbody></mujoco>"""


@pytest.fixture(scope="module")
def sim() -> Iterator[Simulator]:
    with Simulator(speed=math.inf, scene=CELL) as sim:
        yield sim


def share(picture: NDArray[np.uint8], colour: str) -> float:
    """How much of a picture is red, or blue as the joints are."""
    r, g, b = np.moveaxis(picture.astype(int), -1, 0)
    mask = (r > 2 * b) & (r > 2 * g) if colour == "red" else (b > 1.5 * r) & (b > 1.1 * g)
    return float(mask.mean())


@pytest.mark.slow
def test_a_picture_shows_arm_and_scene(sim: Simulator) -> None:
    picture = sim.render(width=320, height=240)
    assert picture.shape == (240, 320, 3)
    assert picture.dtype == np.uint8
    assert 0.002 < share(picture, "blue") < 0.2
    assert 0.002 < share(picture, "red") < 0.2
    assert picture[0].mean() > picture[-1].mean()  # the sky is brighter than the floor
    np.testing.assert_array_equal(picture, sim.render(width=320, height=240))
    away = Camera(target=(0.0, 0.0, 5.0), distance=1.0, elevation=math.radians(30.0))
    assert share(sim.render(width=320, height=240, camera=away), "blue") == 0.0


def test_a_camera_of_the_scene(sim: Simulator) -> None:
    picture = sim.render(width=200, height=200, camera="above")
    red = np.argwhere(picture[..., 0].astype(int) > 2 * picture[..., 2].astype(int))
    # From above, x of the world is up and its y is to the left: the box is right of the middle.
    assert 100 < red[:, 1].mean() < 200
    assert red[:, 0].mean() == pytest.approx(100, abs=15)
    with pytest.raises(ParameterError, match="above"):
        sim.render(camera="below")


def test_another_instant_is_drawn_from_its_positions(sim: Simulator) -> None:
    turned = sim.positions
    turned[0] += 1.5
    now, then = (sim.render(width=160, height=120, positions=q) for q in (None, turned))
    assert np.mean(np.abs(now.astype(int) - then).max(axis=-1) > 20) > 0.01


@pytest.mark.parametrize("size", [(0, 100), (1921, 100), (100, 1081)])
def test_a_size_that_cannot_be_drawn(sim: Simulator, size: tuple[int, int]) -> None:
    with pytest.raises(ParameterError, match="size"):
        sim.render(width=size[0], height=size[1])


@pytest.mark.slow
def test_the_simulation_goes_on_while_a_picture_is_drawn() -> None:
    with Simulator() as sim:
        sim.push([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])  # so that it does not sleep
        before = sim.statistics().cycles
        sim.render(width=320, height=240)
        assert sim.statistics().cycles > before + 10


@pytest.mark.slow
def test_without_opengl_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "nothing")
    with Simulator() as sim:
        for _ in range(2):
            with pytest.raises(RenderError, match="libegl1"):
                sim.render()


def test_without_pyopengl_it_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "libegl1" in advice()
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "OpenGL" else 1)
    assert "pip install 'aioduco[sim]'" in advice()


@pytest.mark.slow
def test_a_process_that_is_killed_is_said_and_replaced(sim: Simulator) -> None:
    sim.render(width=10, height=10)
    process = sim._running().pictures._process
    assert process is not None
    process.popen.kill()
    with pytest.raises(RenderError, match="has ended"):
        sim.render(width=10, height=10)
    assert sim.render(width=10, height=10).shape == (10, 10, 3)


def test_positions_of_another_arm_are_refused(sim: Simulator) -> None:
    with pytest.raises(ParameterError, match="positions"):
        sim.render(positions=np.zeros(7))


def test_a_picture_needs_a_running_simulator() -> None:
    with pytest.raises(RuntimeError, match="not running"):
        Simulator().render()


# -- where from, and which instants ------------------------------------------------------------


@pytest.mark.slow
def test_the_camera_looks_at_the_arm_wherever_it_is_mounted() -> None:
    five = arm("gcr5_910")
    for mounting in (Pose(0, 0, 0, 0, 0, 0), Pose(1.0, 2.0, 3.0, math.pi, 0.0, 0.0)):
        camera = towards(five, mounting)
        base = np.array(mounting[:3])
        assert 0.3 < np.linalg.norm(np.array(camera.target) - base) < five.reach
    wrong: dict[str, Any]
    for wrong in ({"distance": 0.0}, {"target": (0.0, 1.0)}, {"azimuth": math.nan}):
        with pytest.raises(ParameterError):
            Camera(**wrong)


@pytest.mark.slow
def test_a_film_leaves_out_what_looks_the_same() -> None:
    film = Film(rest=0.5)
    for time, position in ((0.0, 0.0), (0.1, 0.0), (0.2, 0.3), (5.0, 0.3), (5.1, 0.4), (5.2, 0.4)):
        film.add(time, np.array([position]))
    assert [frame.positions[0] for frame in film.frames] == [0.0, 0.3, 0.4]
    assert [frame.duration for frame in film.frames] == pytest.approx([0.2, 0.5, 0.1])


@pytest.mark.slow
def test_a_long_film_has_fewer_frames_to_the_second() -> None:
    film = Film(limit=50)
    for i in range(10_000):
        film.add(0.05 * i, np.array([0.1 * i]))
        assert len(film.frames) <= 51
    frames = film.frames
    assert len(frames) >= 20
    assert frames[0].positions[0] == 0.0
    assert frames[-1].positions[0] > 900.0
    steps = np.diff([frame.positions[0] for frame in frames])
    assert steps.max() < 3.0 * steps.min()


@pytest.mark.slow
def test_no_film_without_a_look() -> None:
    assert Film().frames == []
