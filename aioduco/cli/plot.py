"""`aioduco plot`: a recording, or the histograms of a stream, as a picture."""

from __future__ import annotations

import json
from pathlib import Path  # noqa: TC003 - typer evaluates the annotations
from typing import Annotated

import typer

from aioduco.cli import extras
from aioduco.cli.exit_codes import fail, writing
from aioduco.cli.options import refuse_unused, require_writable
from aioduco.cli.output import say
from aioduco.models.toml_files import read_text

_NOTHING_TO_DRAW = "it is neither a recording, .mcap, nor a file of StreamStatistics.save"


def plot(
    context: typer.Context,
    figures: Annotated[Path, typer.Argument(exists=True, dir_okay=False)],
    picture: Annotated[Path | None, typer.Argument()] = None,
    over: Annotated[Path | None, typer.Option(exists=True, dir_okay=False)] = None,
) -> None:
    """Draw a recording, as a PNG or as a page with zoom; or how late a stream was, as a PNG.

    aioduco plot run.mcap run.html --over last-week.mcap

    Args:
        figures: A recording, or a file of `StreamStatistics.save`.
        picture: Output file, .png or .html. Default: beside the input.
        over: Another recording, drawn dashed over it.
    """
    target = picture or figures.with_suffix(".png")
    require_writable("PICTURE", target, figures, over)
    if figures.suffix == ".mcap":
        _recording(figures, target, over)
        return
    refuse_unused(context, "a recording", "over")
    extras.need("plot")
    from aioduco.cli.stream_figure import plot as draw  # noqa: PLC0415 - needs matplotlib

    if target.suffix == ".html":
        raise typer.BadParameter(f"{target} is a page, which a recording alone can be drawn as")
    try:
        found = json.loads(read_text(figures))
    except OSError as error:
        fail(f"{figures} cannot be read: {error.strerror or error}")
    except (ValueError, RecursionError):
        fail(f"{figures} cannot be drawn: {_NOTHING_TO_DRAW}")
    try:
        with writing(target):
            draw(found, target)
    except (ValueError, LookupError, AttributeError, TypeError) as error:
        fail(f"{figures} cannot be drawn: {_NOTHING_TO_DRAW} ({error!r})")
    say(f"written to {target}")


def _recording(path: Path, target: Path, over: Path | None) -> None:
    as_page = target.suffix == ".html"
    extras.need("record", *(() if as_page else ("plot",)))
    from aioduco.errors import DucoError  # noqa: PLC0415 - for recordings alone
    from aioduco.recording import read  # noqa: PLC0415
    from aioduco.recording.figures import draw_page, draw_png  # noqa: PLC0415

    try:
        run = read(path)
        other = None if over is None else read(over)
        with writing(target):
            (draw_page if as_page else draw_png)(run, target, other)
    except DucoError as error:
        fail(str(error))
    for each in (run, other):
        if each is not None and not each.complete:
            say(f"{each.path} was cut off: it is drawn up to there")
    say(f"written to {target}")
