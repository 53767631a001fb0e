"""Imports go one way: what each part of the package may know of the others."""

from __future__ import annotations

import ast
import importlib
import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[1] / "aioduco"

BASE = {
    "_process.copying",
    "_process.closing",
    "_process.trial",
    "__version__",
    "_process.linked_process",
    "_process.platform",
    "_process.program_lines",
    "_process.spawn",
    "models.controller_clock",
    "errors",
    "_process.reporting",
    "_wire.rpc",
    "_wire.newer",
    "_process.scheduling",
    "models.trace",
    "models.host_port",
    "models.similar",
    "models.address",
}
CLIENT = BASE | {
    *("models", "kinematics", "envelope", "_wire", "supervision", "api", "streaming"),
}

#: by part, the parts that it may import; itself always. A part is a folder or module with all that
#: is below it, but for what is a part of its own.
MAY_IMPORT: dict[str, set[str]] = {
    "_process.copying": {"errors"},
    "_process.closing": {"_process.copying"},
    "__version__": set(),
    "_process": set(),
    "_process.program_lines": set(),
    "_process.trial": set(),
    "_process.platform": set(),
    "_process.spawn": {"_process.platform"},
    "_process.linked_process": {"_process.platform", "_process.spawn"},
    "models.controller_clock": set(),
    "models.host_port": set(),
    "models.similar": set(),
    "models.address": {"errors", "models.similar", "models.host_port"},
    "errors": {"models.host_port"},
    # the wire's types, generated and without a line of Thrift
    "_wire.rpc": set(),
    "_wire.newer": {"_wire.rpc"},
    "_process.scheduling": set(),
    "_process.reporting": {"_process.copying"},
    "models.trace": {"_process.reporting"},
    "models": {
        *("_process.copying", "errors", "_wire.rpc", "_wire.newer"),
        *("models.similar", "models.address"),
    },
    "kinematics": {"errors", "models"},
    "descriptions": {"errors", "models", "kinematics"},
    # limits and their check: pure, and without numpy where the worker of a stream imports it
    "envelope": {"errors", "models", "kinematics"},
    "_wire": {
        *("_process.platform", "_process.trial", "errors", "_process.reporting", "models.trace"),
        *("_wire.rpc", "_wire.newer", "models.address", "models.host_port"),
    },
    "supervision": BASE | {"models", "envelope", "_wire"},
    "streaming": BASE | {"models", "envelope", "_wire", "supervision"},
    "api": BASE | {"models", "supervision", "streaming"},
    "recording.tap": BASE | {"_wire"},
    "devices": set(),
    "devices.bus": BASE | {"models", "api"},
    # drivers of grippers: they use a robot by its public interface
    "devices.grippers": BASE | {"models", "supervision", "api", "devices.bus", "robot"},
    "api.port_reader": {
        *("_process.copying", "errors", "models", "models.address", "models.host_port", "_wire"),
    },
    "api.status_port": {"errors", "models", "api.port_reader"},
    "api.force_stream": {"models", "api.port_reader"},
    "recording": CLIENT,
    # the twin of a robot: pure on the simulator's side, and a shell on the client's
    "sim.twin": CLIENT | {"recording", "sim"},
    "robot": CLIENT | {"recording", "sim.twin"},
    # moves a robot by its public interface
    "recording.playback": CLIENT | {"recording", "robot"},
    # lead a robot by its public interface
    "devices.teleoperation": CLIENT | {"robot"},
    # the mains of all processes, each imported in its own process alone
    "_process.frozen": CLIENT | {"planning", "sim", "sim.twin", "recording.tap"},
    "__init__": CLIENT | {"robot", "_process.frozen", "recording", "planning.cell"},
    # the simulator is the other side: it knows the wire and the arms, and nothing of the client
    "sim": BASE | {"models", "kinematics", "_wire"},
    # estimates what a simulator plays from recordings of an arm
    "sim.calibration": BASE | {"models", "kinematics", "sim", "recording"},
    "testing": BASE | {"models", "_wire", "sim", "kinematics", "recording"},
    # what follows uses the package as a program does
    "compat": BASE | {"_wire"},
    # knows arms, the simulator's physics and trajectories, and no robot
    "planning": BASE | {"models", "kinematics", "streaming", "sim"},
    # the file of a cell: makes robots, simulators and scenes, each by its public interface
    "planning.cell": CLIENT
    | {"robot", "sim", "planning", "recording.playback", "devices.grippers"},
    "sync": CLIENT
    | {"robot", "__init__", "recording", "recording.playback", "planning.cell", "sim.twin"}
    | {"devices.grippers", "devices.teleoperation"},
    "testing.preflight": CLIENT | {"robot", "__init__", "sim", "sync", "compat", "planning"},
    # on top of the public interface; can be deleted with its folder
    "integrations.panel": {
        *("errors", "kinematics", "envelope", "__init__", "planning", "sim.twin"),
        *("_process.copying", "models", "models.host_port", "recording.playback"),
    },
    # bridges to other systems: the public interface alone, and the simulator for environments
    "integrations": {
        *("errors", "kinematics", "descriptions", "models.trace", "__init__", "models", "sim"),
        *("_process.copying", "_process.reporting", "sync"),
    },
    # gateways use robots as a program does
    "integrations.fleet": {
        "models",
        "models.similar",
        "_process.copying",
        "errors",
        "_process.reporting",
        "robot",
        "__init__",
    },
    # where a camera is and what it sees; simulated ones draw by the simulator
    "devices.cameras": {
        *("_process.copying", "errors", "models", "models.controller_clock", "kinematics", "sim"),
    },
    "testing.pytest_plugin": CLIENT
    | {"robot", "__init__", "sim", "sync", "testing", "testing.preflight"},
    "cli": CLIENT
    | {"robot", "__init__", "sim", "sim.twin", "sync", "recording", "descriptions", "planning"}
    | {"planning.cell", "devices.grippers", "devices.teleoperation"}
    | {"recording.playback", "recording.tap", "testing", "testing.preflight", "sim.calibration"}
    | {"integrations", "integrations.fleet", "integrations.panel"},
}

