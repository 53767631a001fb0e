"""The file of waypoints: values, text, and errors that name the line."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from for_each import for_each

import aioduco
from aioduco import Joints
from aioduco.recording.playback import WaypointFile

TEXT = """\
# my cell
arm = "GCR5 910"

[defaults]
speed_deg_s = 90       # careful

[[waypoint]]
name = "above"
joints_deg = [0, -10, 100, 0, -90, 0.5]
blend_mm = 20

[[waypoint]]
name = "part"          # the gripper closes here
joints_deg = [0, -5, 105, 0, -90, 0]
motion = "line"
line_speed_mm_s = 50
dwell_s = 0.5
outputs = { 3 = true, 4 = false }
"""


def test_values_are_in_si_units() -> None:
    above, part = WaypointFile(TEXT).waypoints
    assert above.joints.almost_equal(Joints.deg(0, -10, 100, 0, -90, 0.5), 1e-12)
    assert (above.blend, above.motion, above.stops) == (0.02, "joints", False)
    assert above.speed == part.speed == pytest.approx(math.pi / 2)
    assert (part.line_speed, part.dwell, part.outputs) == (0.05, 0.5, {3: True, 4: False})
    assert part.stops


def test_what_was_edited_stays_as_it_is_when_a_waypoint_is_added(tmp_path: Path) -> None:
    path = tmp_path / "cell.toml"
    path.write_text(TEXT, encoding="utf-8")
    kept = WaypointFile.read(path)
    joints = Joints(0.1, -0.2, 1.7, 1e-9, -1.5, math.pi)
    added = kept.add('he said "so"', joints)
    kept.save(path)
    assert path.read_text(encoding="utf-8").startswith(TEXT)
    again = WaypointFile.read(path)
    assert again.waypoints == kept.waypoints
    assert again.waypoints[-1] == added
    assert added.name == 'he said "so"'
    assert added.joints.almost_equal(joints, 1e-6)
    assert added.speed == pytest.approx(math.pi / 2)
    assert [each.name for each in tmp_path.iterdir()] == ["cell.toml"]
    fresh = WaypointFile.new(arm="GCR5 910")
    fresh.add("one", joints)
    assert WaypointFile(fresh.text).waypoints == fresh.waypoints
    assert "degrees" in fresh.text


@for_each(
    "old, new, says",
    [
        ("blend_mm = 20", "blend_mm = -1", "line 10: waypoint 1, blend_mm: -1 mm is not within"),
        ("blend_mm = 20", "radius = 20", "line 10: waypoint 1, radius: it is not known"),
        ("0.5]", "0.5, 1]", "line 9: waypoint 1, joints_deg: six angles"),
        ("-5, 105", "-5, 1050", "line 14: waypoint 2, joints_deg: 1050 °"),
        ('"line"', '"arc"', "line 15: waypoint 2, motion: 'arc' is neither \"joints\" nor"),
        ("3 = true", "30 = true", "line 18: waypoint 2, outputs: '30' is no output"),
        ("4 = false", "4 = 0", "line 18: waypoint 2, outputs: output 4 is true or false"),
        ("speed_deg_s = 90", "speed_deg_s = true", "line 5: [defaults], speed_deg_s: a number"),
        ("[defaults]", "[default]", "line 4: default is not known"),
        ("joints_deg = [0, -5, 105, 0, -90, 0]\n", "", "line 12: waypoint 2, joints_deg is miss"),
        ("motion = ", "motion ", "is no TOML"),
        ('name = "above"', "name = 7", "line 8: waypoint 1, name: a text"),
    ],
)
def test_an_error_names_the_line_and_the_field(old: str, new: str, says: str) -> None:
    assert TEXT.count(old) == 1
    with pytest.raises(aioduco.WaypointFileError) as error:
        WaypointFile(TEXT.replace(old, new), "cell.toml")
    assert says in str(error.value)
    assert str(error.value).startswith("cell.toml")


def test_a_file_that_cannot_be_read_or_written_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(aioduco.WaypointFileError, match="cannot be read"):
        WaypointFile.read(tmp_path / "none.toml")
    with pytest.raises(aioduco.WaypointFileError, match="cannot be written"):
        WaypointFile(TEXT).save(tmp_path / "no" / "cell.toml")
    with pytest.raises(aioduco.ParameterError, match="one line"):
        WaypointFile(TEXT).add("two\nlines", Joints(0, 0, 0, 0, 0, 0))
    with pytest.raises(aioduco.ParameterError, match="arm"):
        WaypointFile.new(arm=5)  # type: ignore[arg-type]  # what is tested
