"""The requests of a page: messages as checked values, and what is refused."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest
from for_each import for_each

from aioduco.errors import ParameterError
from aioduco.integrations.panel.page_requests import (
    JogMotion,
    JointMotion,
    LineMotion,
    MeasureStep,
    PageAim,
    PageBeat,
    PageRequest,
    PageStop,
    Press,
    RobotAction,
    SetOutput,
    SimulatorLine,
    TakeControl,
    WriteMeasured,
    page_request,
)
from aioduco.models.jog import Jog, JogFrame

SIX = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
JOG = {"kind": "jog", "axis": 2, "direction": -1, "percent": 10}


@for_each("message, request_", [
        ({"ask": "stop"}, PageStop()),
        ({"ask": "take", "token": "t"}, TakeControl("t")),
        ({"ask": "beat", "seen": 3, "down": True}, PageBeat(3, True)),
        ({"ask": "aim", "joints": None}, PageAim(None)),
        ({"ask": "aim", "joints": SIX}, PageAim(tuple(SIX))),
        ({"ask": "do", "verb": "resume", "seen": 7}, RobotAction("resume", 7)),
        (
            {"ask": "output", "num": 3, "on": False, "tool": True, "seen": 7},
            SetOutput(3, False, True, 7),
        ),
        ({"ask": "simulator", "line": "push 0 0 40"}, SimulatorLine("push 0 0 40")),
        (
            {"ask": "measure", "step": "touch", "sensor": "torque"},
            MeasureStep("touch", "torque"),
        ),
        ({"ask": "write", "what": "tip", "name": "pen"}, WriteMeasured("tip", "pen")),
        (
            {"ask": "press", "seen": 7, "motion": JOG},
            Press(JogMotion(Jog.joint(2, -1, 10.0)), 7),
        ),
        (
            {"ask": "press", "seen": 7, "motion": JOG | {"axis": "rz", "frame": "tool"}},
            Press(JogMotion(Jog.cartesian("rz", -1, 10.0, frame=JogFrame.TOOL)), 7),
        ),
        (
            {"ask": "press", "seen": 7, "motion": {"kind": "joints", "to": SIX, "percent": 50}},
            Press(JointMotion(tuple(SIX), 0.5), 7),
        ),
        (
            {"ask": "press", "seen": 7, "motion": {"kind": "line", "to": SIX, "percent": 1}},
            Press(LineMotion(tuple(SIX), 0.01), 7),
        ),
    ])  # fmt: skip
def test_a_message_becomes_a_request(message: dict[str, Any], request_: PageRequest) -> None:
    assert page_request(json.dumps(message)) == request_


def press(**motion: Any) -> dict[str, Any]:
    return {"ask": "press", "seen": 1, "motion": {"percent": 10, **motion}}


@for_each(
    "message",
    [
        *("", "{", "[]", "3", "[" * 4000, b"\xff\xfe"),
        *({}, {"ask": "fly"}, {"ask": ["stop"]}, {"ask": "take"}, {"ask": "take", "token": 3}),
        {"ask": "beat", "seen": -1, "down": True},
        {"ask": "beat", "seen": 1.5, "down": True},
        {"ask": "beat", "seen": 1, "down": 1},
        {"ask": "aim", "joints": SIX[:5]},
        {"ask": "aim", "joints": [*SIX[:5], math.nan]},
        {"ask": "do", "verb": "shutdown", "seen": 1},
        {"ask": "do", "verb": [], "seen": 1},
        {"ask": "do", "verb": "resume"},
        {"ask": "output", "num": True, "on": True, "tool": False, "seen": 1},
        {"ask": "output", "num": 1, "on": True, "tool": False},
        {"ask": "simulator", "line": "push\nestop"},
        {"ask": "measure", "step": "fly", "sensor": "torque"},
        {"ask": "measure", "step": "pose", "sensor": 3},
        {"ask": "write", "what": "held"},
        {"ask": "write", "what": "tip", "name": "x" * 33},
        {"ask": "simulator", "line": "x" * 201},
        {"ask": "press", "seen": 1},
        press(kind="fly"),
        press(kind="jog", axis=7, direction=1),
        press(kind="jog", axis=1, direction=0),
        press(kind="jog", axis=1, direction=True),
        press(kind="jog", axis="x", direction=1, frame="moon"),
        press(kind="jog", axis="x", direction=1, frame=[]),
        press(kind="jog", axis=1, direction=1, percent=101),
        press(kind="jog", axis=1, direction=1, percent="10"),
        press(kind="joints", to=[*SIX[:5], 1e9]),
        press(kind="line", to="here"),
    ],
)
def test_what_is_off_is_refused_and_never_carried_out(message: Any) -> None:
    text = message if isinstance(message, str | bytes) else json.dumps(message)
    with pytest.raises(ParameterError):
        page_request(text)


def test_a_token_is_never_shown() -> None:
    secret = "very secret indeed"
    assert secret not in repr(page_request(json.dumps({"ask": "take", "token": secret})))
    with pytest.raises(ParameterError) as refused:
        page_request(json.dumps({"ask": "take", "token": [secret]}))
    assert secret not in str(refused.value)
