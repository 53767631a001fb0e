"""The console of commands that draw: texts of controllers and files are shown, not carried out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

from aioduco.cli.output import shown, written

if TYPE_CHECKING:
    from collections.abc import Iterable


class SafeConsole(Console):
    """A console of rich that takes no markup from texts and colours none; styles are arguments.

    Args:
        stderr: whether it writes to the standard error.
    """

    def __init__(self, *, stderr: bool = False) -> None:
        super().__init__(stderr=stderr, markup=False, emoji=False, highlight=False)

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """What is drawn; all of it passes here, tables and live views, too."""
        for segment in super().render(renderable, options):
            if segment.control:
                yield segment
            else:
                yield Segment(shown(segment.text), segment.style)

    def _check_buffer(self) -> None:
        with written():
            super()._check_buffer()
