"""`aioduco export`, and the examples of the page."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
import yaml
from cli_runner import CliRunner
from for_each import for_each
from typer.testing import Result

from aioduco.cli.app import app
from aioduco.descriptions import (
    ArmDescription,
    Capsule,
    ToolDescription,
    mesh_files,
    mjcf,
    mjcf_scene,
    moveit,
    srdf,
    urdf,
)
from aioduco.descriptions.meshes import stl
from aioduco.integrations.ros.arm_node import NodeSettings
from aioduco.integrations.ros.ros1.launch_package import launch_package
from aioduco.kinematics import arm
from aioduco.kinematics.looks import looks, merged

PAGE = Path(__file__).parents[2] / "docs" / "descriptions.md"


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["export", *arguments])


def of_scene() -> dict[str, str]:
    return {"gcr7_910.xml": mjcf("gcr7_910"), "scene.xml": mjcf_scene("gcr7_910", "gcr7_910.xml")}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        ("urdf", lambda: {"gcr7_910.urdf": urdf("gcr7_910")}),
        ("srdf", lambda: {"gcr7_910.srdf": srdf("gcr7_910")}),
        ("mjcf", of_scene),
        ("moveit", lambda: moveit("gcr7_910", distro="humble")),
    ],
    ids=["urdf", "srdf", "mjcf", "moveit"],
)
def test_files_are_written(
    kind: str, expected: Callable[[], dict[str, str]], tmp_path: Path
) -> None:
    files = expected()
    folder = tmp_path / "new"
    options = ["--distro", "humble"] if kind == "moveit" else []
    done = run(kind, "--model", "gcr7_910", "-o", str(folder), *options)
    assert done.exit_code == 0, done.output
    assert {path.name: path.read_text("utf-8") for path in folder.iterdir()} == files
    assert done.stdout.split() == [str(folder / name) for name in files]


def test_meshes_of_the_arms_lengths_are_written_beside_their_addresses(tmp_path: Path) -> None:
    done = run("urdf", "--mesh-uri", "package://mine/meshes/", "-o", str(tmp_path))
    assert done.exit_code == 0, done.output
    files = {path.name: path.read_bytes() for path in (tmp_path / "meshes").iterdir()}
    assert files == mesh_files("gcr5_910")
    described = ET.parse(tmp_path / "gcr5_910.urdf").findall("link/visual")
    shown = {
        visual.find("geometry/mesh").get("filename"): visual.find("material").get("name")  # type: ignore[union-attr]
        for visual in described
    }
    assert shown == {
        f"package://mine/meshes/{name}": f"duco_{Path(name).stem.rpartition('_')[2]}"
        for name in files
    }
    assert done.stdout.split() == [str(tmp_path / "gcr5_910.urdf"), str(tmp_path / "meshes")]


@pytest.mark.slow
def test_meshes_are_read_by_others(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    for link in looks(arm("gcr3_618")):
        for points, faces in merged(link).values():
            (tmp_path / "part.stl").write_bytes(stl(points, faces))
            read = trimesh.load_mesh(tmp_path / "part.stl")
            assert read.is_watertight
            assert read.volume == pytest.approx(
                trimesh.Trimesh(points, faces, process=False).volume, rel=1e-3
            )


def test_a_package_of_ros_1_starts_each_arm_of_its_urdf(tmp_path: Path) -> None:
    models = ["--model", "gcr5_910", "--prefix", "left_", "--mounting", "0,0.4,0,0,0,0"]
    models += ["--model", "gcr3_618", "--prefix", "right_", "--mounting", "wall"]
    done = run("ros1", *models, "--name", "cell", "-o", str(tmp_path))
    assert done.exit_code == 0, done.output
    package = tmp_path / "cell_bringup"
    assert ET.parse(package / "package.xml").findtext("name") == package.name
    launch = ET.parse(package / "launch" / "arm.launch")
    described = launch.find("param[@name='robot_description']")
    assert described is not None
    assert described.get("textfile") == "$(dirname)/../urdf/cell.urdf"
    tree = ET.parse(package / "urdf" / "cell.urdf")
    joints = {joint.get("name") for joint in tree.findall("joint")}
    links = {link.get("name") for link in tree.findall("link")}
    nodes = launch.findall("node[@type='driver']")
    assert len(nodes) == 2
    for node in nodes:
        given = {each.get("name"): each.get("value", "") for each in node.findall("param")}
        settings = NodeSettings(host="-", model=given["model"], prefix=given["prefix"])
        assert set(settings.profile.joint_names) <= joints
        assert settings.base_frame in links
        assert set(given) <= {field.name for field in fields(NodeSettings)}
    own = [node.get("type") for node in launch.findall(f"node[@pkg='{package.name}']")]
    assert set(own) == {path.name for path in (package / "scripts").iterdir()}
    assert all(path.stat().st_mode & 0o111 for path in (package / "scripts").iterdir())
    meshes = {
        mesh.get("filename", "").removeprefix("package://cell_bringup/meshes/")
        for mesh in tree.findall("link/visual/geometry/mesh")
    }
    assert meshes == {path.name for path in (package / "meshes").iterdir()}
    shown = yaml.safe_load((package / "rviz" / "arm.rviz").read_text("utf-8"))
    assert shown["Visualization Manager"]["Global Options"]["Fixed Frame"] in links


def test_the_simulator_of_that_package_is_given_no_remappings(tmp_path: Path) -> None:
    said = tmp_path / "said"
    said.write_text('#!/bin/sh\nprintf "%s\\n" "$@"\n')
    said.chmod(0o755)
    script = tmp_path / "simulator"
    files = launch_package("gcr5_910", name="arm", command=str(said))
    script.write_text(files["arm_bringup/scripts/simulator"])
    asked = ["--model", "gcr5_910", "__name:=simulator", "__log:=/a b/c.log", "--port", "7003"]
    found = subprocess.check_output(["sh", str(script), *asked], text=True).splitlines()
    assert found == ["sim", "--model", "gcr5_910", "--port", "7003"]


@pytest.mark.slow
def test_options_are_those_of_the_description(tmp_path: Path) -> None:
    tool = ToolDescription(
        mass=1.5,
        centre=(0.0, 0.0, 0.05),
        tcp=(0.0, 0.0, 0.1, 0.0, 0.0, 0.0),
        parts=[Capsule((0.0, 0.0, 0.03), (0.0, 0.0, 0.08), 0.03)],
    )
    left = ArmDescription("gcr5_910", "left_", (0, 0.4, 0, 0, 0, 0), tool)
    right = ArmDescription("gcr3_618", "right_", "wall", tool)
    models = ["--model", "gcr5_910", "--prefix", "left_", "--mounting", "0,0.4,0,0,0,0"]
    models += ["--model", "gcr3_618", "--prefix", "right_", "--mounting", "wall"]
    tools = ["--tcp", "0,0,0.1,0,0,0", "--tool-mass", "1.5", "--tool-centre", "0,0,0.05"]
    tools += ["--tool-capsule", "0,0,0.03,0,0,0.08,0.03"]
    done = run("urdf", *models, *tools, "--name", "cell", "-o", str(tmp_path))
    assert done.exit_code == 0, done.output
    assert (tmp_path / "cell.urdf").read_text("utf-8") == urdf(left, right, name="cell")
    (tmp_path / "link_1.stl").touch()
    meshes = ["--meshes", str(tmp_path), "--mesh-uri", "package://mine"]
    done = run("urdf", "--mounting", "none", *meshes, "-o", str(tmp_path))
    assert done.exit_code == 0, done.output
    written = (tmp_path / "gcr5_910.urdf").read_text("utf-8")
    assert "package://mine/link_1.stl" in written
    assert "world" not in written


@pytest.mark.cases(4)
@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--model", "ur5e"], "one of gcr3_618"),
        (["--mounting", "roof"], "must be floor, wall, ceiling"),
        (["--mounting", "0,0,1"], "6 numbers"),
        (["--tcp", "up"], "6 numbers"),
        (["--tool-capsule", "0,0,0,0,0,1"], "7 numbers"),
        (["--prefix", "a_", "--prefix", "b_"], "one for each --model"),
        (["--meshes", "."], "a folder with base_link"),
    ],
)
def test_what_is_wrong_is_said(
    options: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = run("urdf", *options)
    assert done.exit_code == 2
    assert said in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_made_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    done = run("urdf", "-o", str(tmp_path / "file" / "below"))
    assert done.exit_code == 2
    assert "file" in done.stderr


@for_each(
    "words, option",
    [
        ("srdf --meshes .", "--meshes"),
        ("srdf --mesh-uri package://mine", "--mesh-uri"),
        ("mjcf --mesh-uri package://mine", "--mesh-uri"),
        ("urdf --distro noetic", "--distro"),
        ("ros1 --distro noetic", "--distro"),
        ("moveit --moveit", "--moveit"),
        ("srdf --group arm", "--group"),
        ("ros1 --tip link_6", "--tip"),
        ("urdf --tool-centre 0,0,0.1", "--tool-centre"),
    ],
)
def test_an_option_that_the_format_does_not_have_is_refused(
    words: str, option: str, tmp_path: Path
) -> None:
    answer = run(*words.split(), "-o", str(tmp_path))
    assert (answer.exit_code, list(tmp_path.iterdir())) == (2, [])
    assert f"Invalid value for {option}: it is for " in answer.stderr


def test_a_centre_of_two_numbers_is_refused_without_a_mass_too(tmp_path: Path) -> None:
    answer = CliRunner().invoke(
        app, ["export", "urdf", "-o", str(tmp_path), "--tool-centre", "0,0"]
    )
    assert (answer.exit_code, list(tmp_path.iterdir())) == (2, [])
