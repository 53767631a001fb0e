"""What is asked of the system's scheduler."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from typing import TYPE_CHECKING

import pytest

from aioduco import LaneOptions
from aioduco._platform import set_first
from aioduco.scheduling import shorten_slice
from aioduco.testing import eventually_async

from .conftest import HERE

if TYPE_CHECKING:
    from .conftest import Controller


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


def allowed() -> bool:
    """Whether a thread of this program may go before all others."""
    found: list[bool] = []
    thread = threading.Thread(target=lambda: found.append(set_first(1)))
    thread.start()
    thread.join()
    return found[0]


_HOG = """
import os, time
from aioduco._platform import go_first_by_moments, goes_first

told = []
assert go_first_by_moments(0.02, lambda: told.append(os.sched_getscheduler(0)))
assert goes_first() == 1
while not told and time.process_time() < 30.0:
    pass
assert told == [os.SCHED_OTHER], told
assert goes_first() == 0
"""


def test_who_goes_first_and_does_not_wait_goes_like_all_others_again() -> None:
    if not allowed():
        pytest.skip("no permission for a policy of real time")
    done = subprocess.run([sys.executable, "-c", _HOG], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


async def test_a_lane_that_is_woken_late_goes_first_by_itself(controller: Controller) -> None:
    """At ten thousand a second each wake-up of the system's is late, sooner or later."""
    if not allowed():
        pytest.skip("no permission for a policy of real time")
    async with controller.servo.joints(v=1.0, a=5.0, rate=10_000.0) as stream:
        await stream.send(HERE)
        await eventually_async(lambda: stream.statistics().priority == 1)
        assert stream.pid is not None
        assert os.sched_getscheduler(stream.pid) == os.SCHED_FIFO
    assert not stream.statistics().unmet


@pytest.mark.parametrize(
    ("options", "priority"),
    [
        (LaneOptions(priority=0), 0),
        (LaneOptions(priority=3), 3),
        (LaneOptions(lane="thread"), 0),
    ],
)
async def test_a_lane_that_was_told_how_to_go_goes_so(
    controller: Controller, options: LaneOptions, priority: int
) -> None:
    if not allowed():
        pytest.skip("no permission for a policy of real time")
    async with controller.servo.joints(v=1.0, a=5.0, rate=10_000.0, options=options) as stream:
        await stream.play([HERE] * 300)
    assert stream.statistics().priority == priority
