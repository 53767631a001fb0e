"""Commands that are described in one place, their docstring."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final

from typer import BadParameter
from typer.core import TyperCommand

if TYPE_CHECKING:
    from collections.abc import Iterable

_PARAMETER: Final = re.compile(r"^    (\w+): ((?:.|\n {5,})+)", re.MULTILINE)


class DescribedCommand(TyperCommand):
    """A command whose options and arguments have the help that its docstring gives them.

    The section `Args:` ends the docstring. A switch that is off by default has no `--no-…`.
    Where the address is an argument, `--host` stands for it, as in commands with other arguments.
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

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the words of a command line."""
        if any(each.name == "host" and not each.opts[0].startswith("-") for each in self.params):
            args = _host_as_argument(args)
        return super().parse_args(ctx, args)


def _host_as_argument(words: Iterable[str]) -> list[str]:
    """The same words, with what `--host` gives as the last argument."""
    options: list[str] = []
    arguments: list[str] = []  # after `--`, where none is an option
    hosts: list[str] = []
    rest = iter(words)
    for word in rest:
        name, equals, value = word.partition("=")
        if word == "--":
            arguments += rest
        elif name != "--host":
            options.append(word)
        elif (host := value if equals else next(rest, "")) and not host.startswith("-"):
            hosts.append(host)
        else:
            raise BadParameter("--host needs an address, or a name of your robots.toml")
    arguments += hosts
    return [*options, "--", *arguments] if arguments else options
