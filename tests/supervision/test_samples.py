"""Samples of the state: values of the wire, frozen and in SI units."""

from __future__ import annotations

import copy
import dataclasses
import pickle
import time
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from for_each import for_each

from aioduco._wire import rpc
from aioduco.errors import StaleState
from aioduco.models.enums import OperationMode, ProgramState, RobotState, SafetyState
from aioduco.models.samples import Samples
from aioduco.models.state import vector

if TYPE_CHECKING:
    from collections.abc import Callable

SIX = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]


def status() -> rpc.RobotStatus:
    return rpc.RobotStatus(
        jointActualPosition=SIX,
        jointExpectPosition=SIX,
        cartActualPosition=SIX,
        cartExpectPosition=SIX,
        jointActualVelocity=[*SIX, 7.0],
        slaveReady=[True] * 6,
        collision=True,
        collisionAxis=4,
        robotState=6,
        robotError=1,
    )


def test_states_are_named_and_numbered() -> None:
    samples = Samples()
    before = time.monotonic()
    first, second = samples.states([6, 0, 5, 1]), samples.states([6, 3, 5, 0, 9])
    assert first.robot is RobotState.ENABLE
    assert first.program is ProgramState.STOPPED
    assert first.safety is SafetyState.RUN
    assert first.mode is OperationMode.AUTO
    assert str(second) == "robot ENABLE, program PAUSED, safety RUN, mode MANUAL"
    assert [first.sequence, second.sequence] == [0, 1]
    assert before <= first.received_at <= second.received_at
    assert 0 <= first.age < 60


@for_each("wire", [[], [6, 0, 5]])
def test_states_of_a_controller_that_is_starting(wire: list[int]) -> None:
    with pytest.raises(StaleState, match="still starting"):
        Samples().states(wire)


def test_status_is_frozen_and_what_was_not_sent_is_not_a_number() -> None:
    sample = Samples().status(status())
    assert list(sample.joints) == SIX
    assert list(sample.pose) == SIX
    assert sample.collision
    assert sample.collision_axis == 4
    assert sample.state is RobotState.ENABLE
    np.testing.assert_array_equal(sample.joint_speeds, SIX)
    assert np.isnan(sample.joint_temperatures).all()
    with pytest.raises(ValueError, match="read-only"):
        sample.joint_speeds[0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        sample.error = 2  # type: ignore[misc]  # that it cannot be set is the point


@for_each("way", [copy.copy, copy.deepcopy, lambda sample: pickle.loads(pickle.dumps(sample))])
def test_a_status_is_copied_whole_before_its_values_are_used(way: Callable[[Any], Any]) -> None:
    samples = Samples()
    copied, used = way(samples.status(status())), samples.status(status())
    for each in dataclasses.fields(used)[2:]:
        np.testing.assert_array_equal(getattr(copied, each.name), getattr(used, each.name))


@for_each("field", ["jointActualPosition", "cartExpectPosition"])
def test_status_without_positions_is_refused(field: str) -> None:
    wire = status()
    setattr(wire, field, [])
    with pytest.raises(StaleState, match="0 of 6"):
        Samples().status(wire)


def test_vector_is_cut_or_filled() -> None:
    np.testing.assert_array_equal(vector([1, 2, 3], 2), [1, 2])
    np.testing.assert_array_equal(vector([1], 2), [1, np.nan])


def test_io_status_keeps_every_list() -> None:
    wire = rpc.IOStatus(digitalInputs=[True, False], wordRegisterInputs=[7], toolButton=[True])
    sample = Samples().io(lambda: wire)
    assert sample.digital_inputs == (True, False)
    assert sample.word_inputs == (7,)
    assert sample.tool_buttons == (True,)
    assert sample.analog_current_inputs == ()
