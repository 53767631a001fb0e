"""Scripts that the ordinary tests do not run: what they import of this project is there."""

from __future__ import annotations

import ast
import sys
from importlib.machinery import PathFinder
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = [ROOT / "benchmarks", ROOT / "tests"]
PLACES = [str(folder) for folder in FOLDERS]
PYTHON = b"#!/usr/bin/env python3"
SCRIPTS = [
    path
    for folder in (ROOT / ".ci", ROOT / "benchmarks", ROOT / "docs")
    for path in sorted(folder.iterdir())
    if path.is_file() and (path.suffix == ".py" or path.read_bytes().startswith(PYTHON))
]


def names(path: Path) -> set[str]:
    """Names that a module has at its top."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            found |= {alias.asname or alias.name for alias in node.names}
    return found


def lacking(script: Path) -> list[str]:
    """What a script imports at its top, of folders that hold scripts, and that is not there."""
    found = []
    for node in ast.parse(script.read_text("utf-8")).body:
        if not isinstance(node, ast.ImportFrom) or not node.module or node.level:
            continue
        root, *rest = node.module.split(".")
        if root == "aioduco" or root in sys.builtin_module_names:
            continue  # type checkers look at the first; no file holds the others
        spec = PathFinder.find_spec(root, PLACES) or PathFinder.find_spec(root)
        if spec is None:
            found.append(f"{script.name}: {node.module}")
        elif not rest and spec.origin and Path(spec.origin).parent in FOLDERS:
            here = names(Path(spec.origin))
            wanted = [alias.name for alias in node.names if alias.name not in here]
            found += [f"{script.name}: {node.module}.{name}" for name in wanted]
    return found


@pytest.mark.slow
def test_what_scripts_import_of_this_project_is_there() -> None:
    assert len(SCRIPTS) > 20
    assert [each for script in SCRIPTS for each in lacking(script)] == []
