"""Chunks of actions that overlap: blended without a jump, late ones counted; the pure part."""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Sequence

import pytest

from aioduco.streaming.shared.ring import SetPoint
from aioduco.streaming.shared.space import JOINT_SPACE, POSE_SPACE, Config, Limits, Space
from aioduco.streaming.shared.words import ActionTag, Reason, StreamState
from aioduco.streaming.worker.chunks import ActionTimeline
from aioduco.streaming.worker.setpoints import PositionGenerator, SetpointSource

from .motion import peaks

PERIOD = 0.01
INTERVAL = 1 / 30
BLEND = 0.1
ZERO = (0.0,) * 6
LIMITS = Limits((1.5,) * 6, (8.0,) * 6, (100.0,) * 6)
POSE_LIMITS = Limits((0.25, 1.0), (1.0, 4.0), (10.0, 40.0))


class Bench:
    """A source with a clock of its own, what it is fed with, and what it gave."""

    def __init__(
        self, space: Space = JOINT_SPACE, limits: Limits = LIMITS, hold: float = 0.5
    ) -> None:
        self.now = 100.0
        self.timeline = ActionTimeline(space, PERIOD, INTERVAL, BLEND)
        self.source = SetpointSource(
            space,
            PERIOD,
            hold=hold,
            interval=PERIOD,
            paced=True,
            reach=(0.1,) * len(space.groups),
            timeline=self.timeline,
            clock=lambda: round(self.now * 1e9),
        )
        start = space.decode(ZERO)
        self.timeline.reset(start)
        self.source.begin(PositionGenerator("ruckig", space, limits, PERIOD, start, self.timeline))
        self.given: list[Config] = [start]
        self._ring: list[SetPoint] = []
        self._chunks = 0

    def send(self, actions: Sequence[Sequence[float]], at: float | None = None) -> None:
        self._chunks += 1
        begin = 0 if at is None else round(at * 1e9)
        for index, action in enumerate(actions):
            tag = ActionTag(self._chunks, begin, index, len(actions))
            self._ring.append(SetPoint(len(self._ring) + 1, 0, tuple(action), tag.pack()))

    @property
    def counts(self) -> tuple[int, int, int, int, int]:
        """Chunks taken, late and dropped; actions late; how often they ran out."""
        found = self.timeline
        return found.taken, found.late, found.dropped, found.late_actions, found.exhausted

    def take(self) -> SetPoint | None:
        return self._ring.pop(0) if self._ring else None

    def tick(self, ticks: int = 1, *, late: float = 0.0) -> StreamState:
        for _ in range(ticks):
            self.now += PERIOD + late
            config = self.source.step(self.take)
            if config is not None:
                self.given.append(config)
        return self.source.state

    def until(self, time: float) -> None:
        while self.now < time - PERIOD / 2:
            self.tick()


def ramp(begin: float, rate: float, count: int) -> list[Config]:
    return [(begin + rate * INTERVAL * k,) * 6 for k in range(count)]


