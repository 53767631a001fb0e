"""What `import aioduco` brings, and when: names are loaded when they are used."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import aioduco

SOURCE = ast.parse(Path(aioduco.__file__).read_text(encoding="utf-8"))


def run(code: str) -> str:
    """What some code prints in an interpreter of its own."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert (done.stderr, done.returncode) == ("", 0)
    return done.stdout.strip()


def told_to_type_checkers() -> dict[str, str]:
    """By name the module from which the package's source imports it for type checkers."""
    (block,) = (node for node in SOURCE.body if isinstance(node, ast.If))
    assert ast.unparse(block.test) == "TYPE_CHECKING"
    found: dict[str, str] = {}
    for node in block.body:
        assert isinstance(node, ast.ImportFrom)
        assert node.module is not None
        found |= {alias.name: node.module for alias in node.names}
    return found


def test_importing_the_package_loads_no_dependency() -> None:
    heavy = {"numpy", "anyio", "asyncio", "thriftpy2", "multiprocessing", "dataclasses"}
    assert run(f"import sys, aioduco; print({heavy} & set(sys.modules))") == "set()"


def test_a_value_is_loaded_without_the_robot() -> None:
    code = "import sys; from aioduco import OperationMode; print('aioduco.robot' in sys.modules)"
    assert run(code) == "False"


@pytest.mark.parametrize("name", sorted(set(aioduco.__all__) - set(aioduco.errors.__all__)))
def test_a_name_is_what_type_checkers_were_told(name: str) -> None:
    told = told_to_type_checkers()
    if name == "__version__":
        assert name not in told
    elif name == "events":
        assert told[name] == "aioduco"
        assert run("import aioduco; print(aioduco.events.__name__)") == "aioduco.events"
    else:
        assert aioduco._HOME[name] == told[name]
        assert getattr(aioduco, name) is vars(sys.modules[told[name]])[name]


def test_what_is_loaded_when_it_is_used_is_public_and_told_to_type_checkers() -> None:
    assert set(aioduco._HOME) | {"events"} == set(told_to_type_checkers())
    assert set(told_to_type_checkers()) <= set(aioduco.__all__)
    assert len(aioduco.__all__) == len(set(aioduco.__all__))


def test_dir_lists_every_public_name_before_it_is_loaded() -> None:
    code = (
        "import aioduco; print(set(aioduco.__all__) - set(dir(aioduco)), 'Joints' in dir(aioduco))"
    )
    assert run(code) == "set() True"


def test_a_star_brings_every_public_name() -> None:
    code = "import aioduco\nfrom aioduco import *\nprint(set(aioduco.__all__) - set(globals()))"
    assert run(code) == "set()"


def test_another_name_is_refused_as_of_any_module() -> None:
    with pytest.raises(AttributeError, match="module 'aioduco' has no attribute 'movej'"):
        getattr(aioduco, "movej")  # noqa: B009  # a type checker would refuse it, too
    with pytest.raises(ImportError, match="cannot import name 'movej'"):
        exec("from aioduco import movej")
