"""A recording as a picture: as PNG, or as one HTML page with zoom that needs no other files.

Two recordings can be drawn over each other, each from its begin.
"""

from __future__ import annotations

import html
import json
import math
import re
from importlib import resources
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from aioduco.errors import MissingExtra, ParameterError
from aioduco.models.whole_files import whole_file, write_whole
from aioduco.recording.run import RecordedRun, of_any_maker

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.figure import Figure, FigureBase
    from numpy.typing import NDArray


#: maximum points of a curve on a page; of more points, the lowest and the highest of each stretch
#: are drawn
_POINTS: Final = 4000
#: one for each joint; people with colour blindness can distinguish them, too
_COLOURS: Final = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
_JOINTS: Final = tuple(f"joint {number}" for number in range(1, 7))
_XYZ: Final = ("x", "y", "z")

_DEGREE: Final = 180.0 / math.pi

#: title, unit, how many of it are one of the recording's, channel, field, names of its numbers
_SHOWN: Final = (
    ("joint angles", "°", _DEGREE, "/joint_states", "position", _JOINTS),
    ("joint speeds", "°/s", _DEGREE, "/joint_states", "velocity", _JOINTS),
    ("behind the set-points", "°", _DEGREE, "/joint_states", "error", _JOINTS),
    ("tip of the tool", "m", 1.0, "/tf", "tcp.translation", _XYZ),
    ("force", "N", 1.0, "/wrench", "force", _XYZ),
    ("torque", "N·m", 1.0, "/wrench", "torque", _XYZ),
    ("lateness of the stream, p99", "ms", 1e3, "/streams", "lateness.p99", ("p99",)),
)
#: step in which a recording has the joints' angles [rad]: less is no distance
_STEP: Final = 2.0**-17
#: marks that are named in a picture, at most, and how near they may be, as parts of its length
_NAMED: Final = 16
_NEAR: Final = 0.025


class DrawnCurve(NamedTuple):
    """A curve: its name, its colour, whether it is of the second recording, and its points."""

    name: str
    colour: str
    second: bool
    times: NDArray[Any]
    values: NDArray[Any]


class DrawnPanel(NamedTuple):
    """Curves over the same axes."""

    title: str
    unit: str
    curves: list[DrawnCurve]


def panels(run: RecordedRun, other: RecordedRun | None = None) -> list[DrawnPanel]:
    """Return the panels of a recording, with another one over it; angles are in degrees.

    A panel in which all is zero is left out, unless there is no other.

    Raises:
        ParameterError: the recording contains nothing that can be drawn.
    """
    found = []
    for title, unit, scale, topic, field, names in _SHOWN:
        curves = []
        for number, each in enumerate((run, other)):
            if each is not None and topic in each.topics:
                times, values = _values(each, topic, field)
                curves += [
                    DrawnCurve(name, colour, number == 1, times, scale * values[:, index])
                    for index, (name, colour) in enumerate(zip(names, _COLOURS, strict=False))
                    if index < values.shape[1] and np.isfinite(values[:, index]).any()
                ]
        if curves:
            found.append(DrawnPanel(title, unit, curves))
    if not found:
        raise ParameterError("recording", str(run.path), "one with samples of the state")
    said = [panel for panel in found if any(map(_moves, panel.curves))]
    return said or found[:1]


def _moves(curve: DrawnCurve) -> bool:
    """Whether a curve is anything but zero."""
    return bool(np.nan_to_num(curve.values).any())