class Wanderer:
    """A policy that changes its mind: each chunk goes on near the last one, another way."""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)
        self._heart = [0.0] * 6

    def chunk(self, pose: bool) -> list[list[float]]:
        draw = self._random
        scale = 0.3 if pose else 1.0
        count = draw.randint(1, 25)
        heart = [max(-1.0, min(1.0, h + draw.uniform(-0.05, 0.05) * scale)) for h in self._heart]
        speed = [draw.uniform(-0.8, 0.8) * scale for _ in heart]
        bend = [draw.uniform(-2, 2) * scale for _ in heart]
        times = [k * INTERVAL for k in range(count)]
        noise = 0.004 * scale
        rows = [
            [
                h + v * t * math.cos(3 * b * t) + draw.uniform(-noise, noise)
                for h, v, b in zip(heart, speed, bend, strict=True)
            ]
            for t in times
        ]
        self._heart = [max(-1.0, min(1.0, angle)) for angle in rows[len(rows) // 2]]
        return rows


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_random_chunks_with_random_lateness_never_make_the_arm_jump(seed: int) -> None:
    """500 of them for each seed: speed, acceleration and jerk are kept, and all are counted."""
    draw = random.Random(seed)
    pose = seed % 4 == 3
    space, limits = (POSE_SPACE, POSE_LIMITS) if pose else (JOINT_SPACE, LIMITS)
    bench, policy = Bench(space, limits, hold=60.0), Wanderer(seed)
    bench.send([ZERO])
    bench.tick()
    taken, late, dropped, actions = 1, 0, 0, 0
    for _ in range(499):
        rows = policy.chunk(pose)
        # From half a second ahead to wholly in the past.
        at = bench.now + draw.choice([0.0, draw.uniform(-0.3, 0.1), draw.uniform(-1.0, 0.5)])
        bench.send(rows, at)
        missed = draw.random() < 0.1
        bench.tick(late=draw.uniform(0, 0.3) if missed else 0.0)
        now = bench.timeline.now
        due = [round(at * 1e9) * 1e-9 + k * INTERVAL for k in range(len(rows))]
        passed = sum(each < now - PERIOD - 1e-9 for each in due)
        taken += 1
        late += passed > 0
        dropped += passed == len(rows)
        actions += passed
        bench.tick(draw.randint(1, 30))
        assert bench.source.state in (StreamState.FOLLOWING, StreamState.HOLDING)
    found = bench.counts
    assert found[:4] == (taken, late, dropped, actions)
    assert 0 < dropped < late < taken
    bench.source.close()
    bench.tick(1000)
    assert (bench.source.state, bench.source.reason) == (StreamState.ENDED, Reason.CLOSED)
    assert bench.counts == found
    most = peaks(space, bench.given, PERIOD)
    noise = 1e-12 / PERIOD**3
    for group, (velocity, acceleration, jerk) in enumerate(zip(*limits, strict=True)):
        assert most.velocity[group] <= velocity * (1 + 1e-6) + noise
        assert most.acceleration[group] <= acceleration * (1 + 1e-6) + noise
        assert most.jerk[group] <= jerk * (1 + 2e-3) + noise


def test_a_chunk_within_the_limits_is_met_action_by_action() -> None:
    bench = Bench()
    bench.send(ramp(0.0, 0.0, 1))
    bench.tick()
    begin = bench.now + 0.2
    bench.send([(0.2 * (1 - math.cos(2 * k * INTERVAL)),) * 6 for k in range(60)], begin)
    bench.until(begin + 1.0)
    wanted = 0.2 * (1 - math.cos(2 * (bench.now - begin)))
    assert bench.given[-1] == pytest.approx((wanted,) * 6, abs=1e-3)
    assert bench.counts == (2, 0, 0, 0, 0)


def test_the_newer_chunk_replaces_the_older_one_from_its_time_on() -> None:
    bench = Bench()
    bench.send(ramp(0.0, 0.3, 40))
    bench.tick(20)
    begin = bench.now
    bench.send(ramp(0.3, -0.3, 60), begin + 0.5)
    bench.send(ramp(0.06, 0.0, 60), begin + 0.1)  # it takes the place of the one before, too
    bench.until(begin + 0.1)
    # Up to its time the first one goes on; the limiter begins from rest and lags a little.
    assert bench.timeline.step() == pytest.approx(
        (0.3 * (bench.now - 100.0 - PERIOD),) * 6, abs=2e-3
    )
    bench.until(begin + 0.1 + BLEND + 0.5)
    assert bench.given[-1] == pytest.approx((0.06,) * 6, abs=1e-6)
    bench.until(begin + 1.5)
    assert bench.given[-1] == pytest.approx((0.06,) * 6, abs=1e-9)


def test_what_is_followed_has_no_step_where_a_chunk_takes_over() -> None:
    """Two chunks that disagree by 30 mrad and 0.4 rad/s: no step in place nor in speed."""
    bench = Bench()
    bench.send(ramp(0.0, 0.2, 40))
    bench.tick(30)
    seen = []
    bench.send(ramp(0.03 + 0.2 * 0.3, -0.2, 40))
    for _ in range(40):
        before = bench.timeline.now
        bench.tick()
        seen.append(bench.timeline.step()[0])
        assert bench.timeline.now - before == pytest.approx(PERIOD)
    steps = [b - a for a, b in itertools.pairwise(seen)]
    changes = [abs(b - a) for a, b in itertools.pairwise(steps)]
    assert max(map(abs, steps)) < 0.9 * PERIOD
    # A step of the speed alone would be 0.4 rad/s in one tick; a step in place, 3 rad/s.
    assert max(changes) < 0.2 * PERIOD


def test_a_chunk_that_is_wholly_late_leaves_the_older_one_to_go_on() -> None:
    bench = Bench()
    bench.send(ramp(0.0, 0.2, 60))
    bench.tick(50)
    bench.send([(0.05,) * 6] * 5, bench.now - 1.0)
    bench.tick(20)
    assert bench.given[-1] == pytest.approx((0.2 * (bench.now - 100 - PERIOD),) * 6, abs=1e-3)
    assert bench.counts == (2, 1, 1, 5, 0)


def test_a_late_chunk_is_followed_from_where_it_is_by_now() -> None:
    bench = Bench()
    bench.send(ramp(0.0, 0.2, 60))
    bench.tick(50)
    begin = bench.now - 0.21
    bench.send(ramp(0.1, 0.2, 60), begin)
    bench.tick(60)
    assert bench.given[-1] == pytest.approx((0.1 + 0.2 * (bench.now - begin),) * 6, abs=1e-3)
    # Those of 0, 33, ... 200 ms before its coming; the tick itself took 10 ms.
    assert bench.counts == (2, 1, 0, 7, 0)


def test_without_a_new_chunk_the_arm_stands_at_the_last_action_and_the_stream_ends() -> None:
    bench = Bench()
    bench.send(ramp(0.0, 0.2, 10))
    assert bench.tick(20) is StreamState.FOLLOWING
    assert bench.tick(40) is StreamState.HOLDING
    assert bench.given[-1] == pytest.approx((0.2 * 9 * INTERVAL,) * 6, abs=1e-9)
    assert bench.timeline.exhausted == 1
    bench.tick(30)
    assert (bench.source.state, bench.source.reason) == (StreamState.ENDED, Reason.STARVED)


@pytest.mark.parametrize("dropped", [0, 64])
def test_a_long_chunk_that_is_sent_last_is_followed_to_its_end(dropped: int) -> None:
    """The arm stands at the chunk before it, and one tick does not take all of its actions."""
    bench = Bench()
    bench.send([ZERO])
    bench.tick(20)
    bench.send([ZERO] * dropped, bench.now - 30.0)
    way = ramp(0.0, 0.2, 200)
    bench.send(way)
    bench.source.close()
    while bench.tick() is not StreamState.ENDED:
        pass
    assert bench.source.reason is Reason.CLOSED
    assert bench.given[-1] == pytest.approx(way[-1])


def test_a_first_chunk_from_far_away_moves_nothing() -> None:
    bench = Bench()
    bench.send(ramp(0.2, 0.0, 10))
    bench.tick()
    assert (bench.source.reason, bench.given) == (Reason.TOO_FAR, [ZERO])
    assert bench.source.text.startswith("joint 1: 0.2 rad away")


def test_a_first_chunk_that_is_wholly_late_leaves_the_arm_standing() -> None:
    bench = Bench()
    bench.send(ramp(2.0, 0.0, 10), bench.now - 5)
    assert bench.tick(10) is StreamState.HOLDING
    assert set(bench.given) == {ZERO}
    assert bench.timeline.dropped == 1


def test_the_chunk_after_a_first_one_that_is_wholly_late_is_compared_with_the_arm() -> None:
    bench = Bench()
    bench.send([(0.5,) * 6] * 3, bench.now - 1.0)
    bench.tick()
    bench.send([(0.5,) * 6] * 30)
    bench.tick(20)
    assert bench.given == [ZERO, ZERO]
    assert bench.source.reason is Reason.TOO_FAR


def test_ticks_that_were_missed_are_made_up_for_little_by_little() -> None:
    timeline = ActionTimeline(JOINT_SPACE, PERIOD, INTERVAL, BLEND)
    timeline.advance(5.0)
    before, clock, longest = timeline.now, 5.0 + 0.2, 0.0
    for tick in range(200):
        # Each tick also comes up to half a period early or late.
        clock += PERIOD
        timeline.advance(clock + (0.5 if tick % 2 else -0.5) * PERIOD * 0.9)
        longest = max(longest, timeline.now - before)
        before = timeline.now
    assert longest <= 1.25 * PERIOD + 1e-12
    assert clock - timeline.now == pytest.approx(0, abs=2 * PERIOD)
