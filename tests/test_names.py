"""One class name means one thing in the whole package, and few modules share a name."""

from __future__ import annotations

import ast
import gc
from collections import defaultdict
from functools import cache
from pathlib import Path

import pytest
from public_classes import named_on_pages, own_names
from test_layers import BASE

ROOT = Path(__file__).parents[1] / "aioduco"

#: folders and files whose classes may be called as another's, since they are the same thing again
SAME_AGAIN = {
    "sync": "the blocking face of api, robot, tasks and feeds: the same classes without await",
    "_wire/rpc.py": "the structs of the IDL by its own names; `models` has them for programs",
    "_wire/newer.py": "those that the newer manual adds, likewise",
}

#: folders whose modules are called as the manual's sections are, each folder in parallel to `api`
BY_SECTION = {
    "api": "one module for each section of the manual",
    "sync": "the blocking face of api",
    "sim/handlers": "the simulator's answers to the functions of one section",
}


@cache
def modules(having: str = "") -> dict[str, ast.Module]:
    """The package's modules by their path below it, of those whose text has that."""
    texts = {path: path.read_text(encoding="utf-8") for path in sorted(ROOT.rglob("*.py"))}
    gc.disable()  # of the trees nothing is garbage, and to look at them takes longest
    try:
        return {
            path.relative_to(ROOT).as_posix(): ast.parse(text)
            for path, text in texts.items()
            if having in text
        }
    finally:
        gc.enable()


#: other modules whose names are public
LISTED = {"sim/scene.py", "supervision/events.py"}
#: modules that list all that they define
WHOLE = {"api/blocking.py", "robot.py"}


def lies_in(path: str, places: dict[str, str]) -> bool:
    return any(path == place or path.startswith(f"{place}/") for place in places)


def shared_names(trees: dict[str, ast.Module]) -> dict[str, list[str]]:
    """The public class names that stand for two things, with where they are defined."""
    places: defaultdict[str, list[str]] = defaultdict(list)
    for path, tree in trees.items():
        if lies_in(path, SAME_AGAIN):
            continue
        for node in tree.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].append(path)
    return {name: paths for name, paths in places.items() if len(paths) > 1}


@pytest.mark.slow
def test_a_class_name_means_one_thing() -> None:
    assert not shared_names(modules())


@pytest.mark.slow
def test_no_more_than_two_modules_have_one_name() -> None:
    """Besides those that are called by the manual's sections."""
    places: defaultdict[str, list[str]] = defaultdict(list)
    for path in modules():
        if not (lies_in(path, BY_SECTION) or Path(path).stem in {"__init__", "__main__"}):
            places[Path(path).stem].append(path)
    assert not {name: paths for name, paths in places.items() if len(paths) > 2}


def listed_names(tree: ast.Module) -> set[str] | None:
    """What a module lists in `__all__`; None if it has no such list."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return set(ast.literal_eval(node.value))
    return None


def test_a_list_of_names_says_more_than_the_names_do() -> None:
    """Without one, a name without an underscore is for other modules, unless it is imported.

    Modules that are not public list their names only if they export some of others again.
    """
    public = [*named_on_pages(), *(f"aioduco.{name}" for name in BASE)]
    files = {f"{name.replace('.', '/')}.py".partition("/")[2] for name in public} | LISTED
    needless = [
        path
        for path, tree in modules("__all__ =").items()
        if not path.endswith("__init__.py")
        and path not in WHOLE
        and (names := listed_names(tree)) is not None
        and (
            names == {name for name in own_names(tree) if name[0] != "_"}
            or (path not in files and names <= own_names(tree))
        )
    ]
    assert not needless