#: by folder or module of the simulator, which others of it that may import; itself always
SIM_MAY_IMPORT: dict[str, set[str]] = {
    "refusal": set(),
    "forgiving": {"refusal"},
    "clock": set(),
    "batches": {"clock"},
    "scene": set(),
    "process": set(),
    "view": set(),
    "planner": set(),
    "cycle": {"planner"},
    "physics": {"planner", "cycle"},
    "server": {"refusal", "trial"},
    "force": {"planner", "cycle"},
    "cabinet": {"planner", "cycle", "refusal"},
    "controller": {"planner", "force", "cabinet", "cycle", "refusal", "forgiving"},
    "planning": {"planner", "controller"},
    "snapshot": {"planner", "controller", "cycle"},
    "plant_changes": {"cycle"},
    "runtime": {
        *(
            "planner",
            "planning",
            "plant_changes",
            "cabinet",
            "controller",
            "physics",
            "cycle",
            "clock",
            "batches",
            "refusal",
        ),
        "snapshot",
    },
    "handlers": {
        "planner",
        "force",
        "cabinet",
        "controller",
        "physics",
        "runtime",
        "snapshot",
        "refusal",
        "forgiving",
        "trial",
    },
    # what a preflight is asked
    "trial": {"controller", "scene"},
    "assembly": {
        *("planner", "force", "cabinet", "controller", "physics", "handlers", "server", "view"),
        *("runtime", "forgiving", "profile", "trial"),
    },
    "simulator": {
        *("assembly", "cabinet", "controller", "physics", "server", "view"),
        *("runtime", "clock", "scene", "process", "forgiving", "part_faults", "profile"),
        *("operator_actions", "arm_pictures", "trial"),
    },
    "part_faults": {"assembly", "physics"},
    "operator_actions": {"assembly"},
    "arm_pictures": {"assembly", "physics", "view"},
    # the controller without threads and physics
    "profile": set(),
    "console": {"simulator"},
    "spawned": {"simulator"},
    "__main__": {"spawned"},
    "__init__": {"simulator", "process", "profile"},
}

