"""What the simulator takes although the manual forbids it: said, counted, refused if strict."""

from __future__ import annotations

import logging

import pytest

from aioduco.models.enums import TaskState
from aioduco.sim.refusal import Forgiving, Rejected


def test_what_is_forgiven_is_said_once_for_each_kind_and_counted(
    caplog: pytest.LogCaptureFixture,
) -> None:
    forgiving = Forgiving()
    with caplog.at_level(logging.WARNING, "aioduco.sim.refusal"):
        for smoothing in (0.0, 200.0):
            forgiving.forgive("servo smoothing", f"smooth_vel is {smoothing}")
        forgiving.forgive("speed", "v is 30")
    assert [record.getMessage() for record in caplog.records] == [
        "forgiven, said once for servo smoothing: smooth_vel is 0.0",
        "forgiven, said once for speed: v is 30",
    ]
    assert forgiving.counts == {"servo smoothing": 2, "speed": 1}


def test_a_strict_simulator_forgives_nothing() -> None:
    forgiving = Forgiving(strict=True)
    with pytest.raises(Rejected, match="v is 30") as refused:
        forgiving.forgive("speed", "v is 30")
    assert refused.value.state is TaskState.PARAMETER_MISMATCH
    assert forgiving.counts == {}
