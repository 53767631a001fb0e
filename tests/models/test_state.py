"""Samples: signals by the controller's numbers."""

from __future__ import annotations

import copy
import dataclasses
import math
import pickle
from collections.abc import Callable
from typing import Any

import pytest

from aioduco._wire import rpc
from aioduco.errors import ParameterError, StaleState
from aioduco.models.samples import Samples
from aioduco.models.state import IOStatus, standing


def test_signals_have_the_controllers_numbers() -> None:
    on = [True, False] * 8
    wire = rpc.IOStatus(
        digitalInputs=on, digitalOutputs=on[::-1], toolIOIn=[True, False], toolIOOut=[False] * 2
    )
    sample = Samples().io(lambda: wire)
    assert [sample.input(num) for num in range(1, 17)] == on == list(sample.digital_inputs)
    assert (sample.output(1), sample.output(16)) == (False, True)
    assert (sample.tool_input(1), sample.tool_input(2)) == (True, False)
    assert not sample.tool_output(1)
    others: list[Any] = ["3", 1.0, True, None]
    for num in (0, 17, -1, *others):
        with pytest.raises(ParameterError, match="from 1 to 16"):
            sample.input(num)
    with pytest.raises(ParameterError, match="from 1 to 2"):
        sample.tool_output(3)
    with pytest.raises(StaleState, match="sent none"):
        Samples().io(rpc.IOStatus).input(1)


def test_signals_are_read_when_the_first_of_them_is_used() -> None:
    reads: list[str] = []

    def read() -> rpc.IOStatus:
        reads.append("read")
        return rpc.IOStatus(digitalInputs=[True], floatRegisterOutputs=[2.5])

    sample = Samples().io(read, 1.5)
    assert (sample.sequence, sample.received_at, reads) == (0, 1.5, [])
    assert not hasattr(sample, "digitalInputs")
    assert reads == []
    assert (sample.input(1), sample.float_outputs, reads) == (True, (2.5,), ["read"])

    def pickled(each: IOStatus) -> IOStatus:
        again: IOStatus = pickle.loads(pickle.dumps(each))
        return again

    copies: list[Callable[[IOStatus], IOStatus]] = [copy.copy, copy.deepcopy, pickled]
    for copied in copies:
        again = copied(Samples().io(read, 1.5))
        assert repr(again) == repr(sample)
        assert repr(copied(again)) == repr(sample)
    assert dataclasses.asdict(Samples().io(read, 1.5)) == dataclasses.asdict(sample)
    with pytest.raises(dataclasses.FrozenInstanceError):
        sample.digital_inputs = ()  # type: ignore[misc]


@pytest.mark.parametrize(
    ("joints", "tool", "stands"),
    [
        ([0.0] * 6, [], True),
        ([], [0.0] * 6, True),
        ([math.nan] * 6, [math.nan] * 6, None),
        ([], [], None),
        ([0.0] * 5 + [math.nan], [], None),
        ([math.nan] * 5 + [0.1], [], False),
        ([], [0.0, 0.1, 0.0, 0.0, 0.0, 0.0], False),
    ],
)
def test_an_arm_stands_if_its_speeds_say_so(
    joints: list[float], tool: list[float], stands: bool | None
) -> None:
    told = rpc.RobotStatus(
        jointActualPosition=[0.0] * 6,
        jointExpectPosition=[0.0] * 6,
        cartActualPosition=[0.0] * 6,
        cartExpectPosition=[0.0] * 6,
        jointActualVelocity=joints,
        cartActualVelocity=tool,
    )
    assert standing(Samples().status(told)) is stands
