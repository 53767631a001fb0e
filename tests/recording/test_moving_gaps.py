"""What a recording that is made knows of the times in which the arm moved without a sample."""

from __future__ import annotations

import pytest

from aioduco.recording.moving_gaps import MovingGaps


def test_times_without_samples_count_where_the_arm_moved() -> None:
    gaps = MovingGaps()
    q = [0.0] * 6
    gaps.sampled(1.0, q)
    gaps.sampled(9.0, q)  # it stood: nothing is missing
    assert (gaps.longest, gaps.count) == (0.0, 0)
    gaps.sampled(9.05, [0.0] * 5 + [0.1])
    assert gaps.longest == pytest.approx(0.05)
    assert gaps.count == 0
    gaps.sampled(9.25, [0.0] * 5 + [0.2])
    assert gaps.longest == pytest.approx(0.2)
    assert gaps.count == 1
    gaps.sampled(9.26, [0.0] * 5 + [0.21])
    assert gaps.longest == pytest.approx(0.2)
