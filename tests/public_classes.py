"""Every public class of the package: those that its packages list, and those on the pages."""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
import re
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import aioduco

if TYPE_CHECKING:
    from types import ModuleType

_PAGES = Path(__file__).parents[1] / "docs"
_NAMED = re.compile(r"^::: (aioduco\S*)", re.MULTILINE)
#: modules below the top whose names are public, besides those on the pages and of packages in these
_DEEPER = ("aioduco.sim.scene", "aioduco.integrations.gym.environment")
_GROUPS = ("aioduco.devices", "aioduco.integrations", "aioduco.recording", "aioduco.testing")


def own_names(tree: ast.Module) -> set[str]:
    """The names that a module defines at its top."""
    names: set[str] = set()
    for node in tree.body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            names.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            parts = (each for target in targets for each in ast.walk(target))
            names |= {each.id for each in parts if isinstance(each, ast.Name)}
    return names


def public_names(module: ModuleType) -> list[str]:
    """What a module lists, or the names without an underscore that it defines."""
    listed: list[str] | None = getattr(module, "__all__", None)
    if listed is not None:
        return listed
    own = own_names(ast.parse(inspect.getsource(module)))
    return sorted(name for name in own if name[0] != "_")


def named_on_pages() -> list[str]:
    """What the pages of the reference document, by full name."""
    texts = (page.read_text(encoding="utf-8") for page in sorted(_PAGES.rglob("*.md")))
    return [place for text in texts for place in _NAMED.findall(text)]


def _places() -> list[str]:
    tops = [module.name for module in pkgutil.iter_modules(aioduco.__path__, "aioduco.")]
    public = [name for name in tops if not name.startswith(("aioduco._", "aioduco.cli"))]
    for group in map(importlib.import_module, _GROUPS):
        inside = pkgutil.iter_modules(group.__path__, f"{group.__name__}.")
        public += [module.name for module in inside if module.ispkg]
    return ["aioduco", *public, *_DEEPER, *named_on_pages()]


@cache
def public_classes() -> list[type[Any]]:
    """The public classes, each once, by module and name."""
    found: set[type[Any]] = set()
    for place in _places():
        thing = _thing(place)
        if inspect.ismodule(thing):
            found.update(
                value
                for name in public_names(thing)
                if inspect.isclass(value := getattr(thing, name))
            )
        elif inspect.isclass(thing):
            found.add(thing)
    own = [each for each in found if each.__module__.startswith("aioduco")]
    return sorted(own, key=lambda each: (each.__module__, each.__qualname__))


def _thing(place: str) -> Any:
    parts = place.split(".")
    for count in range(len(parts), 0, -1):
        try:
            thing: Any = importlib.import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for name in parts[count:]:
            thing = getattr(thing, name)
        return thing
    raise AssertionError(place)