def _values(run: RecordedRun, topic: str, field: str) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return times and values of a field, with a column for each number."""
    arrays = run.arrays(topic)
    times = arrays["time"]
    nothing = np.empty((len(times), 0))
    if field == "error":
        if "/joint_setpoints" not in run.topics:
            return times, nothing
        wanted = run.arrays("/joint_setpoints")
        times, here, there = np.intersect1d(times, wanted["time"], return_indices=True)
        behind = arrays["position"][here] - wanted["position"][there]
        return times, np.where(np.abs(behind) < 1.5 * _STEP, 0.0, behind)
    if field not in arrays and f"{field}.x" in arrays:
        return times, np.column_stack([arrays[f"{field}.{axis}"] for axis in _XYZ]).astype(float)
    values = arrays.get(field, nothing)
    if values.dtype == object:
        return times, nothing
    return times, values.reshape(len(times), -1)


def marks(run: RecordedRun) -> list[tuple[float, str]]:
    """Return times and texts of the marks: motions, stops and events."""
    found = []
    for message in run.messages("/commands", "/events"):
        if message.topic == "/events":
            found.append((message.time, str(message.data["event"])))
        elif message.data["lane"] in ("motion", "blocking", "stop", "control"):
            failed = " failed" if message.data["error"] else ""
            found.append((message.time, f"{message.data['function']}{failed}"))
    return found


@of_any_maker
def draw_png(run: RecordedRun, path: Path, other: RecordedRun | None = None) -> None:
    """Draw a recording as a PNG. Needs matplotlib.

    Args:
        run: the recording.
        path: the file to write.
        other: another recording, drawn dashed over it.

    Raises:
        ParameterError: the recording contains nothing that can be drawn, or the file's name does
            not end as that of a picture.
        RecordingError: its contents are not as aioduco writes them.
        MissingExtra: matplotlib is not installed.
    """
    figure = drawn(run, other)
    kind = path.suffix.lower().removeprefix(".")
    if kind not in figure.canvas.get_supported_filetypes():
        raise ParameterError("path", str(path), "a name that ends in .png, or in .html for a page")
    with whole_file(path) as file:
        figure.savefig(file, format=kind, dpi=110)


def drawn(run: RecordedRun, other: RecordedRun | None = None) -> Figure:
    """Draw a recording as a figure of matplotlib; arguments and errors as for `draw_png`."""
    with MissingExtra.named("a picture", "plot"):
        from matplotlib.figure import Figure  # noqa: PLC0415 - only when a PNG is drawn
    shown = panels(run, other)
    figure = Figure(figsize=(11, 2.2 * len(shown) + 2.0), layout="constrained")
    # `parse_math`: "$" in a file's name is no formula
    figure.suptitle(_title(run, other), fontsize="medium", parse_math=False)
    draw_panels(figure, shown, marks(run), run.duration)
    return figure


def joint_panel(
    title: str, times: NDArray[Any], values: NDArray[Any], other: NDArray[Any] | None = None
) -> DrawnPanel:
    """A panel of angles of the joints [rad], shape (n, 6), with others dashed over them."""
    curves = [
        DrawnCurve(name, colour, number == 1, times, _DEGREE * each[:, index])
        for number, each in enumerate((values, other))
        if each is not None
        for index, (name, colour) in enumerate(zip(_JOINTS, _COLOURS, strict=True))
    ]
    return DrawnPanel(title, "°", curves)


def draw_panels(
    figure: FigureBase,
    shown: Sequence[DrawnPanel],
    happened: Sequence[tuple[float, str]],
    length: float,
    named: str = "commands and events: grey lines",
) -> None:
    """Draw panels below each other, and above them a strip that names the grey lines.

    Args:
        figure: where they are drawn.
        shown: the panels.
        happened: times and texts of the grey lines.
        length: the longest time [s].
        named: title of the strip.
    """
    heights = [*([0.55] if happened else []), *[1.0] * len(shown)]
    axes = figure.subplots(
        len(heights), 1, sharex=True, squeeze=False, height_ratios=heights
    )[:, 0]  # fmt: skip
    if happened:
        axes[0].set_title(named, fontsize="medium", loc="left")
        _draw_marks(axes[0], happened, length)
        axes = axes[1:]
    for axis, panel in zip(axes, shown, strict=True):
        of_first = {curve.name for curve in panel.curves if not curve.second}
        for curve in panel.curves:
            axis.plot(
                curve.times,
                curve.values,
                color=curve.colour,
                linewidth=1.0,
                linestyle="--" if curve.second else "-",
                label=None if curve.second and curve.name in of_first else curve.name,
            )
        for at, _ in happened:
            axis.axvline(at, color="0.8", linewidth=0.6, zorder=0)
        axis.set_title(panel.title, fontsize="medium", loc="left")
        axis.set_ylabel(panel.unit)
        axis.grid(visible=True, color="0.93")
        # Beside the title, where no curve is.
        axis.legend(
            fontsize="x-small", ncols=6, frameon=False,
            loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0,
        )  # fmt: skip
    axes[-1].set_xlabel("s")


def _draw_marks(axis: Any, happened: Sequence[tuple[float, str]], length: float) -> None:
    """Draw the strip above the panels that names the grey lines."""
    axis.set_yticks([])
    axis.spines[["top", "left", "right"]].set_visible(False)
    for at, _ in happened:
        axis.axvline(at, color="0.8", linewidth=0.6, zorder=0)
    for at, text in _named(happened, length):
        axis.annotate(
            text, (at, 0.04), xycoords=("data", "axes fraction"), rotation=28, fontsize="x-small",
            color="0.3", ha="left", va="bottom", parse_math=False, clip_on=True,
        )  # fmt: skip


def _named(happened: Sequence[tuple[float, str]], length: float) -> list[tuple[float, str]]:
    """Return the marks that are named: none that would lie over the one before."""
    named: list[tuple[float, str]] = []
    for at, text in happened:
        if not named or at - named[-1][0] > _NEAR * length:
            named.append((at, text if len(text) < 30 else f"{text[:28]}…"))
    return named[:_NAMED]


def _title(run: RecordedRun, other: RecordedRun | None) -> str:
    names = [
        f"{each.path.name} ({each.duration:.1f} s)" for each in (run, other) if each is not None
    ]
    # the name of a file may have bytes that are no text
    return " and, dashed, ".join(names).encode("utf-8", "replace").decode()


@of_any_maker
def draw_page(run: RecordedRun, path: Path, other: RecordedRun | None = None) -> None:
    """Write a recording as one HTML page with zoom; the page loads nothing from elsewhere.

    Args:
        run: the recording.
        path: the file to write.
        other: another recording, drawn dashed over it.

    Raises:
        ParameterError: the recording contains nothing that can be drawn.
    """
    content = {
        "panels": [
            {
                "title": panel.title,
                "unit": panel.unit,
                "curves": [
                    {
                        "name": curve.name,
                        "colour": curve.colour,
                        "second": curve.second,
                        **_points(curve.times, curve.values),
                    }
                    for curve in panel.curves
                ],
            }
            for panel in panels(run, other)
        ],
        "marks": [[round(at, 4), text] for at, text in marks(run)],
    }
    parts = {"@TITLE@": html.escape(_title(run, other)), "@DATA@": script_value(content)}
    # in one pass: a name may contain the placeholder of the other
    page = resources.files("aioduco.recording").joinpath("figures.html").read_text("utf-8")
    page = re.sub("|".join(parts), lambda found: parts[found[0]], page)
    write_whole(path, page, errors="replace")


def script_value(value: Any) -> str:
    """A value as JSON that a page's script may contain: no text in it is read as HTML.

    A script ends at "</script", and "<!--" with "<script" changes where it ends.
    """
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    return text.replace("&", r"\u0026").replace("<", r"\u003c").replace(">", r"\u003e")


def _points(times: NDArray[Any], values: NDArray[Any]) -> dict[str, Sequence[float | None]]:
    """Return the points of a curve, or the lowest and the highest of each stretch of them."""
    if len(times) > _POINTS:
        chosen: list[int] = []
        for part in np.array_split(np.arange(len(times)), _POINTS // 2):
            inside = values[part]
            if np.isfinite(inside).any():
                pair = {int(part[np.nanargmin(inside)]), int(part[np.nanargmax(inside)])}
                chosen += sorted(pair)
        times, values = times[chosen], values[chosen]
    return {
        "x": [round(float(time), 4) for time in times],
        "y": [float(f"{value:.7g}") if np.isfinite(value) else None for value in values],
    }
