"""What is asked of the system's scheduler."""

from __future__ import annotations

import os
import threading

import pytest

from aioduco.scheduling import shorten_slice


@pytest.mark.linux("policies of the scheduler")
@pytest.mark.parametrize(
    ("policy", "priority", "taken"),
    [("SCHED_BATCH", 0, False), ("SCHED_RR", 1, True), ("SCHED_FIFO", 1, True)],
)
def test_a_short_slice_leaves_another_policy_as_it_is(
    policy: str, priority: int, taken: bool
) -> None:
    """A worker of a program that runs in real time is not put behind everything else."""
    found: list[object] = []

    def run() -> None:
        try:
            os.sched_setscheduler(0, getattr(os, policy), os.sched_param(priority))
        except PermissionError:
            return
        found.append(shorten_slice(1_000_000))
        found.append(os.sched_getscheduler(0) == getattr(os, policy))

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    if not found:
        pytest.skip("no permission for a policy of real time")
    assert found == [taken, True]
