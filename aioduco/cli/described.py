"""Commands that are described in one place, their docstring."""

from __future__ import annotations

import re
from typing import Any, Final

from typer.core import TyperCommand

_PARAMETER: Final = re.compile(r"^    (\w+): ((?:.|\n {5,})+)", re.MULTILINE)


class DescribedCommand(TyperCommand):
    """A command whose options and arguments have the help that its docstring gives them.

    The section `Args:` ends the docstring. A switch that is off by default has no `--no-…`.
    """

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        text, _, described = (self.help or "").partition("\n\nArgs:\n")
        self.help: str | None = text
        helps = {name: " ".join(text.split()) for name, text in _PARAMETER.findall(described)}
        for parameter in self.params:
            options: Any = parameter  # arguments and options have a help, their base class none
            options.help = helps.get(str(parameter.name), options.help)
            if parameter.default is False:
                parameter.secondary_opts = []
