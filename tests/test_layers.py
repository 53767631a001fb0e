"""Imports go one way: what each part of the package may know of the others."""

from __future__ import annotations

import ast
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[1] / "aioduco"

#: the wire's types, generated and without a line of Thrift, count as a part of their own
BASE = {"_version", "errors", "rpc", "scheduling", "trace"}
CLIENT = BASE | {"models", "kinematics", "_wire", "supervision", "api", "streaming"}

#: by part, the parts that it may import; itself always
MAY_IMPORT: dict[str, set[str]] = {
    "_version": set(),
    "errors": set(),
    "rpc": set(),
    "scheduling": set(),
    "trace": set(),
    "models": {"errors", "rpc"},
    "kinematics": {"errors", "models"},
    "_wire": {"errors", "rpc", "trace"},
    "supervision": BASE | {"models", "_wire"},
    "api": BASE | {"models", "supervision"},
    "streaming": CLIENT - {"streaming"},
    "bus": CLIENT - {"streaming"},
    "status_port": {"errors", "models"},
    "robot": CLIENT,
    "events": {"supervision"},
    "__init__": CLIENT | {"robot", "events"},
    # the simulator is the other side: it knows the wire and the arms, and nothing of the client
    "sim": BASE | {"models", "kinematics", "_wire"},
    "testing": BASE | {"models", "_wire", "sim"},
    # what follows uses the package as a program does
    "compat": BASE | {"_wire"},
    "recording": CLIENT | {"robot", "__init__"},
    "sync": CLIENT | {"robot", "__init__"},
    "pytest_plugin": CLIENT | {"robot", "__init__", "sim", "testing"},
    "cli": CLIENT | {"robot", "__init__", "sim", "recording"},
}

#: by library, the files that may import it, each with all that is under it
ONLY_IN: dict[str, set[str]] = {
    "thriftpy2": {"_wire", "sim/server", "sim/server.py"},
    "mujoco": {"sim/world.py", "sim/dynamics.py", "sim/scene", "sim/drawing.py", "sim/viewer.py"},
    "ruckig": {"sim/planner", "streaming"},
    "eaik": {"kinematics/eaik.py"},
    "typer": {"cli"},
    "rich": {"cli", "streaming/report.py", "streaming/doctor.py"},
    "PIL": {"cli/picture.py"},
    "matplotlib": {"cli", "streaming/report.py"},
    # the thread hand-off, and tasks that outlive the task that started them
    "asyncio": {"_wire/handoff.py", "supervision/background.py"},
    "pytest": {"pytest_plugin.py"},
}

#: these are pure: no threads, sockets, clocks or files
PURE = {
    "bus/frames.py",
    "_wire/framing.py",
    "_wire/lifecycle.py",
    "_wire/pool.py",
    "_wire/semantics.py",
    "sim/controller.py",
    "sim/execution.py",
    "sim/motion.py",
    "sim/recording.py",
    "sim/standstill.py",
    "sim/warmth.py",
}
IMPURE = {"socket", "threading", "time", "queue", "anyio", "asyncio", "pathlib", "os"}


class Import(NamedTuple):
    """One import: where, and the full name of what is imported."""

    path: str
    line: int
    name: str

    def __str__(self) -> str:
        return f"aioduco/{self.path}:{self.line} imports {self.name}"


@cache
def imports() -> tuple[Import, ...]:
    """Every import of the package, those in functions and for type checkers included."""
    found = []
    for path in sorted(ROOT.rglob("*.py")):
        relative = path.relative_to(ROOT).as_posix()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found += [Import(relative, node.lineno, alias.name) for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{relative}:{node.lineno} is a relative import"
                assert node.module is not None
                found += [
                    Import(relative, node.lineno, f"{node.module}.{alias.name}")
                    for alias in node.names
                ]
    return tuple(found)


def part(name: str) -> str:
    """The part of the package that a dotted name below `aioduco` lies in."""
    first, _, rest = name.partition(".")
    if first == "_wire" and rest.partition(".")[0] == "rpc":
        return "rpc"
    return first if first in MAY_IMPORT else "__init__"


def part_of_file(path: str) -> str:
    return part(path.removesuffix(".py").removesuffix("/__init__").replace("/", "."))


def below(path: str, places: set[str]) -> bool:
    return any(path == place or path.startswith(f"{place}/") for place in places)


def test_there_is_something_to_look_at() -> None:
    assert len(imports()) > 100
    assert {part_of_file(one.path) for one in imports()} >= {"_wire", "models", "api", "sim"}


def test_every_part_has_a_rule() -> None:
    parts = {path.name.removesuffix(".py") for path in ROOT.iterdir() if path.suffix == ".py"}
    parts |= {path.parent.name for path in ROOT.glob("*/__init__.py")}
    assert parts <= set(MAY_IMPORT), "say in MAY_IMPORT what the new part may import"


def test_parts_import_only_what_is_below_them() -> None:
    wrong = [
        str(one)
        for one in imports()
        if one.name.startswith("aioduco.")
        and (target := part(one.name.removeprefix("aioduco."))) != part_of_file(one.path)
        and target not in MAY_IMPORT[part_of_file(one.path)]
    ]
    assert wrong == []


def test_no_part_is_above_itself() -> None:
    for name, allowed in MAY_IMPORT.items():
        reached: set[str] = set()
        todo = set(allowed)
        while todo:
            one = todo.pop()
            reached.add(one)
            todo |= MAY_IMPORT[one] - reached
        assert name not in reached, f"{name} may import itself through others"


@pytest.mark.parametrize("library", sorted(ONLY_IN))
def test_libraries_stay_where_they_belong(library: str) -> None:
    wrong = [
        str(one)
        for one in imports()
        if one.name.partition(".")[0].lower() == library and not below(one.path, ONLY_IN[library])
    ]
    assert wrong == []


def test_pure_modules_do_no_io() -> None:
    wrong = [
        str(one) for one in imports() if one.path in PURE and one.name.partition(".")[0] in IMPURE
    ]
    assert wrong == []
    assert {one.path for one in imports()} >= PURE


def test_importing_the_package_loads_none_of_its_extras() -> None:
    """And starts nothing: no thread, no output."""
    code = (
        "import sys, threading, aioduco\n"
        "extras = {'mujoco', 'ruckig', 'eaik', 'typer', 'rich', 'matplotlib', 'aioduco.sim'}\n"
        "print(sorted(extras & set(sys.modules)), threading.active_count())\n"
    )
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert (done.stdout, done.stderr, done.returncode) == ("[] 1\n", "", 0)
