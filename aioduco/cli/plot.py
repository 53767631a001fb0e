"""`aioduco plot`: the histograms of a stream as a picture."""

from __future__ import annotations

import json
from pathlib import Path  # noqa: TC003 - typer evaluates the annotations
from typing import Annotated

import typer

from aioduco.cli import extras

__all__ = ["plot"]


def plot(
    figures: Annotated[Path, typer.Argument(help="What `StreamStatistics.save` wrote.")],
    picture: Annotated[
        Path | None, typer.Argument(help="Where to write it; beside the figures if left out.")
    ] = None,
) -> None:
    """Draw how late a stream was, and where its time went, as a PNG."""
    extras.need("plot")
    from aioduco.streaming.report import plot as draw  # noqa: PLC0415 - needs matplotlib

    target = picture or figures.with_suffix(".png")
    try:
        found = json.loads(figures.read_text(encoding="utf-8"))
        draw(found, target)
    except (OSError, ValueError, KeyError, TypeError) as error:
        typer.echo(f"{figures} cannot be drawn: {error!r}", err=True)
        raise typer.Exit(1) from None
    typer.echo(f"written to {target}")
