"""The settings of a robot are those of `RobotSettings`, and `connect` takes just these."""

from __future__ import annotations

import ast
import inspect
import re
from dataclasses import MISSING, Field, fields, replace
from typing import Any

from for_each import for_each

import aioduco
import aioduco.sync
from aioduco.models.controller_clock import WallClock
from aioduco.supervision.settings import RobotSettings

FIELDS: dict[str, Field[Any]] = {each.name: each for each in fields(RobotSettings)}

#: a value other than the default, for each setting
OTHERS: dict[str, Any] = {
    "call_timeout": 2.5,
    "connect_timeout": 3.5,
    "pool_size": 5,
    "heartbeat": 1.5,
    "loop_stall_limit": 1.5,
    "on_cancel": "pause",
    "stop_timeout": 5.5,
    "standstill_timeout": 6.5,
    "unanswered_timeout": 61.0,
    "closing_steps": aioduco.ClosingSteps(stop=1.0),
    "guard": "process",
    "state_rate": 60.0,
    "lag_limit": 0.5,
    "trace": print,
    "record": "run.mcap",
    "clock": WallClock(),
}


def test_connect_takes_the_settings_with_their_types_and_alone_has_their_defaults() -> None:
    (connect,) = ast.parse(inspect.getsource(aioduco.connect)).body  # tests change its defaults
    assert isinstance(connect, ast.FunctionDef)
    assert None not in connect.args.kw_defaults
    assert [each.arg for each in connect.args.kwonlyargs] == list(FIELDS)
    for setting, arg in zip(FIELDS.values(), connect.args.kwonlyargs, strict=True):
        assert setting.default is MISSING
        assert setting.default_factory is MISSING
        assert arg.annotation is not None
        annotation = ast.unparse(arg.annotation)
        made = arg.arg == "clock"  # if there is none
        assert annotation == (f"{setting.type} | None" if made else setting.type), arg.arg


@for_each("connect", [aioduco.connect, aioduco.sync.connect])
def test_the_docstring_describes_each_setting(connect: Any) -> None:
    text = (inspect.getdoc(connect) or "").partition("Args:\n")[2].partition("\nReturns:\n")[0]
    described = re.findall(r"^    (\w+): ", text, re.MULTILINE)
    assert described == list(inspect.signature(connect).parameters)


def test_connect_passes_each_setting_on() -> None:
    usual = aioduco.connect("192.0.2.1")._supervisor.settings
    assert OTHERS.keys() == FIELDS.keys()
    for name, value in OTHERS.items():
        settings = aioduco.connect("192.0.2.1", **{name: value})._supervisor.settings
        if name == "trace":  # a function around it, without its errors
            assert settings.trace not in (None, usual.trace)
            continue
        assert settings == replace(usual, **{name: value, "clock": settings.clock})
        assert getattr(settings, name) is value
