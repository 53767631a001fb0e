"""The file of a cell: what is made of it, errors with their lines, points taught into it."""

from __future__ import annotations

import copy
import math
import pickle
from pathlib import Path
from typing import Any

import pytest
from for_each import for_each

import aioduco
import aioduco.sync
from aioduco import Cell, CellFileError, Joints, Pose
from aioduco.devices.grippers import DigitalGripper
from aioduco.envelope import ToolSpeed, Zone
from aioduco.integrations.fleet import FleetSettings
from aioduco.models.load import Load
from aioduco.planning import Mesh
from aioduco.recording.playback import WaypointFile
from aioduco.sim import Simulator
from aioduco.sim.scene import Box, Rod

TEXT = """\
# a cell of two arms
arm = "gcr5_910"

[robots]
default = "left"

[robots.left]
host = "192.0.2.1"   # no controller has this address
[robots.right]
host = "192.0.2.2:7010"
model = "gcr10_1300"
mounting = "wall"

[tool]
tcp_mm_deg = [0, 0, 150, 0, 0, 90]
load = [1.2, 0, 0, 0.05]
[[tool.thing]]
kind = "rod"
length = 0.15

[gripper]
kind = "parallel"
close = 1
holds = 2

[points]
ready = { joints_deg = [20, -10, 100, 0, -90, 0] }  # the start
pick = { pose_mm_deg = [50, 100, 250, 180, 0, 0], frame = "table" }

[points.home] # by hand
joints = [0, 0, 1.5,
  0, -1.5, 0] # keep this

[frames.table]
pose = [0.5, 0, 0, 0, 0, 0]

[scene]
padding = 0.01
[[scene.thing]]
kind = "box"
name = "bench"
at = [0.5, 0, 0.05]
size = [0.3, 0.6, 0.1]

[[limit]]
kind = "plane"
point = [0, 0, 0.15]
normal = [0, 0, 1]
robot = "left"
[[limit]]
kind = "tool_speed"
most = 0.5

[defaults]
speed_deg_s = 20
[[waypoint]]
joints_deg = [1, 2, 3, 4, 5, 6]
"""


def cell() -> Cell:
    return Cell(TEXT)


def test_a_cell_is_a_mapping_of_its_points_with_frames_applied() -> None:
    assert list(cell()) == ["ready", "pick", "home"]
    assert cell().joints("ready").almost_equal(Joints.deg(20, -10, 100, 0, -90, 0), 1e-12)
    assert cell().pose("pick").almost_equal(Pose(0.55, 0.1, 0.25, math.pi, 0, 0))
    assert cell()["home"] == Joints(0, 0, 1.5, 0, -1.5, 0)


def test_the_parts_of_a_cell_are_values() -> None:
    found = cell()
    left, right = found.robot(), found.robot("right")
    assert (left.name, left.host, left.port, left.model) == ("left", "192.0.2.1", 7003, "gcr5_910")
    assert (right.host, right.port, right.mounting) == ("192.0.2.2", 7010, "wall")
    assert found.tool.tcp.almost_equal(Pose(0, 0, 0.15, 0, 0, math.pi / 2))
    assert found.tool.load == Load(1.2, 0, 0, 0.05)
    assert isinstance(found.tool.looks, tuple)
    assert isinstance(found.tool.looks[0], Rod)
    assert found.frames == {"table": Pose(0.5, 0, 0, 0, 0, 0)}
    assert found.waypoints.waypoints[0].speed == pytest.approx(math.radians(20))


def test_a_file_of_waypoints_is_the_file_of_a_cell() -> None:
    file = WaypointFile.new(arm="GCR5 910")
    file.add("corner", Joints.deg(1, 2, 3, 4, 5, 6))
    found = Cell(file.text)
    assert (found.arm, found.waypoints.waypoints) == ("gcr5_910", file.waypoints)


def test_limits_are_of_one_robot_or_of_all() -> None:
    left, right = cell().envelope("left"), cell().envelope("right")
    assert left is not None
    assert right is not None
    assert [type(each) for each in left.limits] == [Zone, ToolSpeed]
    assert [type(each) for each in right.limits] == [ToolSpeed]
    assert (left.arm.name, right.arm.name) == ("gcr5_910", "gcr10_1300")
    assert Cell('[robots.a]\nhost = "192.0.2.1"\nmodel = "gcr5_910"').envelope() is None


def test_a_robot_of_a_cell_is_kept_within_its_limits() -> None:
    for robot in (cell().connect("right"), aioduco.sync.connect_cell(cell(), "right")):
        assert robot.envelope is not None
        assert robot.envelope.titles == ("tool speed",)
    assert "127.0.0.1:7" in repr(cell().connect(host="127.0.0.1", port=7))


