"""Samples: signals by the controller's numbers."""

from __future__ import annotations

import math
from typing import Any

import pytest

from aioduco._wire import rpc
from aioduco.errors import ParameterError
from aioduco.models.samples import Samples
from aioduco.models.state import standing


def test_signals_have_the_controllers_numbers() -> None:
    on = [True, False] * 8
    sample = Samples().io(
        rpc.IOStatus(
            digitalInputs=on, digitalOutputs=on[::-1], toolIOIn=[True, False], toolIOOut=[False] * 2
        )
    )
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