#: by folder of the streams: what of the package it may import, each with all that is under it.
#: The process border runs between the worker and the rest.
STREAMING_MAY_IMPORT: dict[str, set[str]] = {
    "shared": {
        *("aioduco.streaming.shared", "aioduco._process.platform", "aioduco.errors"),
        # check what a program gives; no worker loads them
        *("aioduco.models.rules", "aioduco.models.ranges", "aioduco.models.words"),
        "aioduco.models.named_int",
    },
    "worker": {
        *("aioduco._wire", "aioduco.errors", "aioduco._process.scheduling"),
        *("aioduco._process.platform", "aioduco.supervision.unanswered"),
        *("aioduco.envelope.checker", "aioduco.envelope.limits", "aioduco.envelope.zones"),
        *("aioduco.streaming.shared", "aioduco.streaming.worker"),
        "aioduco.models.enums",  # names of states, for a person
    },
}
#: and of the others, what neither of them may import
NAMED_MEMORY = "shared/backing.py"  # loads shared memory with a name, where there is no other
NOT_IN_A_WORKER = {"anyio", "asyncio", "numpy", "concurrent", "multiprocessing"}

#: by package, how many modules may import one another in a row
LONGEST_CHAIN = {"aioduco.streaming": 9, "aioduco.supervision": 9}

#: packages of which no module imports itself through others; `.ci/count` looks at all of them
FREE_OF_CIRCLES = [
    *("aioduco.sim", "aioduco.api", "aioduco.sync", "aioduco.models", "aioduco.recording"),
    *("aioduco.integrations.gym", "aioduco.devices.grippers"),
    *("aioduco.envelope", "aioduco.kinematics"),
]

#: by library, the files that may import it, each with all that is under it
ONLY_IN: dict[str, set[str]] = {
    "thriftpy2": {"_wire", "sim/server"},
    "mujoco": {
        *("sim/physics", "sim/view/drawing.py", "sim/view/viewer.py"),
        *("planning/band.py", "planning/collision.py"),
    },
    # OMPL's bindings complain when an interpreter ends: it is loaded in the planner's process alone
    "ompl": {"planning/search.py"},
    "scipy": {"sim/calibration"},
    "ruckig": {"sim/planner", "streaming"},
    "typer": {"cli"},
    "rich": {"cli", "streaming/report.py"},
    "PIL": {
        *("cli/picture.py", "cli/demo/planned.py"),
        *("testing/artefacts.py", "testing/preflight/html.py"),
    },
    "distributed": {"testing/preflight/sweep.py"},
    "matplotlib": {"cli", "recording/figures.py"},
    # connections on the event loop, what wakes it, and tasks that outlive the one that started them
    # and, in the process of a preflight, the program's own loops
    "asyncio": {
        *("_wire/channel.py", "_wire/lane.py", "_wire/owner_loop.py", "_wire/pool.py"),
        *("supervision/concurrency.py",),
        *("testing/preflight/child.py", "testing/preflight/lines.py"),
        "testing/preflight/patches.py",
        # pages and their pictures, by the event loop of the library that serves them
        *("integrations/panel/page_connection.py", "integrations/panel/page_server.py"),
        "integrations/panel/picture_door.py",
    },
    "pytest": {"testing/pytest_plugin.py"},
    "foxglove": {"recording/channels.py"},
    "zstandard": {"recording/container.py"},
    "pyarrow": {"recording/tables.py"},
    "viser": {f"integrations/panel/{name}.py" for name in ("arm_scene", "picture_door")},
    "websockets": {"integrations/panel"},
    **{
        name: {"integrations/ros/ros1"}
        for name in ("rospy", "actionlib", "genpy", "genmsg", "rosgraph")
    },
    "rclpy": {"integrations/ros/ros2"},
    "opentelemetry": {"integrations/otel"},
    "zenoh": {"integrations/fleet/link.py"},
    "gymnasium": {"integrations/gym"},
    "cv2": {"devices/cameras"},
}

