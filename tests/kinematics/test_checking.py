"""Reports on points before an arm moves there."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_runner import CliRunner

from aioduco import Joints, Pose, TaughtPoints
from aioduco.cli.app import app
from aioduco.errors import ParameterError
from aioduco.kinematics import Problem, arm, check

HOME = Joints.deg(30, -15, 105, 0, -90, 0)
ARM = arm("gcr5_910")
THERE = Pose.from_matrix(ARM.fkine(HOME))


def problems(points: Any, **given: Any) -> list[tuple[int, Problem]]:
    settings: dict[str, Any] = {"arm": ARM, "near": HOME} | given
    report = check(points, **settings)
    assert report.ok == (not report.findings)
    return [(each.index, each.problem) for each in report.findings]


def test_points_that_are_fine_are_told_with_their_joints() -> None:
    points = [HOME, THERE.shifted(z=0.05), THERE.shifted(z=0.05, x=0.1)]
    report = check(points, arm="gcr5_910", near=HOME)
    assert report.ok
    for point, q in zip(points, report.joints, strict=True):
        assert q is not None
        flange = point if isinstance(point, Pose) else THERE
        assert Pose.from_matrix(ARM.fkine(q)).almost_equal(flange, position=1e-9, rotation=1e-9)
        assert q.distance(HOME) < 0.5
    assert "3 points: nothing found" in str(report)
    numbered: Any = dict(enumerate(points, 1))
    assert check(numbered, arm="gcr5_910", near=HOME).names == ("1", "2", "3")
    assert "3 points: nothing found" in str(check(numbered, arm="gcr5_910", near=HOME))


def test_each_problem_is_found_where_it_is() -> None:
    stretched = Joints.deg(30, 40, 1, 49, -90, 0)
    other_elbow = next(
        Joints.of(q) for q in ARM.ikine_all(THERE) if q[2] < 0 and abs(q[0] - HOME[0]) < 0.1
    )
    assert problems([THERE.shifted(x=2.0)]) == [(0, Problem.REACH)]
    assert problems([HOME, Joints.deg(370, -15, 105, 0, -90, 0)], most_turn=7.0) == [
        (1, Problem.LIMIT)
    ]
    assert problems([stretched]) == [(0, Problem.SINGULARITY)]
    assert (1, Problem.BRANCH) in problems([HOME, other_elbow, other_elbow])
    assert problems([HOME, Joints.deg(-160, -15, 105, 0, -90, 0)]) == [(1, Problem.JUMP)]
    # What is out of reach does not hide what comes after it.
    assert problems([THERE.shifted(x=2.0), THERE]) == [(0, Problem.REACH)]


def test_a_pose_that_only_joints_beyond_their_limits_reach_is_a_limit() -> None:
    from dataclasses import replace  # noqa: PLC0415 - here alone

    narrow = replace(ARM, lower=(-0.1,) * 6, upper=(0.1,) * 6)
    assert problems([THERE], arm=narrow) == [(0, Problem.LIMIT)]


def test_tool_and_work_object_are_taken_into_account() -> None:
    tool, table = Pose(0, 0, 0.15, 0.2, 0, 0), Pose(0.3, 0.1, 0.0, 0, 0, 0.5)
    point = table.inverse() @ THERE @ tool
    report = check([point], arm=ARM, near=HOME, tool=tool, wobj=table)
    assert report.joints[0] is not None
    np.testing.assert_allclose(report.joints[0], HOME, atol=1e-9)


def test_what_is_no_list_of_points_is_refused() -> None:
    for wrong in (HOME, THERE, "home", 3):
        with pytest.raises(ParameterError, match="points"):
            check(wrong, arm=ARM, near=HOME)  # type: ignore[arg-type]  # wrong on purpose
    with pytest.raises(ParameterError, match="model"):
        check([HOME], arm="gcr6", near=HOME)
    with pytest.raises(ParameterError, match="most_turn"):
        check([HOME], arm=ARM, near=HOME, most_turn=math.nan)


@pytest.mark.slow
def test_the_command_reads_a_file_and_says_so_by_its_exit_code(tmp_path: Path) -> None:
    file = tmp_path / "cell.toml"
    points = TaughtPoints({"home": HOME, "above": THERE.shifted(z=0.05)})
    points.save(file)
    run = CliRunner()
    good = run.invoke(app, ["check", str(file)])
    assert (good.exit_code, "above  ok" in good.output) == (0, True)
    points["far"] = THERE.shifted(x=2.0)
    points.save(file)
    bad = run.invoke(app, ["check", str(file), "--start", "home", "--tool", "0,0,0.1,0,0,0"])
    assert bad.exit_code == 1
    assert "out of reach" in bad.output
    assert "far" in bad.output
    for options in (["--model", "gcr6"], ["--tool", "1,2"], ["--start", "far"]):
        assert run.invoke(app, ["check", str(file), *options]).exit_code == 2
    assert run.invoke(app, ["check", str(tmp_path / "none.toml")]).exit_code == 2
