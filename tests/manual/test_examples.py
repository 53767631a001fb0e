"""Every example that the manual prints, in three dialects, run on the simulated controller."""

from __future__ import annotations

import importlib
import math
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import anyio
import pytest

from aioduco.compat import DucoCobot

ROOT = Path(__file__).parents[2]
DIALECTS = ("async", "sync", "compat")
#: how many examples the manual prints, by section
PRINTED = {"1.3.4": 1, "1.3.6": 11, "1.3.9": 3, "1.3.15": 1}

HEADED = bytes([255, 1, 1, 2, 3, 4, 5, 6, 7, 8])
BETWEEN = bytes([255, 1, 50, 51, 255, 1])
GIVEN: dict[str, dict[str, Any]] = {
    "project": {"1.3.4-1": {"wave": 1}},
    "serial": {
        "1.3.6-1": HEADED,
        "1.3.6-2": BETWEEN,
        "1.3.6-6": bytes(range(10, 20)),
        "1.3.6-7": bytes([255, 255, *range(20, 28)]),
        "1.3.6-8": bytes([255, 1, 60, 61, 1, 255]),
    },
    "modbus": {"mbus1": 1},
}
#: what the vendor's class returns where the others raise if it went wrong
RETURNED: dict[str, dict[str, Any]] = {
    "project": {},
    "serial": dict.fromkeys([f"1.3.6-{n}" for n in (3, 4, 5, 9, 10, 11)], True),
    "modbus": {"1.3.9-2": 4, "1.3.9-3": 4},
}
WRITTEN = [b"\xff\x01", b"\xff\xff\1\2\3", b"\xff\xff\1\2\3\xff\xff"]
TOOL_WRITTEN = [b"\1\2\3", b"\xff\x01\1\2\3", b"\xff\x01\1\2\3\x01\xff"]


class Listener:
    """A device that keeps what was written to it, and answers nothing."""

    def __init__(self) -> None:
        self.received: list[bytes] = []

    def receive(self, data: bytes, /) -> bytes | None:
        self.received.append(data)
        return None


@pytest.fixture(autouse=True)
def scripts(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The folder of the examples, from which a script imports what lies beside it."""
    monkeypatch.syspath_prepend(str(ROOT / "examples" / "manual"))
    before = set(sys.modules)
    yield
    for name in set(sys.modules) - before:
        if "examples/manual" in (getattr(sys.modules[name], "__file__", None) or ""):
            del sys.modules[name]


def load(name: str) -> ModuleType:
    return importlib.import_module(name)


def plain(value: Any) -> Any:
    """What the vendor's class gives, as the others do: bytes without a sign."""
    if isinstance(value, list):
        return bytes(one % 256 for one in value)
    return value


def run(file: str, host: str, port: int) -> dict[str, Any]:
    main = load(file).main
    results: dict[str, Any] = anyio.run(main, host, port) if "_async" in file else main(host, port)
    return results


@pytest.mark.cases(7)
@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("group", GIVEN)
def test_an_example_gives_what_it_should(group: str, dialect: str) -> None:
    port, tool_port = Listener(), Listener()
    cabinet = load("cabinet")
    with cabinet.simulated(math.inf) as sim:
        sim.cabinet.serial.peer, sim.cabinet.tool_serial.peer = port, tool_port
        results = run(f"{group}_{dialect}", sim.host, sim.port)
        slaves = sim.cabinet.modbus.slaves
    expected = GIVEN[group] | (RETURNED[group] if dialect == "compat" else {})
    assert {number: plain(result) for number, result in results.items()} == expected
    if group == "serial":
        assert (port.received, tool_port.received) == (WRITTEN, TOOL_WRITTEN)
    if group == "modbus":
        assert list(slaves[cabinet.DEVICE, 1].registers.values()) == [1, 2, 3, 4, 5]
        assert list(slaves[cabinet.DEVICE, 2].coils.values()) == [True] * 5


@pytest.mark.slow
@pytest.mark.parametrize("dialect", DIALECTS)
def test_the_table_of_velocities_is_followed(dialect: str) -> None:
    cabinet = load("cabinet")
    with cabinet.simulated(math.inf) as sim:
        with DucoCobot(sim.host, sim.port) as robot:
            assert [robot.power_on(True), robot.enable(True)] == [4, 4]
        sim.speed = 0.1  # a slow clock, for which a busy machine is fast enough
        results = run(f"realtime_{dialect}", sim.host, sim.port)
    moved = results["1.3.15-1"]
    last = cabinet.JOINTS_VEL[-1]
    taken = moved[1] / last[1]  # how long at the last row's velocity
    assert 0.25 < taken < 0.7
    assert moved == pytest.approx([one * taken for one in last], rel=0.1, abs=1e-4)


def test_each_printed_example_is_there_in_each_dialect(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    writer = load("manual_examples")
    expected = [f"{section}-{n}" for section, most in PRINTED.items() for n in range(1, most + 1)]
    for dialect in DIALECTS:
        assert writer.numbers(dialect) == expected
    assert len(expected) == 16


def test_the_page_shows_the_files() -> None:
    page = (ROOT / "docs/guides/manual-examples.md").read_text("utf-8")
    titles = re.findall(r'^```python title="(.+)"$', page, re.MULTILINE)
    assert titles == ["aioduco", "aioduco.sync", "aioduco.compat"] * 16