def test_scene_and_simulator_are_those_of_the_file() -> None:
    scene = cell().scene("right")
    assert (scene.arm.name, scene.padding) == ("gcr10_1300", 0.01)
    assert isinstance(scene["bench"], Box)
    made = cell().simulator(gripper=None)
    assert (made.arm.name, made.gripper) == ("gcr5_910", None)
    gripper = cell().simulator().gripper
    assert gripper is not None
    assert gripper.name == "parallel"


def test_the_gripper_has_its_driver() -> None:
    found = cell().gripper
    assert found is not None
    assert isinstance(found.driver(cell().connect()), DigitalGripper)


async def test_all_robots_of_a_cell_are_connected_and_move_within_its_limits() -> None:
    async with Simulator(speed=math.inf) as left, Simulator(speed=math.inf) as right:
        text = TEXT.replace('"192.0.2.1"', f'"{left.host}:{left.port}"')
        text = text.replace('"192.0.2.2:7010"', f'"{right.host}:{right.port}"')
        async with Cell(text).connect_all(lag_limit=None) as robots:
            assert list(robots) == ["left", "right"]
            await robots["left"].bring_up()
            with pytest.raises(aioduco.EnvelopeViolated, match="plane"):
                await robots["left"].motion.movej2(Joints.deg(0, 60, 90, 0, -90, 0), v=0.3, a=0.5)


@for_each(
    "old, new, line, says",
    [
        ("[robots.right]", "[robts.right]", 9, "did you mean 'robots'"),
        ('host = "192.0.2.1"', 'hosst = "192.0.2.1"', 8, "did you mean 'host'"),
        ('default = "left"', 'default = "lefft"', 5, "did you mean 'left'"),
        ("7010", "99999", 10, "port"),
        ('"gcr5_910"', '"gcr5_901"', 2, "did you mean 'gcr5_910'"),
        ('mounting = "wall"', 'mounting = "wal"', 12, "wal"),
        ('mounting = "wall"', "mounting = [nan, 0, 0, 0, 0, 0]", 12, "x is nan"),
        ('mounting = "wall"', "mounting = [0, 0, 0, 180, 0, 0]", 12, "not degrees"),
        ("load = [1.2", 'load = ["x"', 16, "mass"),
        ("load = [1.2, 0", "load = [1.2, nan", 16, "nan"),
        ("length = 0.15", "lenght = 0.15", 19, "did you mean 'length'"),
        ("length = 0.15", "length = -1", 19, "above 0"),
        ('kind = "parallel"', 'kind = "paralel"', 22, "did you mean 'parallel'"),
        ("holds = 2", "hold = 2", 24, "did you mean 'holds'"),
        ("holds = 2", "holds = 77", 24, "1 to 16"),
        ('frame = "table"', 'frame = "tabel"', 28, "did you mean 'table'"),
        ("joints = [0, 0, 1.5,", "jonits = [0, 0, 1.5,", 31, "did you mean 'joints'"),
        ("pose = [0.5, 0,", "pose = [0.5,", 35, "six"),
        ("pose = [0.5, 0,", "pose = [500, 0,", 35, "millimetres"),
        ("joints = [0, 0, 1.5,", "joints = [0, 0, 90,", 31, "not degrees"),
        ('frame = "table"', 'frame = ["table"]', 28, "there are table"),
        ("padding = 0.01", "padding = 4", 38, "0.1 m"),
        ('kind = "box"', 'kind = "bocks"', 40, "there are box"),
        ('name = "bench"', 'name = "link1"', 41, "the arm's own"),
        ("size = [0.3, 0.6", "size = [0.3", 43, "size"),
        ("normal = [0, 0, 1]", "normal = [0, 0, 0]", 48, "not all 0"),
        ('robot = "left"', 'robot = "lfet"', 49, "did you mean 'left'"),
        ('robot = "left"', 'robot = ["left"]', 49, "there are left"),
        ('kind = "plane"', 'kind = ["plane"]', 46, "tool_speed"),
        ("most = 0.5", "moost = 0.5", 52, "did you mean 'most'"),
        ("speed_deg_s = 20", "speed_deg = 20", 55, "did you mean 'speed_deg_s'"),
        ("[1, 2, 3, 4, 5, 6]", "[1, 2, 3, 4, 5]", 57, "six angles"),
        ("[tool]", "[tool", 14, "no TOML"),
    ],
)
def test_an_error_has_the_file_the_line_and_what_was_meant(
    old: str, new: str, line: int, says: str
) -> None:
    text = TEXT.replace(old, new, 1)
    assert text != TEXT
    with pytest.raises(CellFileError, match=rf"^cells/a\.toml.*line {line}\b") as error:
        Cell(text, "cells/a.toml")
    assert says in str(error.value)


