"""How errors show the value that was given."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import aioduco
from aioduco.devices.cameras import calibrate_hand_eye
from aioduco.errors import Described, ParameterError
from aioduco.kinematics import calibrate_tool_tip
from aioduco.models.similar import did_you_mean
from aioduco.supervision.events import LoopBlocked, TwinDiverged


def test_what_is_described_is_not_quoted() -> None:
    views = [np.eye(4)] * 2
    with pytest.raises(ParameterError, match="flanges is 2 views, but must be 4 or more"):
        calibrate_hand_eye(views, views)
    with pytest.raises(ParameterError, match="flanges is 2 touches, but must be"):
        calibrate_tool_tip(views)
    error = ParameterError("points", Described("2 points"), "3 or more")
    for other in (pickle.loads(pickle.dumps(error)), copy.deepcopy(error)):
        assert str(other) == "points is 2 points, but must be 3 or more; nothing was sent"
        assert repr(other.value) == "2 points"


def test_a_question_ends_its_sentence() -> None:
    error = aioduco.ParameterError("kind", "bx", f"box{did_you_mean('bx', ['box'])}")
    assert str(error) == "kind is 'bx', but must be box: did you mean 'box'? Nothing was sent"


def test_an_event_is_short() -> None:
    assert LoopBlocked(0.0, 0.329978032001236, "").line() == "loop blocked: seconds 0.33"


def test_since_when_arm_and_twin_are_apart_is_a_duration() -> None:
    event = TwinDiverged(
        81234.75, "torque", "joint 2", 81234.5, 2.0, 1.0, "N·m", "unknown", {}, "report"
    )
    assert event.line() == (
        "twin diverged: quantity torque, where joint 2, for 0.25 s, value 2, limit 1, unit N·m, "
        "cause unknown, action report"
    )
