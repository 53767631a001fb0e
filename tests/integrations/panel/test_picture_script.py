"""The script that draws the panel for its page: it leads a simulated arm in a browser."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

Image = pytest.importorskip("PIL.Image")
pytest.importorskip("playwright")
pytest.importorskip("viser")

SCRIPT = Path(__file__).resolve().parents[3] / "docs" / "panel_picture.py"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.browser,
    pytest.mark.timeout(900),
    pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium"),
]


def picture(path: Path) -> NDArray[Any]:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def colours(part: NDArray[Any]) -> int:
    return len(np.unique(part.reshape(-1, 3), axis=0))


def test_the_pictures_show_the_arm_in_mid_motion_at_each_width(tmp_path: Path) -> None:
    command = [sys.executable, str(SCRIPT), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=850, check=False)
    assert done.returncode == 0, done.stderr
    shown = {width: picture(tmp_path / f"panel-{width}.png") for width in (1440, 1020, 390)}
    assert {width: each.shape[1] for width, each in shown.items()} == {w: w for w in shown}
    wide = shown[1440]
    scene = wide[90:690, :980]
    assert colours(scene) > 2000, "the arm is drawn"
    # where the sliders point, translucent and green over the scene: it still has to get there
    red, green, blue = scene[..., 0], scene[..., 1], scene[..., 2]
    assert ((green > red + 25) & (green > blue + 10)).sum() > 400, "it moves"
    for width, each in shown.items():
        stop = (each[..., 0] > 200) & (each[..., 1] < 90) & (each[..., 2] < 90)
        assert stop.sum() > 4000, f"STOP is seen at {width} pixels"
    # a box of one colour covered most of it
    narrow = shown[390][150:235].reshape(-1, 3)
    most = np.unique(narrow, axis=0, return_counts=True)[1].max()
    assert most < 0.33 * len(narrow), "nothing lies over the narrow picture"