def test_files_are_those_beside_the_cell(tmp_path: Path) -> None:
    (tmp_path / "around.xml").write_text("<mujoco><worldbody/></mujoco>", encoding="utf-8")
    text = 'arm = "gcr5_910"\n[scene]\nfile = "around.xml"\n'
    path = tmp_path / "cell.toml"
    path.write_text(text, encoding="utf-8")
    assert Cell.load(path).simulator_options()["scene"] == str(tmp_path / "around.xml")
    with pytest.raises(CellFileError, match=r"line 3.*does not exist"):
        Cell(text, tmp_path / "elsewhere" / "cell.toml")
    with pytest.raises(CellFileError, match="cannot be read"):
        Cell.load(tmp_path / "none.toml")
    path.write_bytes(b'arm = "gcr5_910"\n# \xe4\n')
    with pytest.raises(CellFileError, match=r"cell\.toml .*line 2 is not UTF-8"):
        Cell.load(path)


def test_a_mesh_stands_in_the_planners_scene_and_in_the_simulator(tmp_path: Path) -> None:
    corners = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    faces = ["f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"]
    (tmp_path / "wedge.obj").write_text("\n".join([*lines, *faces]), encoding="utf-8")
    text = (
        'arm = "gcr5_910"\n[[scene.thing]]\nkind = "mesh"\nfile = "wedge.obj"\n'
        "scale = 0.1\nat = [0.6, 0, 0]\n"
    )
    found = Cell(text, tmp_path / "cell.toml")
    assert not found.scene().collides(Joints.deg(0, 0, 90, 0, -90, 0))
    with found.simulator() as sim:
        assert sim.arm.name == "gcr5_910"


def test_a_gripper_is_the_tool_of_a_scene_unless_the_file_has_its_looks() -> None:
    text = 'arm = "gcr5_910"\n[gripper]\nkind = "robotiq_2f140"\n'
    thing = '[[scene.thing]]\nkind = "box"\nat = [0.45, 0, 0.14]\nsize = [0.3, 0.3, 0.28]\n'
    rod = '[[tool.thing]]\nkind = "rod"\nlength = 0.01\n'
    down = Joints.deg(0, -10, 100, 0, -90, 0)  # the flange is 0.44 m above the floor
    assert Cell(text + thing).scene().collides(down)
    assert not Cell(text + thing + rod).scene().collides(down)


@pytest.mark.parametrize("kind", [Cell, WaypointFile])
def test_what_is_no_text_is_no_file(kind: Any) -> None:
    for wrong in list[Any]([5, None, b"arm", ["arm"]]):
        with pytest.raises(aioduco.DucoError, match="is no text"):
            kind(wrong)
    with pytest.raises(aioduco.ParameterError, match="the name of a file"):
        cell().save(5)  # type: ignore[arg-type]  # wrong on purpose


def test_unknown_names_are_answered_with_the_nearest() -> None:
    with pytest.raises(KeyError, match="did you mean 'pick'"):
        cell()["pik"]
    with pytest.raises(aioduco.ParameterError, match="did you mean 'ready'"):
        cell().joints("redy")
    with pytest.raises(aioduco.ParameterError, match="did you mean 'right'"):
        cell().connect("rigth")
    with pytest.raises(aioduco.ParameterError, match="a robot of"):
        cell().connect(["right"])  # type: ignore[arg-type]  # wrong on purpose


# -- teaching ------------------------------------------------------------------------------------


def test_a_taught_point_changes_its_own_value_alone() -> None:
    found = cell()
    found.teach("ready", Joints.deg(1, 2, 3, 4, 5, 6.00001))
    found.teach("pick", Pose(0.6, 0.2, 0.3, math.pi, 0, 0))
    found.teach("home", Pose(0.1, 0, 0, 0, 0, 0))
    expected = TEXT.replace("[20, -10, 100, 0, -90, 0]", "[1, 2, 3, 4, 5, 6]")
    expected = expected.replace("[50, 100, 250, 180", "[100, 200, 300, 180")
    expected = expected.replace(
        "joints = [0, 0, 1.5,\n  0, -1.5, 0] # keep", "pose_mm_deg = [100, 0, 0, 0, 0, 0]  # keep"
    )
    assert found.text == expected
    assert found.pose("pick").almost_equal(Pose(0.6, 0.2, 0.3, math.pi, 0, 0))


