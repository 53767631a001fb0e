"""What `import aioduco` loads, and when: names are loaded when they are used."""

from __future__ import annotations

import ast
import importlib
import sys
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from for_each import for_each
from interpreter import python
from wire.servers import Peer, ScriptedServer

import aioduco.recording
import aioduco.testing
from aioduco.robot import _NEEDED_OPEN


def run(code: str) -> str:
    """What some code prints in an interpreter of its own."""
    done = python("-W", "error", "-c", code)
    assert (done.stderr, done.returncode) == ("", 0)
    return done.stdout.strip()


#: one interpreter, step by step: what it has loaded, and what else there is to see
STEPS = """
import sys, threading
loaded, seen = set(sys.modules), {}

def note(step):
    seen[step] = set(sys.modules) - loaded
    loaded.update(seen[step])

import aioduco
note("package")
seen["threads"] = threading.active_count()
seen["not listed"] = set(aioduco.__all__) - set(dir(aioduco))
from aioduco import OperationMode
note("value")
import aioduco.recording, aioduco.testing
note("parts")
robot = aioduco.connect("192.0.2.1")
note("robot")
try:
    robot.movel
except AttributeError as error:
    seen["movel"] = str(error)
print(seen)
"""


@cache
def steps() -> dict[str, Any]:
    seen: dict[str, Any] = eval(run(STEPS))
    return seen


def told_to_type_checkers(package: ModuleType = aioduco) -> dict[str, str]:
    """By name the module from which the package's source imports it for type checkers."""
    assert package.__file__ is not None
    source = ast.parse(Path(package.__file__).read_text(encoding="utf-8"))
    (block,) = (node for node in source.body if isinstance(node, ast.If))
    assert ast.unparse(block.test) == "TYPE_CHECKING"
    found: dict[str, str] = {}
    for node in block.body:
        assert isinstance(node, ast.ImportFrom)
        assert node.module is not None
        found |= {alias.name: node.module for alias in node.names}
    return found


def test_importing_the_package_loads_no_dependency_and_starts_no_thread() -> None:
    dependencies = {"numpy", "anyio", "asyncio", "thriftpy2", "multiprocessing", "dataclasses"}
    extras = {"mujoco", "ruckig", "PIL", "typer", "rich", "matplotlib", "pytest", "thrift"}
    assert steps()["package"] & (dependencies | extras | {"aioduco.sim"}) == set()
    assert steps()["threads"] == 1


def test_dir_lists_every_public_name_before_it_is_loaded() -> None:
    assert steps()["not listed"] == set()


def test_a_value_is_loaded_without_the_robot() -> None:
    assert "aioduco.models.enums" in steps()["value"]
    assert "aioduco.robot" not in steps()["value"]


def test_parts_of_the_package_load_their_names_on_first_use() -> None:
    assert "anyio" not in steps()["parts"]


def test_the_place_of_a_name_is_known_before_its_section_is_loaded() -> None:
    assert steps()["movel"] == "movel is robot.motion.movel"


@for_each("name", sorted(set(aioduco.__all__) - set(aioduco.errors.__all__)))
def test_a_name_is_what_type_checkers_were_told(name: str) -> None:
    told = told_to_type_checkers()
    if name == "__version__":
        assert name not in told
    elif name == "events":
        assert told[name] == "aioduco"
        assert aioduco.events is importlib.import_module("aioduco.events")
    else:
        assert aioduco._HOME[name] == told[name]
        assert getattr(aioduco, name) is vars(sys.modules[told[name]])[name]


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    "way",
    [
        "from aioduco.events import CollisionDetected",
        "import aioduco.events; CollisionDetected = aioduco.events.CollisionDetected",
        "from aioduco import events; CollisionDetected = events.CollisionDetected",
        "import aioduco; CollisionDetected = aioduco.events.CollisionDetected",
    ],
)
def test_classes_of_events_are_imported_in_every_usual_way(way: str) -> None:
    assert run(f"{way}\nprint(CollisionDetected.__name__)") == "CollisionDetected"


def test_what_is_loaded_when_it_is_used_is_public_and_told_to_type_checkers() -> None:
    assert set(aioduco._HOME) | {"events"} == set(told_to_type_checkers())
    assert set(told_to_type_checkers()) <= set(aioduco.__all__)
    assert len(aioduco.__all__) == len(set(aioduco.__all__))


@for_each("package", [aioduco, aioduco.recording, aioduco.testing])
def test_a_star_brings_every_public_name(package: ModuleType) -> None:
    namespace: dict[str, Any] = {}
    exec(f"from {package.__name__} import *", namespace)
    assert set(package.__all__) <= set(namespace)
    if package is not aioduco:
        told = told_to_type_checkers(package)
        assert {name: f"{package.__name__}.{at}" for name, at in package._HOME.items()} == told
        assert set(told) == set(package.__all__)


