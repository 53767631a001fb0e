"""Taught points in a file: what is written is what is read, and nothing is lost on the way."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco import Joints, Pose, TaughtPoints
from aioduco.errors import ParameterError

HOME = Joints.deg(30, -15, 105, 0, -90, 0)
ABOVE = Pose(0.4, 0.1, 0.3, math.pi, 0.0, 1e-17)


def test_points_come_back_as_they_were_saved_in_their_order(tmp_path: Path) -> None:
    file = tmp_path / "cell.toml"
    points = TaughtPoints({"home": HOME})
    points["above the bin"] = ABOVE
    points.save(file)
    again = TaughtPoints.load(file)
    assert dict(again) == {"home": HOME, "above the bin": ABOVE}
    assert (again.joints("home"), again.pose("above the bin")) == (HOME, ABOVE)
    del again["home"]
    again.save(file)
    assert list(TaughtPoints.load(file)) == ["above the bin"]
    assert [path.name for path in tmp_path.iterdir()] == ["cell.toml"]


# Any text but halves of surrogates, which no file can hold.
#: of one line, with letters and signs of all scripts
NAMES = st.text(
    st.characters(codec="utf-8", exclude_categories=("C", "Zl", "Zp")), min_size=1, max_size=8
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("points")


@given(names=st.lists(NAMES, unique=True, max_size=4))
def test_any_name_can_be_saved(folder: Path, names: list[str]) -> None:
    TaughtPoints(dict.fromkeys(names, HOME)).save(folder / "any.toml")
    assert list(TaughtPoints.load(folder / "any.toml")) == names


@for_each(
    "text, says",
    [
        ("home = 3", "home"),
        ("[home]\njoints = [1, 2, 3]", "six"),
        ("[home]\njoints = [1, 2, 3, 4, 5, nan]", "finite"),
        ("[home]\njoints = [1, 2, 3, 4, 5, true]", "six numbers"),
        ("[home]\nangles = [1, 2, 3, 4, 5, 6]", "joints, joints_deg, pose"),
        (
            "[home]\njoints = [0,0,0,0,0,0]\npose = [0,0,0,0,0,0]",
            "joints, joints_deg, pose or pose_mm_deg",
        ),
        ("[home", "a TOML file"),
    ],
)
def test_what_is_wrong_in_a_file_is_said(tmp_path: Path, text: str, says: str) -> None:
    file = tmp_path / "cell.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ParameterError, match=says):
        TaughtPoints.load(file)


def test_only_points_have_a_name_and_only_the_kind_that_is_there() -> None:
    points = TaughtPoints({"home": HOME, "above": ABOVE})
    for name, point in (("", HOME), ("home", [0.0] * 6), (3, HOME)):
        with pytest.raises(ParameterError):
            points[name] = point  # type: ignore[index, assignment]  # wrong on purpose
    for wrong in list[Any](["hone", ["home"]]):
        with pytest.raises(ParameterError, match="home, above"):
            points.joints(wrong)
    with pytest.raises(ParameterError, match="a pose"):
        points.joints("above")
    with pytest.raises(ParameterError, match="joint angles"):
        points.pose("home")
