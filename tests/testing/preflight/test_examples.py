"""Preflight finds nothing in the examples, with and without an address."""

from __future__ import annotations

from pathlib import Path

import pytest

from aioduco.sim.scene import Table
from aioduco.testing.preflight import PreflightSettings, preflight

EXAMPLES = Path(__file__).parents[3] / "examples"
#: given the address of a robot that is not there: nothing of it is ever connected to
THERE = "192.0.2.1"
BRIEF = ["--seconds", "0.4"]
WITH_ADDRESS = {
    "02_stop_from_another_task.py": [THERE],
    "03_blended_motions.py": [THERE],
    "07_plain_script.py": [THERE],
    "14_realtime_velocity.py": [THERE, *BRIEF],
    "15_policy_sync.py": [THERE, *BRIEF],
    "manual/project_async.py": [THERE],
    "press_on_table.py": [THERE],
}
#: of the manual's examples each group and each dialect; `tests/manual` runs all of them
ON_ITS_OWN: dict[str, list[str]] = {
    "13_play_npy.py": ["--seconds", "1"],
    "polish.py": [],
    "log_to_json.py": [],
    "manual/project_sync.py": [],
    "manual/realtime_async.py": [],
    "manual/serial_compat.py": [],
    "manual/modbus_sync.py": [],
}


@pytest.mark.slow
@pytest.mark.parametrize("name", WITH_ADDRESS)
def test_with_an_address_it_runs_in_the_cell_that_was_given(name: str) -> None:
    table = [Table(at=(0.5, 0.1405, 0.422))] if "table" in name else None
    settings = PreflightSettings(scene=table, timeout=110)
    report = preflight(EXAMPLES / name, WITH_ADDRESS[name], settings, quiet=True)
    assert report.ok, "\n".join(map(str, report.findings))
    assert report.status == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ON_ITS_OWN)
def test_without_one_it_runs_on_the_simulator_that_it_starts(name: str) -> None:
    for _ in range(20):
        report = preflight(
            EXAMPLES / name, ON_ITS_OWN[name], PreflightSettings(timeout=110), quiet=True
        )
        # On a machine that is too busy for long enough, a stream starves there as anywhere.
        if not any(
            each.kind == "starved stream" or "StreamRefused" in str(each)
            for each in report.findings
        ):
            break
    assert report.ok, "\n".join(map(str, report.findings))
    assert report.status == 0