#: these are pure: no threads, sockets, clocks or files
PURE = {
    "devices/bus/frames.py",
    "_wire/framing.py",
    "_wire/lifecycle.py",
    "_wire/failures.py",
    "_wire/idempotence.py",
    "supervision/unanswered.py",
    "sim/controller",
    "sim/force",
    "sim/planner",
    *("sim/physics/temperature.py", "sim/physics/drives.py"),
    *(
        f"sim/twin/{name}.py"
        for name in ("data", "monitor", "patterns", "predictor", "rehearsal", "timeline")
    ),
    *(f"sim/calibration/{name}.py" for name in ("geometry", "drives", "times", "torques")),
    "sim/calibration/heartbeat.py",
    "envelope",
    "integrations/ros/trajectory_goals.py",
    "integrations/ros/goal_queue.py",
    "integrations/ros/arm_readings.py",
    "integrations/ros/shared_messages.py",
    "integrations/ros/node_parameters.py",
    "integrations/fleet/reports.py",
    "integrations/fleet/gateway_state.py",
    "integrations/panel/control_lease.py",
    "integrations/panel/page_requests.py",
    "integrations/panel/page_state.py",
}
IMPURE = {"socket", "threading", "time", "queue", "anyio", "asyncio", "pathlib", "os"}


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


@pytest.mark.parametrize("name", sorted(BASE - {"_wire.rpc", "__version__"}))
def test_what_is_imported_of_the_base_is_in_its_list_of_names(name: str) -> None:
    module = importlib.import_module(f"aioduco.{name}")
    # what the errors' own classes stand on is no error
    listed = {*module.__all__, "*", *(("Described", "Portable") if name == "errors" else ())}
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


@pytest.mark.parametrize("package", FREE_OF_CIRCLES)
def test_no_module_imports_itself_through_others(package: str) -> None:
    """Imports for type checkers included."""
    graph = imported_modules(package)
    assert len(graph) > 3
    while leaves := {name for name, others in graph.items() if not others}:
        graph = {name: others - leaves for name, others in graph.items() if name not in leaves}
    assert graph == {}


@pytest.mark.parametrize("folder", sorted(STREAMING_MAY_IMPORT))
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


@pytest.mark.parametrize("package", sorted(LONGEST_CHAIN))
def test_no_chain_of_imports_is_long_or_leads_back_to_itself(package: str) -> None:
    """Imports for type checkers included: each round takes away what imports none of the rest."""
    graph = imported_modules(package)
    assert len(graph) > 10
    rounds = 0
    while leaves := {name for name, others in graph.items() if not others}:
        graph = {name: others - leaves for name, others in graph.items() if name not in leaves}
        rounds += 1
    assert graph == {}
    assert rounds <= LONGEST_CHAIN[package]


@pytest.mark.parametrize("library", sorted(ONLY_IN))
def test_libraries_stay_where_they_belong(library: str) -> None:
    wrong = [
        str(one)
        for one in imports()
        if one.name.partition(".")[0].lower() == library and not below(one.path, ONLY_IN[library])
    ]
    assert wrong == []


@pytest.mark.slow
def test_processes_are_started_in_one_place() -> None:
    """In a frozen program, an interpreter that is started is the program once more."""
    starts = {"Popen", "run", "call", "check_call", "check_output"}
    found = {
        path
        for path in modules().values()
        for node in ast.walk(ast.parse((ROOT / path).read_text(encoding="utf-8")))
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
