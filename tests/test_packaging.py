"""Promises of the installed package: version, types, extras."""

from __future__ import annotations

import importlib.metadata
import re
import tomllib
from pathlib import Path
from types import SimpleNamespace

import pytest
from interpreter import python

import aioduco

ROOT = Path(__file__).parents[1]


def test_version_is_that_of_the_installed_package() -> None:
    assert importlib.metadata.version("aioduco") == aioduco.__version__
    assert re.fullmatch(r"\d+\.\d+\.\d+(\.dev\d+|rc\d+)?", aioduco.__version__)


def test_core_depends_on_three_packages() -> None:
    required = importlib.metadata.requires("aioduco") or []
    core = {re.split(r"[<>=!~ ;\[]", one)[0] for one in required if "extra ==" not in one}
    assert core == {"anyio", "thriftpy2", "numpy"}


def test_command_line_says_what_it_needs_when_its_extra_is_missing() -> None:
    done = python(
        "-Werror",
        "-c",
        "import sys; sys.modules['typer'] = None; from aioduco.cli import main; main()",
    )
    assert done.returncode == 1
    assert done.stderr.strip() == "the command aioduco needs typer: pip install 'aioduco[cli]'"


@pytest.mark.cases(2)
@pytest.mark.parametrize(
    ("absent", "extra", "program"),
    [
        ("matplotlib", "plot", "from aioduco.cli import stream_figure as f; f.plot({}, 'x.png')"),
        ("mujoco", "sim", "from aioduco.sim import Simulator; Simulator()"),
        ("mujoco", "sim", "from aioduco.testing.preflight import preflight"),
        ("gymnasium", "gym", "import aioduco.integrations.gym"),
        ("cv2", "camera", "from aioduco.devices.cameras import OpenCvCamera"),
        ("websockets", "panel", "from aioduco.integrations.panel import Panel"),
        ("opentelemetry", "otel", "from aioduco.integrations.otel import Telemetry"),
    ],
)
def test_a_missing_extra_is_a_typed_error_that_says_what_to_install(
    absent: str, extra: str, program: str
) -> None:
    # As if it were not installed, for this package and for all that it imports.
    code = f"""
import importlib.abc, pickle, sys
class Absent(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.split('.')[0] == {absent!r}:
            raise ModuleNotFoundError(f'No module named {{name!r}}', name=name)
sys.meta_path.insert(0, Absent())
import aioduco
try:
    {program}
except aioduco.MissingExtra as error:
    assert isinstance(error, ModuleNotFoundError) and error.name == {absent!r}
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.extra) == (str(error), error.extra)
    print(error.extra, error)
"""
    done = python("-Werror", "-c", code)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith(f"{extra} ")
    assert done.stdout.endswith(f"needs {absent}: pip install 'aioduco[{extra}]'\n")


def test_a_python_for_which_a_package_is_not_built_yet_is_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    install = "planning needs ompl: pip install 'aioduco[plan]'"
    more = " under Python 3.13: OMPL has no build for newer ones yet"
    for version, told in ((3, 13), install), ((3, 14), install + more):
        monkeypatch.setattr("aioduco.errors.sys", SimpleNamespace(version_info=version))
        assert str(aioduco.MissingExtra("planning", "ompl", "plan")) == told


def test_jerk_limits_need_their_extra_and_not_the_simulator() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    names = {
        extra: {re.split(r"[<>=\[;]", one)[0] for one in extras[extra]}
        for extra in ("sim", "stream", "cli", "plot", "plan", "sweep")
    }
    assert names == {
        "sim": {"mujoco-core", "ruckig"},
        "stream": {"ruckig"},
        "cli": {"typer", "rich"},
        "plot": {"matplotlib", "pillow"},
        "plan": {"mujoco-core", "ompl"},
        "sweep": {"distributed"},
    }
    assert extras["all"] == ["aioduco[sim,stream,cli,plot,plan,record,panel,otel,fleet]"]


def test_licence_is_whole() -> None:
    text = (ROOT / "LICENSE").read_text(encoding="utf-8")
    assert "Apache License\n                           Version 2.0, January 2004" in text
    assert "END OF TERMS AND CONDITIONS" in text
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["license"] == "Apache-2.0"


def test_changelog_has_a_place_for_the_next_change() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    headings = re.findall(r"^## \[(.+?)\]", text, flags=re.MULTILINE)
    assert headings[0] == "Unreleased"
    groups = set(re.findall(r"^### (\w+)", text, flags=re.MULTILINE))
    assert groups <= {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}
