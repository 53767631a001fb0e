"""Lets docstrings say "in [0, π] [rad]": Markdown would read a link with the target "rad"."""

from __future__ import annotations

import re
from typing import Any

import griffe


class SectionsAreNotMade(griffe.Extension):
    """Leaves out how a section is made, and of what: programs get each from their robot."""

    def on_class(self, *, cls: griffe.Class, **_: Any) -> None:
        """Rewrite one class."""
        if "Section" in [str(base) for base in cls.bases]:
            cls.bases = []
            cls.members.pop("__init__", None)
        elif cls.path == "aioduco.api.motion.Motion":  # its bases have the motions
            cls.members.pop("__init__", None)


class UnitsAreNoLinks(griffe.Extension):
    """Escapes a bracket that follows another one after a space."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Rewrite the docstring of one object."""
        if obj.docstring is not None:
            obj.docstring.value = re.sub(r"\] \[", r"] \\[", obj.docstring.value)
