"""Paths of recordings: what they are, and which are refused."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from for_each import for_each

import aioduco
from aioduco.envelope import Envelope, ToolSpeed, Zone
from aioduco.kinematics import arm
from aioduco.models.ranges import JOINT_SPEED
from aioduco.recording import read
from aioduco.recording.playback import RecordedPath, check_path
from aioduco.recording.playback.path_check import fastest, sharpest
from aioduco.recording.playback.player import follow
from recording.playback.recorded import FAR, HOME, RATE, Array, nod, write

ARM = arm("gcr5_910")


def off(path: RecordedPath, speed: float = 1.0) -> float:
    """Largest distance of a path from what the arm did [rad], each at its time."""
    times = np.arange(0.0, path.duration, 0.001)
    return float(np.abs(path.at(times) - nod(path.begin + times * speed)).max())


def test_a_path_is_what_the_arm_did_from_when_it_moved(tmp_path: Path) -> None:
    run = read(write(tmp_path / "run.mcap"))
    path = RecordedPath.of(run)
    assert path.begin == pytest.approx(0.45, abs=0.02)
    assert path.duration == pytest.approx(1.6, abs=0.04)
    assert path.start.almost_equal(HOME, 1e-4)
    assert path.arm == "GCR5 910"
    assert off(path) < 1e-4
    part = RecordedPath.of(run, begin=1.0, end=1.5)
    assert part.begin == pytest.approx(1.0, abs=0.01)
    # amid a motion it comes to its speed, and to rest, in 0.4 s each
    assert part.duration == pytest.approx(0.9, abs=0.02)
    assert kinds(part) == []
    assert np.abs(part.at(part.times) - nod(part.recorded)).max() < 1e-4
    quick = RecordedPath.of(run, speed=2.0)
    assert quick.duration == pytest.approx(path.duration / 2, abs=1e-6)
    assert off(quick, 2.0) < 1e-4
    assert fastest(quick) == pytest.approx(2 * fastest(path), rel=0.01)
    assert sharpest(quick) == pytest.approx(4 * sharpest(path), rel=0.05)


@for_each("seconds", [0.3, 0.15, 0.02])
def test_a_short_part_of_a_motion_begins_and_ends_at_rest(tmp_path: Path, seconds: float) -> None:
    """One of less than 0.4 s began at the speed of the recorded arm, and nothing spoke against."""
    path = RecordedPath.of(read(write(tmp_path / f"{seconds}.mcap")), begin=1.0, end=1.0 + seconds)
    assert path.duration == pytest.approx(2 * seconds, abs=0.03)
    assert np.abs(path.at(path.times) - nod(path.recorded)).max() < 1e-4
    assert kinds(path) == (["acceleration"] if seconds < 0.1 else [])


@pytest.mark.slow
@for_each("rate, speed", [(125.0, 0.002), (1000.0, 0.021), (1000.0, 0.029)])
def test_slow_motions_are_whole_at_each_rate_of_samples(
    tmp_path: Path, rate: float, speed: float
) -> None:
    """Less than 30 µrad a sample was no motion: a creeping end, or all of it, was left out."""

    def creep(times: Array) -> Array:
        way = speed * np.clip(times - 2.0, 0.0, 3.0)
        return np.asarray(nod(times, 0.5, 1.0) + way[:, None] * np.eye(6)[0])

    taken = np.arange(0.0, 5.5, 1 / rate)
    path = RecordedPath.of(read(write(tmp_path / "run.mcap", creep, taken=taken)))
    assert path.begin + path.duration == pytest.approx(5.05, abs=0.1)
    assert path.positions[-1] == pytest.approx(creep(taken[-1:])[0], abs=1e-4)
    assert np.abs(path.at(path.times) - creep(path.recorded)).max() < 2e-3
    assert path.gaps == ()


def test_a_recording_of_too_few_samples_says_how_many_are_needed(tmp_path: Path) -> None:
    """It was said to be of a computer that was too busy."""
    few = write(tmp_path / "few.mcap", taken=np.arange(0.0, 2.5, 0.2))
    with pytest.raises(aioduco.RecordingError, match="with 20 samples a second or more"):
        RecordedPath.of(read(few))
    enough = write(tmp_path / "enough.mcap", taken=np.arange(0.0, 2.5, 0.05))
    assert RecordedPath.of(read(enough)).gaps == ()


@pytest.mark.slow
def test_samples_that_were_received_late_make_no_shaking_path(tmp_path: Path) -> None:
    chance = np.random.default_rng(5)

    def late(times: Any) -> Any:
        return 0.001 + chance.exponential(0.004, len(times)).clip(0.0, 0.007)

    path = RecordedPath.of(read(write(tmp_path / "run.mcap", late=late)))
    times = np.arange(0.0, path.duration, 0.001)
    lags = np.arange(0.0, 0.01, 0.0002)
    errors = [np.abs(path.at(times) - nod(path.begin + times - lag)).max() for lag in lags]
    assert min(errors) < 2e-4
    # without them, a jitter of 7 ms at 1 rad/s is one of 7 mrad, and as good as a blow
    smooth = RecordedPath.of(read(write(tmp_path / "smooth.mcap")))
    assert sharpest(path) == pytest.approx(sharpest(smooth), rel=0.1)


@pytest.mark.slow
def test_pauses_stay_and_gaps_are_refused(tmp_path: Path) -> None:
    def twice(times: Any) -> Any:
        return np.where(times[:, None] < 3.0, nod(times), nod(times, 4.0))

    run = read(write(tmp_path / "twice.mcap", twice, seconds=6.0, without=(2.2, 3.8)))
    path = RecordedPath.of(run)
    assert path.duration == pytest.approx(5.1, abs=0.05)
    still = path.at(np.array([2.0, 3.0]))
    assert np.abs(still - HOME).max() < 1e-4
    gap = write(tmp_path / "gap.mcap", without=(1.0, 1.3))
    with pytest.raises(
        aioduco.RecordingError, match=r"0\.3\d s are missing from 1\.00 s on"
    ) as told:
        RecordedPath.of(read(gap))
    assert RecordedPath.of(read(gap), end=1.0).duration == pytest.approx(0.75, abs=0.03)
    # what the message says helps
    (needed,) = re.findall(r"--bridge\) (\S+) rad", str(told.value))
    bridged = RecordedPath.of(read(gap), bridge=float(needed))
    assert off(bridged) < float(needed)
    with pytest.raises(aioduco.RecordingError):
        RecordedPath.of(read(gap), bridge=0.95 * float(needed))


def busy(seed: int) -> tuple[Array, Any]:
    """When a busy computer's samples are taken, and how late they are received.

    The controller computes its cycles in bursts, so that two answers may be from one cycle; and the
    program is held up for up to 60 ms, and now and then for longer.
    """
    chance = np.random.default_rng(seed)
    asked = np.cumsum(0.002 + chance.exponential(0.008, 600).clip(0.0, 0.06))
    asked += 0.08 * np.cumsum(chance.random(600) < 0.01)
    asked = asked[asked < 2.5]
    burst = np.sort(chance.uniform(0.0, 2.5, 300))
    last = burst[np.maximum(np.searchsorted(burst, asked) - 1, 0)]
    taken = np.asarray(np.round(np.minimum(last, asked), 3), dtype=float)
    return taken, lambda _: asked - taken + chance.uniform(0.0, 1e-4, len(asked))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_a_recording_of_a_busy_computer_is_played_as_the_arm_moved(
    seed: int, tmp_path: Path
) -> None:
    taken, late = busy(seed)
    path = RecordedPath.of(read(write(tmp_path / "run.mcap", taken=taken, late=late)))
    assert kinds(path) == []
    times = np.arange(0.0, path.duration, 0.001)
    lags = np.arange(-0.02, 0.06, 0.0005)
    assert min(np.abs(path.at(times) - nod(path.begin + times - lag)).max() for lag in lags) < 2e-3


def test_a_gap_is_bridged_from_the_speeds_at_its_ends_and_said(tmp_path: Path) -> None:
    run = read(write(tmp_path / "run.mcap", without=(0.8, 0.91)))
    path = RecordedPath.of(run)
    (gap,) = path.gaps
    assert gap.time == pytest.approx(0.8, abs=0.01)
    assert gap.duration == pytest.approx(0.115, abs=0.005)
    assert 0.0 < gap.off < 0.005
    assert off(path) < gap.off
    assert "0.11 s are missing from 0.80 s on" in str(gap)
    with pytest.raises(aioduco.RecordingError, match=r"at most 0 mrad are bridged"):
        RecordedPath.of(run, bridge=0.0)


def test_a_gap_without_speeds_is_not_bridged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = read(write(tmp_path / "run.mcap", without=(0.8, 0.91)))
    arrays = run.arrays("/joint_setpoints")
    lost = {**arrays, "velocity": np.full_like(arrays["velocity"], np.nan)}
    monkeypatch.setattr(run, "arrays", lambda _: lost)
    with pytest.raises(aioduco.RecordingError, match=r"are missing.*play up to") as told:
        RecordedPath.of(run, bridge=0.1)
    assert "--bridge" not in str(told.value)


def test_the_controllers_clock_may_have_another_speed(tmp_path: Path) -> None:
    """A simulator at half its speed: the recording is of what was seen."""

    def late(times: Any) -> Any:
        return times

    path = RecordedPath.of(read(write(tmp_path / "run.mcap", late=late)))
    assert path.duration == pytest.approx(3.2, abs=0.1)
    assert kinds(path) == []
    times = np.arange(0.0, path.duration, 0.001)
    assert np.abs(path.at(times) - nod((path.begin + times) / 2)).max() < 2e-3


def test_the_speed_that_helps_is_named_and_does(tmp_path: Path) -> None:
    def fast(times: Any) -> Any:
        return nod(times, seconds=0.6)

    run = read(write(tmp_path / "run.mcap", fast))
    found = check_path(RecordedPath.of(run), ARM)
    assert found
    (factor,) = {re.findall(r"--speed\) of (\S+)", str(each))[0] for each in found}
    assert 0.3 < float(factor) < 1.0
    assert kinds(RecordedPath.of(run, speed=float(factor))) == []


def test_where_no_speed_helps_that_is_said(tmp_path: Path) -> None:
    path = RecordedPath.of(read(write(tmp_path / "run.mcap")))
    positions = path.positions.copy()
    positions[len(positions) // 2] += 0.05  # a place at which the arm cannot have been
    path = dataclasses.replace(path, positions=positions, velocities=None)
    for found in check_path(path, ARM):
        assert "a lower speed factor does not help" in str(found)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"speed": 0.0}, "speed"),
        ({"begin": 9.0}, "begin"),
        ({"begin": 1.0, "end": 0.5}, "begin"),
        ({"of": "wishes"}, "setpoints"),
        ({"end": 0.4}, "did not move"),
    ],
)
def test_what_makes_no_path_is_refused(options: dict[str, Any], says: str, tmp_path: Path) -> None:
    run = read(write(tmp_path / "run.mcap"))
    with pytest.raises((aioduco.ParameterError, aioduco.RecordingError), match=says):
        RecordedPath.of(run, **options)
    name: Any = "run.mcap"
    with pytest.raises(aioduco.ParameterError, match=r"run is 'run\.mcap', but must be"):
        RecordedPath.of(name)


def test_outputs_are_taken_with_their_times(tmp_path: Path) -> None:
    file = write(tmp_path / "run.mcap", outputs={0.1: {2: True}, 0.8: {5: True}, 1.4: {2: False}})
    path = RecordedPath.of(read(file), speed=0.5)
    assert [(each.num, each.value) for each in path.outputs] == [(5, True), (2, False)]
    first, second = path.outputs
    assert first.time == pytest.approx((0.8 - path.begin) * 2, abs=0.02)
    assert second.time - first.time == pytest.approx(1.2, abs=0.02)


@for_each("untold", [(-1.0, 0.7), (0.7, 1.0), (0.9, 1.2)])
def test_outputs_that_are_not_told_for_a_while_have_not_changed(
    tmp_path: Path, untold: tuple[float, float]
) -> None:
    """No recording was played whose controller had told no outputs at first."""
    file = write(tmp_path / f"{untold[0]}.mcap", outputs={0.8: {5: True}}, untold=untold)
    (change,) = RecordedPath.of(read(file)).outputs
    assert (change.num, change.value) == (5, True)


def kinds(path: RecordedPath, **options: Any) -> list[str]:
    return [each.kind for each in check_path(path, ARM, **options)]


@pytest.mark.slow
def test_what_speaks_against_a_path_is_said_with_its_place(tmp_path: Path) -> None:
    run = read(write(tmp_path / "run.mcap"))
    path = RecordedPath.of(run)
    assert kinds(path) == []
    assert kinds(path, v=0.2) == ["speed"]
    assert kinds(RecordedPath.of(run, speed=8.0)) == ["speed", "acceleration"]
    (found,) = check_path(path, ARM, a=1.0)
    assert found.kind == "acceleration"
    assert "rad/s²" in str(found)
    tip = ARM.fkine(FAR)[:3, 3]
    wall = Envelope(ARM, Zone.sphere(tip, 0.02, bodies=["flange"], name="post"))
    (found,) = check_path(path, ARM, envelope=wall)
    assert (found.kind, "post" in found.text) == ("envelope", True)
    assert found.time == pytest.approx(1.25, abs=0.15)
    assert kinds(path, envelope=Envelope(ARM, ToolSpeed(0.05))) == ["envelope"]
    assert kinds(path, envelope=Envelope(ARM, ToolSpeed(2.0))) == []

    def far(times: Any) -> Any:
        return 4.0 * nod(times)

    beyond = RecordedPath.of(read(write(tmp_path / "far.mcap", far)))
    assert kinds(beyond) == ["joint limit"]
    bad = RecordedPath.of(read(write(tmp_path / "bad.mcap", error=1.0)))
    (incident,) = check_path(bad, ARM)
    assert str(incident) == "incident at 1.00 s: the recorded arm had fault 7"
    assert kinds(RecordedPath.of(read(tmp_path / "bad.mcap"), end=0.95)) == []


def test_an_acceleration_is_said_with_the_time_at_which_it_is_largest(tmp_path: Path) -> None:
    def bump(times: Any) -> Any:
        share = np.exp(-(((times - 1.25) / 0.15) ** 2) / 2)
        return np.asarray(HOME + share[:, None] * (0.6 * (FAR - HOME)))

    path = RecordedPath.of(read(write(tmp_path / "run.mcap", bump)))
    (found,) = check_path(path, ARM, a=5.0)
    assert found.kind == "acceleration"
    assert found.time == pytest.approx(1.25, abs=0.008)


async def allowed_speed(path: RecordedPath) -> float:
    """The speed that a stream is allowed which follows a path [rad/s]."""
    speeds: list[float] = []

    class Motion:
        async def follow_joint_trajectory(self, _: object, *, v: float, **__: object) -> None:
            speeds.append(JOINT_SPEED("v", v))

    async def joints() -> Any:
        return path.start.array

    await follow(Motion(), joints, path)
    (speed,) = speeds
    return speed


async def test_a_path_that_is_about_as_fast_as_allowed_is_followed(tmp_path: Path) -> None:
    def fast(times: Any) -> Any:
        return np.asarray(HOME + 4.4 * (nod(times, seconds=1.8) - HOME) * (np.arange(6) == 0))

    path = RecordedPath.of(read(write(tmp_path / "run.mcap", fast)))
    assert kinds(path) == []
    assert fastest(path) > 3.8
    assert await allowed_speed(path) == JOINT_SPEED.high


async def test_a_peak_of_the_speed_between_two_close_samples_is_allowed_for(tmp_path: Path) -> None:
    """Times of reception that could not be mended may be close to one another."""
    path = RecordedPath.of(read(write(tmp_path / "run.mcap")))
    times = path.times.copy()
    middle = len(times) // 3
    times[middle] = times[middle + 1] - 0.003
    path = dataclasses.replace(path, times=times, velocities=None)
    steps = np.diff(path.at(np.arange(0.0, path.duration, 0.001)), axis=0)
    peak = float(np.abs(steps).max()) / 0.001
    assert kinds(path, v=0.9 * peak, a=1e9) == ["speed"]
    assert peak <= await allowed_speed(path) <= 1.1 * peak


@pytest.mark.slow
def test_a_sample_of_a_moving_arm_takes_60_bytes(tmp_path: Path) -> None:
    """That is 27 MB an hour at 125 samples a second; an index alone would take as much."""

    def waving(times: Any) -> Any:
        turns = np.array([1.0, 1.3, 0.7, 1.9, 1.1, 0.5])
        return HOME + 0.3 * np.sin(times[:, None] * turns + turns)

    sizes = [
        write(tmp_path / f"{seconds}.mcap", waving, seconds=seconds).stat().st_size
        for seconds in (2.0, 14.0)
    ]
    assert (sizes[1] - sizes[0]) / (12 * RATE) < 60
