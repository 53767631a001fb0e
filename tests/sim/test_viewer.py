"""MuJoCo's window, with a stand-in for it: what is tested is what it is given to show."""

from __future__ import annotations

import contextlib
import sys
import types
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
import pytest

from aioduco.errors import RenderError
from aioduco.sim.simulator import Simulator
from aioduco.sim.view import viewer
from aioduco.sim.view.camera import Camera


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


def test_a_camera_of_the_window_is_in_degrees() -> None:
    window = Window(None, None)
    Camera(azimuth=np.pi, elevation=-0.5 * np.pi, distance=3.0, target=(1.0, 2.0, 3.0)).put(
        window.cam
    )
    assert (window.cam.azimuth, window.cam.elevation) == pytest.approx((180.0, -90.0))
    assert (*window.cam.lookat, window.cam.distance) == (1.0, 2.0, 3.0, 3.0)


def test_without_a_display_there_is_no_window(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with Simulator() as sim, pytest.raises(RenderError, match="there is no display"):
        sim.window()


def test_a_display_that_is_not_there_is_no_window(monkeypatch: pytest.MonkeyPatch) -> None:
    glfw = types.ModuleType("glfw")
    monkeypatch.setattr(glfw, "init", lambda: False, raising=False)
    monkeypatch.setitem(sys.modules, "glfw", glfw)
    monkeypatch.setenv("DISPLAY", ":99")
    with pytest.raises(RenderError, match="no window can be opened"):
        viewer.need_display()
