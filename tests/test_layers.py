"""Imports go one way: which parts of the package each part may import."""

from __future__ import annotations

import ast
import importlib
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
from for_each import for_each
from interpreter import python
from public_classes import public_names

ROOT = Path(__file__).parents[1] / "aioduco"

_DATA = tomllib.loads((Path(__file__).parent / "data" / "layers.toml").read_text("utf-8"))


def _names(text: str) -> set[str]:
    """The names in a text, with those that a group of them has."""
    groups = _DATA["groups"]
    return {
        n for word in text.split() for n in (_names(groups[word]) if word in groups else [word])
    }


def _table(name: str) -> dict[str, set[str]]:
    return {key: _names(text) for key, text in _DATA[name].items()}


BASE = _names("BASE")
#: by part, the parts that it may import; itself always. A part is a folder or module with all that
#: is below it, but for what is a part of its own.
MAY_IMPORT = _table("parts")
#: by folder or module of the simulator, which others of it that may import; itself always
SIM_MAY_IMPORT = _table("sim")
#: by folder of the streams: what of the package it may import, each with all that is under it
STREAMING_MAY_IMPORT = _table("streaming")
#: by library, the files that may import it, each with all that is under it
ONLY_IN = _table("libraries")
#: these are pure: no threads, sockets, clocks or files
PURE = _names(_DATA["pure"]["files"])
IMPURE = {"socket", "threading", "time", "queue", "anyio", "asyncio", "pathlib", "os"}

#: and of the others, what neither of them may import
NAMED_MEMORY = "shared/backing.py"  # loads shared memory with a name, where there is no other
NOT_IN_A_WORKER = {"anyio", "asyncio", "numpy", "concurrent", "multiprocessing"}

#: by package, how many modules may import one another in a row
LONGEST_CHAIN = {"aioduco.streaming": 9, "aioduco.supervision": 9}
#: packages of which no module imports itself through others, in functions neither
FREE_OF_CIRCLES = [
    *("aioduco.sim", "aioduco.api", "aioduco.sync", "aioduco.models", "aioduco.recording"),
    *("aioduco.integrations.gym", "aioduco.devices.grippers"),
    *("aioduco.envelope", "aioduco.kinematics"),
]


class Import(NamedTuple):
    """One import: where, and the full name of what is imported."""

    path: str
    line: int
    name: str

    def __str__(self) -> str:
        return f"aioduco/{self.path}:{self.line} imports {self.name}"


#: what is no code, and an import where that is left out; parsing the whole package takes seconds
NO_CODE = re.compile("|".join([r'"""[\s\S]*?"""', r"'''[\s\S]*?'''", r"#[^\n]*"]))
IMPORT = re.compile(
    r"^[ \t]*(from [\w.]+ import (?:\([^)]*\)|[^\n]+)|import [^\n]+)$", re.MULTILINE
)


def statements(source: str) -> Iterator[ast.AST]:
    """The imports in a module."""
    code = NO_CODE.sub(lambda found: "\n" * found[0].count("\n"), source)
    for found in IMPORT.finditer(code):
        (node,) = ast.parse(found[1].rstrip()).body
        yield ast.increment_lineno(node, code.count("\n", 0, found.start(1)))


def imports() -> tuple[Import, ...]:
    return imports_by(statements)


@cache
def imports_by(found_in: Callable[[str], Iterable[ast.AST]]) -> tuple[Import, ...]:
    """Every import of the package, those in functions and for type checkers included."""
    found = []
    for path in sorted(ROOT.rglob("*.py")):
        relative = path.relative_to(ROOT).as_posix()
        for node in found_in(path.read_text(encoding="utf-8")):
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


@cache
def part(name: str) -> str:
    """The part of the package that a dotted name below `aioduco` lies in."""
    words = name.split(".")
    beginnings = (".".join(words[:n]) for n in range(len(words), 0, -1))
    return next((each for each in beginnings if each in MAY_IMPORT), "__init__")


def part_of_module(name: str) -> str:
    return part(name.removeprefix("aioduco").removeprefix("."))


def part_of_file(path: str) -> str:
    return part(path.removesuffix(".py").removesuffix("/__init__").replace("/", "."))


def below(path: str, places: set[str]) -> bool:
    return any(path == place or path.startswith(f"{place}/") for place in places)


@pytest.mark.slow
def test_no_import_is_overlooked() -> None:
    assert set(imports()) == set(imports_by(lambda source: ast.walk(ast.parse(source))))


def test_every_part_has_a_rule() -> None:
    parts = {path.name.removesuffix(".py") for path in ROOT.iterdir() if path.suffix == ".py"}
    parts |= {path.parent.name for path in ROOT.glob("*/__init__.py")}
    assert parts <= set(MAY_IMPORT), "say in tests/data/layers.toml what the new part may import"


def test_parts_import_only_what_is_below_them() -> None:
    wrong = [
        str(one)
        for one in imports()
        if one.name.startswith("aioduco.")
        and (target := part(one.name.removeprefix("aioduco."))) != part_of_file(one.path)
        and target not in MAY_IMPORT[part_of_file(one.path)]
    ]
    assert wrong == []


