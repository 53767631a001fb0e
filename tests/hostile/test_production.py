"""The files for systemd and for containers decide what docs/guides/production.md says."""

from __future__ import annotations

import configparser
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import aioduco

ROOT = Path(__file__).parents[2]
FILES = ROOT / "examples" / "production"
UNIT = FILES / "aioduco.service"
STEPS = aioduco.connect("192.0.2.1")._supervisor.settings.steps
LONGEST = sum(s or 0.0 for s in (STEPS.answers, STEPS.stop, STEPS.standstill, STEPS.modes))


def test_the_service_lets_the_program_leave_and_the_guard_end_after_it() -> None:
    unit = configparser.ConfigParser(strict=True, interpolation=None)
    unit.optionxform = str  # type: ignore[assignment,method-assign]  # as configparser describes it
    unit.read_string(UNIT.read_text())
    service = unit["Service"]
    assert service["KillMode"] == "control-group"
    assert service["KillSignal"] == "SIGINT"
    assert float(service["TimeoutStopSec"]) >= LONGEST
    assert service["Restart"] == "no"
    assert "Install" not in unit, "enabled, it moves the arm when the computer starts again"
    assert int(service["LimitRTPRIO"]) >= 1
    assert "SendSIGKILL" not in service


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd is not installed")
def test_systemd_takes_the_service(tmp_path: Path) -> None:
    unit = tmp_path / UNIT.name
    # The paths and the user of the example are not on this machine.
    text = UNIT.read_text().replace("/opt/cell/.venv/bin/python", sys.executable)
    unit.write_text(text.replace("User=robot", "User=root"))
    done = subprocess.run(
        ["systemd-analyze", "verify", "--man=no", str(unit)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    said = [line for line in done.stderr.splitlines() if UNIT.name in line]
    assert said == []
    assert done.returncode == 0, done.stderr


def test_the_container_has_an_init_a_signal_to_leave_by_and_the_time_for_it() -> None:
    # Without a library for YAML: of such a plain file, one line is one setting.
    lines = re.findall(r"^ {4,6}(\w+): +([^\n#]+?) *$", (FILES / "compose.yaml").read_text(), re.M)
    settings = dict(lines)
    assert len(settings) == len(lines)
    assert settings["init"] == "true"
    assert settings["stop_signal"] == "SIGINT"
    grace = re.fullmatch(r"(\d+)s", settings["stop_grace_period"])
    assert grace is not None
    assert float(grace[1]) >= LONGEST
    assert settings["network_mode"] == "host"
    assert int(settings["rtprio"]) >= 1
    assert settings["restart"] == '"no"'


def test_the_page_shows_both_files() -> None:
    page = (ROOT / "docs" / "guides" / "production.md").read_text()
    for name in ("aioduco.service", "compose.yaml"):
        assert f'--8<-- "examples/production/{name}"' in page