def test_another_name_is_refused_as_of_any_module() -> None:
    with pytest.raises(AttributeError, match="module 'aioduco' has no attribute 'movej'"):
        getattr(aioduco, "movej")  # noqa: B009  # a type checker would refuse it, too
    with pytest.raises(ImportError, match="cannot import name 'movej'"):
        exec("from aioduco import movej")


# -- what a program and an operator wait for -----------------------------------------------------

#: what anyio stands on
LIBRARIES = {"aioduco", "anyio", "exceptiongroup", "idna", "sniffio", "typing_extensions"}
#: parts of the standard library that nothing needs which opens a robot or stops an arm
NEEDLESS = {"email", "http", "multiprocessing", "pickle", "tempfile", "tomllib", "urllib.request"}
#: of this package, what nobody waits for: a name stands for all that is below it, too
FOR_ALL = {
    *("aioduco._process.platform", "aioduco._process.reporting", "aioduco._wire"),
    *("aioduco.errors", "aioduco.models.trace"),
    *("aioduco._process.copying", "aioduco._process.trial", "aioduco._process.wakeup"),
}
TO_CONNECT = FOR_ALL | {
    *("aioduco._process.spawn", "aioduco.envelope", "aioduco.models"),
    *("aioduco.robot", "aioduco.supervision"),
}
TO_STOP = FOR_ALL | {
    *("aioduco.cli.exit_codes", "aioduco.cli.output", "aioduco.cli.robots_file"),
    *("aioduco.cli.signals", "aioduco.cli.stopping", "aioduco.supervision.concurrency"),
    *("aioduco.supervision.operator_stop", "aioduco.supervision.stop_channel"),
    *("aioduco.supervision.rest", "aioduco.supervision.unanswered"),
    *("aioduco.models.enums", "aioduco.models.numpy_on_use", "aioduco.models.pose"),
    *(
        "aioduco.models.rotation",
        "aioduco.models.quaternions",
        "aioduco.models.address",
        "aioduco.models.host_port",
        "aioduco.models.named_int",
        "aioduco.models.samples",
        "aioduco.models.similar",
        "aioduco.models.words",
        "aioduco.models.toml_files",
        "aioduco.models.state",
    ),
}


def needless(loaded: set[str], allowed: set[str]) -> set[str]:
    """What was loaded beyond the libraries, the standard library and these of this package."""

    def is_needed(name: str) -> bool:
        package, *_ = name.split(".")
        if package != "aioduco":
            return package in LIBRARIES | sys.stdlib_module_names and name not in NEEDLESS
        packages = {each.rpartition(".")[0] for each in allowed}
        within = any(name == each or name.startswith(f"{each}.") for each in allowed)
        return name in packages or (within and name != "aioduco._wire.thrift")

    return {name for name in loaded if not is_needed(name)}


def test_a_robot_is_made_without_what_it_may_need_later() -> None:
    seen = steps()
    assert needless(seen["package"] | seen["value"] | seen["robot"], TO_CONNECT) == set()


def standing(peer: Peer) -> None:
    """A controller whose arm stands at once."""
    while (call := peer.receive()) is not None:
        peer.answer(call, [6, 0, 5, 1] if call.name == "get_robot_state" else None)


def test_a_stop_from_a_shell_loads_no_more_than_it_needs() -> None:
    with ScriptedServer(standing) as server:
        loaded = run(
            "import sys; begun = set(sys.modules)\n"
            "from aioduco.supervision.operator_stop import stop_arm as stop\n"
            "stop.__kwdefaults__ = dict.fromkeys(stop.__kwdefaults__, 30.0)  # on a busy machine\n"
            f"sys.argv[1:] = 'stop', '{server.host}:{server.port}'\n"
            "from aioduco.cli import main; main(); print(*set(sys.modules) - begun)"
        )
    said, _, modules = loaded.partition("\n")
    assert "the arm stands" in said
    assert needless(set(modules.split()), TO_STOP) == set()


OPENED = """
import sys, anyio, aioduco
async def main():
    patient = {{"connect_timeout": 30.0, "call_timeout": 30.0, "heartbeat": None}}
    async with aioduco.connect({host!r}, {port}, **patient):
        loaded = set(sys.modules)
    robot = aioduco.connect({host!r}, {port})
    for name in aioduco.Robot.__annotations__:
        getattr(robot, name)
    print(sorted(set(sys.modules) - loaded), {needed!r} - loaded)
anyio.run(main)
"""


@pytest.mark.slow
def test_an_open_robot_has_loaded_all_its_sections() -> None:
    """Later an import would hold up the event loop, and with it all that supervises the arm."""
    with ScriptedServer(standing) as server:
        code = OPENED.format(host=server.host, port=server.port, needed=set(_NEEDED_OPEN))
        assert run(code) == "[] set()"
