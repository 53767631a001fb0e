"""The vendor's class in two makes: over a generated client, and `aioduco.compat`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from interop import build
from interop.conftest import _need, generated  # noqa: F401 - a fixture

from aioduco import compat

from .vendor import Generated


@dataclass(frozen=True)
class Make:
    """What a program imports."""

    cobot: Any
    op: Any


class ForeignOp:
    """An `Op` that is not of this package: its fields, and no more."""

    def __init__(self) -> None:
        for number in (1, 2, 3):
            for field, value in (
                *(("time_or_dist", 0), ("trig_io", 0), ("trig_value", False)),
                *(("trig_time", 0.0), ("trig_dist", 0.0), ("trig_event", "")),
            ):
                setattr(self, f"{field}_{number}", value)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave the program in C++ to `pytest -m interop`: it has to be compiled."""
    if "interop" in config.option.markexpr:
        return
    left = [item for item in items if "hardware_interface" in getattr(item, "fixturenames", ())]
    if left:
        config.hook.pytest_deselected(items=left)
        items[:] = [item for item in items if item not in left]


@pytest.fixture(params=["compat", pytest.param("generated", marks=pytest.mark.interop)])
def make(request: pytest.FixtureRequest) -> Make:
    if request.param == "compat":
        return Make(compat.DucoCobot, ForeignOp)
    code = request.getfixturevalue("generated")
    return Make(partial(Generated, code.client), code.structs.Op)


@pytest.fixture(scope="session")
def hardware_interface(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program in C++, with the client that the compiler generates."""
    _need("thrift", "thrift-compiler")
    _need("g++", "g++ libthrift-dev libboost-dev")
    return build.hardware_interface(build.folder(tmp_path_factory))
