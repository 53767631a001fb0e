"""Every public class of the package: those in `__all__` of its packages, and on the pages."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
from functools import cache
from pathlib import Path
from typing import Any

import aioduco

_PAGES = Path(__file__).parents[1] / "docs"
_NAMED = re.compile(r"^::: (aioduco\S*)", re.MULTILINE)
#: modules below the top whose names are public, besides those on the pages and of packages in these
_DEEPER = ("aioduco.sim.scene", "aioduco.integrations.gym.environment")
_GROUPS = ("aioduco.devices", "aioduco.integrations", "aioduco.recording", "aioduco.testing")


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
                for name in getattr(thing, "__all__", ())
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
