"""The page on the architecture names only files, classes and functions that exist."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")


def place(path: str) -> Path | None:
    """Where a path of the page lies: in the repository, else in the package."""
    return next((at for at in (ROOT / path, ROOT / "aioduco" / path) if at.exists()), None)


def defined(file: Path) -> set[str]:
    """The functions and classes of a module, and its methods, with their class and without."""
    found = set()
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            found.add(node.name)
        if isinstance(node, ast.ClassDef):
            methods = (
                n for n in node.body if isinstance(n, (ast.FunctionDef, ast.AsyncFunctionDef))
            )
            for method in methods:
                found |= {method.name, f"{node.name}.{method.name}"}
    return found


def test_every_path_on_the_page_exists() -> None:
    paths = set(re.findall(r"`([\w/]+(?:/|\.py|\.thrift))`", PAGE))
    drawn = set(re.findall(r"[\w/]+/(?=[\s,;])|\b\w+\.py\b", PAGE.split("```")[1]))
    assert len(paths) > 30
    assert len(drawn) > 10
    assert {path for path in paths | drawn if place(path) is None} == set()


def test_every_step_of_a_path_exists_in_its_file() -> None:
    steps = re.findall(r"^\| `([\w/]+\.py)` \| (`[^|]+) \|", PAGE, flags=re.MULTILINE)
    assert len(steps) > 25
    missing = []
    for path, names in steps:
        file = place(path)
        known = set() if file is None else defined(file)
        found = re.findall(r"`([\w./]+)`", names)
        missing += [f"{path}: {name}" for name in found if name not in known]
    assert missing == []


@pytest.mark.slow
def test_every_method_in_the_text_exists() -> None:
    """Those that stand outside of the tables, as `Class.method`."""
    text = "".join(line for line in PAGE.splitlines(keepends=True) if not line.startswith("|"))
    package = (ROOT / "aioduco").rglob("*.py")
    known = set[str]().union(*(defined(file) for file in package if file.name != "_generated.py"))
    named = set(re.findall(r"`([A-Z]\w+\.\w+)`", text))
    assert named
    assert named - known == set()