@pytest.mark.parametrize("name", ["place", 'he said "so"', "a=b", "above.it", "夹取"])
def test_a_new_point_follows_the_text(name: str) -> None:
    found = cell()
    found.teach(name, Joints.deg(1, 2, 3, 4, 5, 6))
    assert found.text.startswith(TEXT)
    assert Cell(found.text).joints(name).almost_equal(Joints.deg(1, 2, 3, 4, 5, 6), 1e-9)
    found.teach(name, Joints.deg(6, 5, 4, 3, 2, 1))
    assert Cell(found.text).joints(name).almost_equal(Joints.deg(6, 5, 4, 3, 2, 1), 1e-9)
    assert len(found) == 4


@pytest.mark.parametrize("key", ["'joints_deg'", 'a."joints_deg"', '"a" . joints_deg'])
def test_a_point_with_a_quoted_key_is_taught_again(key: str) -> None:
    table = "points.a" if key.startswith("'") else "points"
    found = Cell(f'arm = "gcr5_910"\n[{table}]\n{key} = [0, 0, 0, 0, 0, 0] # keep\n')
    found.teach("a", Pose(0.1, 0, 0, 0, 0, 0))
    assert found.pose("a") == Pose(0.1, 0, 0, 0, 0, 0)
    assert found.text.endswith("[100, 0, 0, 0, 0, 0]  # keep\n")


def test_what_cannot_be_taught_changes_nothing() -> None:
    found = cell()
    for name, point in (
        ("pick", Joints(0, 0, 0, 0, 0, 0)),
        ("", Pose(0, 0, 0, 0, 0, 0)),
        ("a\nb", Pose(0, 0, 0, 0, 0, 0)),
    ):
        with pytest.raises(aioduco.ParameterError):
            found.teach(name, point)
    assert found.text == TEXT
    closed = Cell('points = { a = { joints = [0, 0, 0, 0, 0, 0] } }\narm = "gcr5_910"\n')
    before = closed.text
    with pytest.raises(CellFileError, match=r"^cell\.toml: b cannot be written there"):
        closed.teach("b", Joints(0, 0, 0, 0, 0, 0))
    assert (closed.text, list(closed)) == (before, ["a"])


def test_a_saved_file_stays_the_same_file_but_for_its_text(tmp_path: Path) -> None:
    there = tmp_path / "there.toml"
    there.write_bytes(TEXT.replace("\n", "\r\n").encode())
    there.chmod(0o600)
    link = tmp_path / "cell.toml"
    link.symlink_to(there)
    found = Cell.load(link)
    found.teach("ready", Joints.deg(1, 2, 3, 4, 5, 6))
    found.teach("new", Joints.deg(1, 2, 3, 4, 5, 6))
    found.save()
    assert link.is_symlink()
    assert there.stat().st_mode & 0o777 == 0o600
    written = there.read_bytes()
    assert written.count(b"\n") == written.count(b"\r\n")
    assert Cell.load(link).joints("new").almost_equal(Joints.deg(1, 2, 3, 4, 5, 6), 1e-9)
    with pytest.raises(CellFileError, match="cannot be written"):
        found.save(tmp_path / "nowhere" / "cell.toml")


def test_a_copy_is_equal_and_other_text_is_not() -> None:
    for other in (copy.deepcopy(cell()), pickle.loads(pickle.dumps(cell()))):
        assert other == cell()
        assert dict(other) == dict(cell())
    assert Cell(TEXT.replace("192.0.2.1", "192.0.2.9")) != cell()


def test_a_file_that_was_read_by_a_relative_name_stays_that_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A program may change its working directory in between."""
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "cell.toml").write_text(TEXT)
    (tmp_path / "fleet.toml").write_text('[fleet]\nname = "hall"\nkeys = "keys.toml"\n')
    (tmp_path / "part.stl").write_text("solid\nendsolid\n")
    monkeypatch.chdir(tmp_path)
    found, part = Cell.load("cell.toml"), Mesh(file="part.stl")
    fleet = FleetSettings.read("fleet.toml")
    monkeypatch.chdir(tmp_path / "elsewhere")
    found.teach("new", Joints.deg(1, 2, 3, 4, 5, 6))
    found.save()
    assert not [*(tmp_path / "elsewhere").iterdir()]
    assert "new" in Cell.load(tmp_path / "cell.toml")
    assert part.assets()[0].get("file") == str(tmp_path / "part.stl")
    assert fleet.keys == str(tmp_path / "keys.toml")