@for_each("name", sorted(BASE - {"_wire.rpc", "__version__"}))
def test_what_is_imported_of_the_base_is_in_its_list_of_names(name: str) -> None:
    module = importlib.import_module(f"aioduco.{name}")
    # what the errors' own classes stand on is no error
    listed = {*public_names(module), "*", *(("Described", "Portable") if name == "errors" else ())}
    used = {
        one.name.removeprefix(f"aioduco.{name}.")
        for one in imports()
        if one.name.startswith(f"aioduco.{name}.")
    }
    assert used - listed == set()


def test_no_part_is_above_itself() -> None:
    for name, allowed in MAY_IMPORT.items():
        reached: set[str] = set()
        todo = set(allowed)
        while todo:
            one = todo.pop()
            reached.add(one)
            todo |= MAY_IMPORT[one] - reached
        assert name not in reached, f"{name} may import itself through others"


def modules() -> dict[str, str]:
    """The files of the package by the full names of their modules."""
    return {
        f"aioduco.{path}".removesuffix(".py").replace("/", ".").removesuffix(".__init__"): path
        for path in (found.relative_to(ROOT).as_posix() for found in ROOT.rglob("*.py"))
    }


def imported_modules(prefix: str) -> dict[str, set[str]]:
    """By module with a name that begins so, which of them it imports, also for types alone.

    Parts of their own below it are left out.
    """
    names = {
        path: name
        for name, path in modules().items()
        if f"{name}.".startswith(f"{prefix}.") and part_of_module(name) == part_of_module(prefix)
    }
    graph: dict[str, set[str]] = {name: set() for name in names.values()}
    for one in imports():
        if one.path in names:
            found = one.name if one.name in graph else one.name.rpartition(".")[0]
            graph[names[one.path]] |= {found} & graph.keys() - {names[one.path]}
    return graph


def sim_part(name: str) -> str:
    return name.removeprefix("aioduco.sim").strip(".").partition(".")[0] or "__init__"


def test_folders_of_the_simulator_import_only_what_is_below_them() -> None:
    graph = imported_modules("aioduco.sim")
    assert {sim_part(name) for name in graph} == set(SIM_MAY_IMPORT)
    wrong = [
        f"{name} imports {other}"
        for name, others in graph.items()
        for other in others
        if sim_part(other) not in SIM_MAY_IMPORT[sim_part(name)] | {sim_part(name)}
    ]
    assert wrong == []


@pytest.mark.slow
def test_no_module_of_the_package_imports_itself_when_it_is_loaded_or_for_types() -> None:
    done = python(".ci/count", "models", cwd=ROOT.parent)  # of these alone are the lines counted
    assert (done.returncode, done.stderr) == (0, ""), done.stdout


@for_each("package", [*FREE_OF_CIRCLES, *LONGEST_CHAIN])
def test_no_chain_of_imports_is_long_or_leads_back_to_itself(package: str) -> None:
    """Imports in functions included: each round takes away what imports none of the rest."""
    graph = imported_modules(package)
    assert len(graph) > 3
    rounds = 0
    while leaves := {name for name, others in graph.items() if not others}:
        graph = {name: others - leaves for name, others in graph.items() if name not in leaves}
        rounds += 1
    assert graph == {}
    assert rounds <= LONGEST_CHAIN.get(package, rounds)


@for_each("folder", sorted(STREAMING_MAY_IMPORT))
def test_a_worker_imports_what_its_process_needs(folder: str) -> None:
    """Imports for type checkers included."""
    found = [one for one in imports() if one.path.startswith(f"streaming/{folder}/")]
    assert found
    allowed = tuple(f"{name}." for name in STREAMING_MAY_IMPORT[folder])
    wrong = [
        str(one)
        for one in found
        if (one.name.partition(".")[0] in NOT_IN_A_WORKER and not one.path.endswith(NAMED_MEMORY))
        or (one.name.startswith("aioduco.") and not f"{one.name}.".startswith(allowed))
    ]
    assert wrong == []


@for_each("library", sorted(ONLY_IN))
def test_libraries_stay_where_they_belong(library: str) -> None:
    found = [one for one in imports() if one.name.partition(".")[0] == library]
    assert found, f"nothing imports {library}"
    assert [str(one) for one in found if not below(one.path, ONLY_IN[library])] == []


@pytest.mark.slow
def test_processes_are_started_in_one_place() -> None:
    """In a frozen program, an interpreter that is started is the program once more."""
    starts = {"Popen", "run", "call", "check_call", "check_output"}
    texts = {path: (ROOT / path).read_text(encoding="utf-8") for path in modules().values()}
    found = {
        path
        for path, text in texts.items()
        if "subprocess" in text or "executable" in text
        for node in ast.walk(ast.parse(text))
        if (isinstance(node, ast.Attribute) and ast.unparse(node) == "sys.executable")
        or (
            isinstance(node, ast.Call)
            and ast.unparse(node.func) in {f"subprocess.{n}" for n in starts}
        )
    }
    assert found == {"_process/spawn.py"}


def test_pure_modules_do_no_io() -> None:
    wrong = [
        str(one)
        for one in imports()
        if below(one.path, PURE) and one.name.partition(".")[0] in IMPURE
    ]
    assert wrong == []
    for place in PURE:
        assert any(below(one.path, {place}) for one in imports()), f"there is no {place}"
