"""Limits are learned from a good run, written and read; a poor run is refused."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from for_each import for_each

from aioduco.errors import ParameterError
from aioduco.sim.twin.data import TwinSample
from aioduco.sim.twin.limits import TwinLimits, deviations, learn
from aioduco.sim.twin.predictor import AHEAD, HELD, Timeline

from .arms import ARM, NOWHERE, READY, PerfectArm, movej2, work
from .test_monitor import EFFORT, rubbing

THERE = (0.6, 0.3, 1.2, 0.4, -1.2, 0.5)


@pytest.fixture(scope="module")
def learned() -> TwinLimits:
    arm, draw = PerfectArm(), np.random.default_rng(1)
    normal = rubbing()
    arm.torques = lambda q, qd, t: normal(q, qd, t) + 0.003 * EFFORT * draw.standard_normal(6)
    good = deviations(ARM, work(arm, *[movej2(*THERE), movej2(*READY)] * 3), NOWHERE)
    return learn(ARM, good)


@pytest.mark.slow
def test_friction_and_noise_are_those_of_the_arm(learned: TwinLimits) -> None:
    assert learned.dry == pytest.approx((0.03 * EFFORT).tolist(), rel=0.1)
    assert learned.noise == pytest.approx((0.003 * EFFORT).tolist(), rel=0.15)
    assert learned.learned > 5.0


@pytest.mark.slow
def test_limits_are_narrower_than_without_a_good_run(learned: TwinLimits) -> None:
    wide = TwinLimits.of(ARM)
    assert learned.mass < 0.5 * wide.mass
    assert learned.path < wide.path
    assert learned.usual_delay == pytest.approx(AHEAD, abs=0.012)
    assert learned.delay < 0.05


def test_a_file_has_all_of_them(learned: TwinLimits, tmp_path: Path) -> None:
    learned.save(tmp_path / "limits.json")
    assert TwinLimits.load(tmp_path / "limits.json") == learned


@for_each("text", ["", "[]", "{}", '{"arm": "gcr5_910"}', "[" * 100_000])
def test_another_file_is_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "limits.json").write_text(text)
    with pytest.raises(ParameterError, match="limits"):
        TwinLimits.load(tmp_path / "limits.json")


@for_each(
    "field, value",
    [
        *(("mass", "1"), ("mass", math.nan), ("mass", 0.0), ("mass", True), ("delay", -1.0)),
        *(("torque", [1.0] * 5), ("torque", 1.0), ("torque", [0.0] * 6), ("dry", ["1"] * 6)),
        *(("noise", None), ("usual_delay", math.inf), ("arm", 5), ("learned", "long")),
    ],
)
def test_a_field_of_another_kind_is_named(field: str, value: Any, tmp_path: Path) -> None:
    path = tmp_path / "limits.json"
    TwinLimits.of(ARM).save(path)
    path.write_text(json.dumps({**json.loads(path.read_text()), field: value}))
    with pytest.raises(ParameterError, match=rf"limits\.json: {field}"):
        TwinLimits.load(path)
    with pytest.raises(ParameterError, match=field):
        replace(TwinLimits.of(ARM), **{field: value})


def test_limits_of_numpy_and_none_are_written_as_json(tmp_path: Path) -> None:
    path = tmp_path / "limits.json"
    limits = replace(
        TwinLimits.of(ARM),
        mass=np.float32(1.5),  # type: ignore[arg-type]
        torque=np.ones(6),  # type: ignore[arg-type]
        force=math.inf,
    )
    limits.save(path)
    json.loads(path.read_text(), parse_constant=pytest.fail)
    assert TwinLimits.load(path) == limits


def test_a_run_that_hardly_moves_is_refused() -> None:
    good = deviations(ARM, work(PerfectArm(), movej2(*THERE)), NOWHERE)
    with pytest.raises(ParameterError, match="5 s or more"):
        learn(ARM, good)


@pytest.mark.slow
def test_what_a_good_run_does_not_show_has_a_wide_limit() -> None:
    """They had the least limits, so that a twin paused an arm in good order."""
    run = list(work(PerfectArm(), *[movej2(*THERE), movej2(*READY)] * 3))
    samples = [each for each in run if isinstance(each, TwinSample)]
    felt = ("torque", "noise", "friction")
    wide = TwinLimits.of(ARM)
    for names, items in (
        (("path", "delay"), samples),
        (("position", "angle"), [each._replace(pose=None) for each in samples]),
        ((*felt, "mass", "force"), [each._replace(external=None) for each in samples]),
        (felt, [each._replace(external=None, force=(0.0,) * 6) for each in samples]),
    ):
        found = learn(ARM, deviations(ARM, items, NOWHERE))
        assert [getattr(found, name) for name in names] == [getattr(wide, name) for name in names]
        assert found.tracking < wide.tracking
    assert found.mass < wide.mass  # a force sensor shows it


def test_a_command_comes_before_the_samples_of_its_time() -> None:
    arm, line = PerfectArm(), Timeline()
    samples = [arm.sample() for _ in range(30)]
    for sample in samples:
        line.put(sample)
    command = arm.send(*movej2(*THERE))._replace(time=samples[-1].time)
    line.put(command)
    assert all(item.time <= samples[-1].time - HELD for item in line.due())
    rest = list(line.rest())
    assert rest.index(command) < len(rest) - 1
    assert rest[rest.index(command) + 1].time > command.time - AHEAD
