"""The bundle of a check holds nothing of what must not leave the machine."""

from __future__ import annotations

import getpass
import json
import platform
import zipfile
from pathlib import Path
from typing import Any

import pytest
from cli_runner import CliRunner
from for_each import for_each

from aioduco.cli.app import app
from aioduco.sim import Simulator
from aioduco.testing.conformance.bundle import Redaction, write_bundle
from aioduco.testing.conformance.controller_report import CheckResult, ControllerReport, Verdict

#: what is planted, and the part of it that must not be found
SECRETS = {
    "at 10.20.30.40:7003": "10.20.30.40",
    "from fe80::1ff:fe23:4567:890a": "fe80::1ff",
    "interface 00:1B:44:11:3A:B7": "00:1B:44",
    "token=abc": "abc",
    'password: "open sesame"': "sesame",
    "AIODUCO_PANEL_TOKEN=hunter2": "hunter2",
    "Authorization: Bearer xyzzy": "xyzzy",
    "api_key = s3cr3t": "s3cr3t",
    "user=mueller": "mueller",
    "http://anna:pass@arm.local/x": "anna",
    "write to anna.mueller@example.com": "mueller",
    "cannot read /home/mueller/run.mcap": "mueller",
    "cannot read C:\\Users\\mueller\\run.mcap": "mueller",
    "-----BEGIN PRIVATE KEY-----\nMIIE\nvQ\n-----END PRIVATE KEY-----": "MIIE",
    "key eyJhbGciOiJIUzI1NiJ9eyJzdWIiOiIx": "eyJhbGci",
    "drive SN2023A0517 was reset": "SN2023A0517",
    "drive 20230517001 was reset": "20230517001",
    "host factory-arm-7 is up": "factory-arm-7",
    "the serial is D5-0042": "D5-0042",
    "at 10.9.8.7_7003": "10.9.8.7",
    "cannot read C:\\Users\\Max Schmid\\run.mcap": "Schmid",
    "eyJhbGciOiJI.eyJzdWIiOi.dozjgN": "eyJzdWIiOi",
    "S/N 2023-1234": "2023-1234",
    "pass: tulip": "tulip",
    "host factory-arm-7.plant.example is up": "plant.example",
}
#: what the project needs to see
KEPT = (
    "GCR5-910", "gcr10_1300", "V2.8.1.3", "3.8.1", "0.0004 rad", "1e-05", "1234 N", "2.5 ms",
    "get_noneblock_taskstate", "12:30:45", "0.123456789 s", "movej2",
)  # fmt: skip
CONTROLLER = {
    "host": "factory-arm-7", "port": 7003, "name": "left", "serial_number": "D5-0042",
    "arm": "GCR5 910", "software": "V2.8.1.3", "errors": list(SECRETS),
}  # fmt: skip


def report() -> ControllerReport:
    found = "\n".join([*SECRETS, *KEPT, getpass.getuser(), platform.node()])
    result = CheckResult("Calls", "a check", "as here", found, Verdict.DIFFERENT, 0.1)
    return ControllerReport("factory-arm-7:7003", "V2.8.1.3", False, (result,))


def contents(path: Path) -> dict[str, str]:
    with zipfile.ZipFile(path) as bundle:
        return {name: bundle.read(name).decode() for name in bundle.namelist()}


def test_what_is_planted_is_not_in_the_bundle(tmp_path: Path) -> None:
    write_bundle(tmp_path / "a.zip", report(), CONTROLLER)
    files = contents(tmp_path / "a.zip")
    whole = "\n".join(files.values())
    assert [each for each in SECRETS.values() if each.lower() in whole.lower()] == []
    told = files["report.json"] + files["controller.json"]
    for word in filter(None, (getpass.getuser(), platform.node())):
        assert f"{word}\\n" not in told
        assert f"\\n{word}" not in told
    assert [each for each in KEPT if each not in files["report.json"]] == []
    assert json.loads(files["controller.json"])["arm"] == "GCR5 910"


def test_numbers_of_devices_are_kept_if_asked_for(tmp_path: Path) -> None:
    write_bundle(tmp_path / "a.zip", report(), CONTROLLER, ids=True)
    files = contents(tmp_path / "a.zip")
    assert json.loads(files["controller.json"])["serial_number"] == "D5-0042"
    assert "SN2023A0517" in files["report.json"]
    assert "hunter2" not in "".join(files.values())
    assert "numbers of devices" in files["README.txt"]


@for_each("planted, secret", SECRETS.items())
def test_each_kind_is_found_alone(planted: str, secret: str) -> None:
    known: Any = [("factory-arm-7", "<controller>"), ("D5-0042", "<serial number>")]
    assert secret not in Redaction(known).text(planted)
    assert secret not in json.dumps(Redaction(known).value({planted: [planted]}))


@pytest.mark.slow
def test_a_controller_is_bundled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AIODUCO_PANEL_TOKEN", "hunter2-and-more")
    path = tmp_path / "report.zip"
    with Simulator() as sim:
        done = CliRunner().invoke(app, ["check", f"{sim.host}:{sim.port}", "--bundle", str(path)])
        assert done.exit_code == 0, done.output
        files = contents(path)
        whole = "".join(files.values())
        for secret in (sim.host, "hunter2", str(tmp_path)):
            assert secret not in whole
    assert json.loads(files["controller.json"])["arm"] == "GCR5 910"
    assert {"README.txt", "report.md", "report.json", "computer.json"} <= files.keys()
    assert json.loads(files["report.json"])["results"]
