"""Variations: seeded, spread over workers, and none is lost with a worker."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import pytest

from aioduco.errors import ParameterError
from aioduco.kinematics import arm
from aioduco.testing.preflight import PreflightSettings, preflight
from aioduco.testing.preflight.sweep import sweep
from aioduco.testing.preflight.variation import KINDS, Variation

PROGRAM = str(Path(__file__).parent / "programs/joint_limit.py")


def test_a_seed_makes_the_same_variation_whatever_else_is_varied() -> None:
    every = Variation.of(KINDS, 7)
    assert every == Variation.of(KINDS, 7) != Variation.of(KINDS, 8)
    for kind in KINDS:
        alone = Variation.of((kind,), 7)
        assert getattr(alone, kind) == getattr(every, kind)
        assert [one for one in KINDS if getattr(alone, one)] == [kind]
    assert Variation.of((), 7) == Variation(7)


def test_what_cannot_be_varied_is_refused() -> None:
    with pytest.raises(ParameterError, match='"start", "latency"'):
        Variation.of(("colour",), 0)


def test_a_start_stays_within_the_limits() -> None:
    limited = arm("gcr5_910")
    started = Variation.of(("start",), 3).started(limited.upper, limited)
    assert all(one <= most for one, most in zip(started, limited.upper, strict=True))


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_a_killed_worker_costs_no_result_and_a_failing_seed_repeats_alone() -> None:
    distributed = pytest.importorskip("distributed")
    settings = PreflightSettings(vary=("start", "latency"), seed=5, timeout=100)
    killed: list[int] = []
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0", host="127.0.0.1"
    ) as cluster:

        def done(_: Any) -> None:
            if not killed:
                worker = next(iter(cluster.workers.values()))
                killed.append(worker.pid)
                os.kill(worker.pid, signal.SIGKILL)

        swept = sweep(PROGRAM, (), settings, 4, scheduler=cluster.scheduler_address, done=done)
    assert killed
    assert [one.seed for one in swept.results] == list(range(5, 9))
    kinds = [[each["kind"] for each in one.findings] for one in swept.results]
    assert kinds == [["joint limit"]] * 4
    alone = preflight(PROGRAM, (), PreflightSettings(vary=settings.vary, seed=8), quiet=True)
    assert [one.line for one in alone.findings] == [swept.results[3].findings[0]["line"]]
