"""Pictures of the arm. They need an OpenGL that draws off screen, such as Mesa's in software."""

from __future__ import annotations

import contextlib
import math
import sys
import types
from collections.abc import Iterator
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from aioduco.errors import ParameterError, RenderError
from aioduco.kinematics import arm
from aioduco.models.pose import Pose
from aioduco.sim.scene import Box
from aioduco.sim.simulator import Simulator
from aioduco.sim.view import viewer
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


def test_what_cannot_be_drawn_is_refused(sim: Simulator) -> None:
    for width, height in ((0, 100), (1921, 100), (100, 1081)):
        with pytest.raises(ParameterError, match="size"):
            sim.render(width=width, height=height)
    with pytest.raises(ParameterError, match="positions"):
        sim.render(positions=np.zeros(7))
    with pytest.raises(RuntimeError, match="not running"):
        Simulator().render()


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
    assert film.frames == []
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


class Window:
    """What `launch_passive` gives, as far as it is used."""

    def __init__(self, model: Any, data: Any, **_: bool) -> None:
        self.data = data
        self.open = True
        self.shown: list[list[float]] = []
        self.cam = types.SimpleNamespace(
            lookat=np.zeros(3), distance=0.0, azimuth=0.0, elevation=0.0
        )

    def lock(self) -> AbstractContextManager[None]:
        return contextlib.nullcontext()

    def is_running(self) -> bool:
        return self.open

    def sync(self) -> None:
        self.shown.append(self.data.qpos.tolist())

    def close(self) -> None:
        self.open = False


@pytest.fixture
def display(monkeypatch: pytest.MonkeyPatch) -> None:
    module = types.ModuleType("mujoco.viewer")
    monkeypatch.setattr(module, "launch_passive", Window, raising=False)
    monkeypatch.setitem(sys.modules, "mujoco.viewer", module)
    monkeypatch.setattr(viewer, "need_display", lambda: None)


@pytest.mark.usefixtures("display")
def test_a_window_shows_where_the_arm_is() -> None:
    with Simulator() as sim:
        with sim.window() as window:
            assert window.running
            window.show()
            shown = window._window.shown  # the stand-in
            np.testing.assert_allclose(shown, [sim.joints], atol=1e-4)
            assert window._window.cam.distance > 1.0
        assert not window.running


@pytest.mark.slow
def test_a_camera_of_the_window_is_in_degrees() -> None:
    window = Window(None, None)
    Camera(azimuth=np.pi, elevation=-0.5 * np.pi, distance=3.0, target=(1.0, 2.0, 3.0)).put(
        window.cam
    )
    assert (window.cam.azimuth, window.cam.elevation) == pytest.approx((180.0, -90.0))
    assert (*window.cam.lookat, window.cam.distance) == (1.0, 2.0, 3.0, 3.0)


@pytest.mark.slow
def test_without_a_display_there_is_no_window(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with Simulator() as sim, pytest.raises(RenderError, match="there is no display"):
        sim.window()


@pytest.mark.slow
def test_a_display_that_is_not_there_is_no_window(monkeypatch: pytest.MonkeyPatch) -> None:
    glfw = types.ModuleType("glfw")
    monkeypatch.setattr(glfw, "init", lambda: False, raising=False)
    monkeypatch.setitem(sys.modules, "glfw", glfw)
    monkeypatch.setenv("DISPLAY", ":99")
    with pytest.raises(RenderError, match="no window can be opened"):
        viewer.need_display()
