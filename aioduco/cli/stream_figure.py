"""The histograms of a stream as a picture, for `aioduco plot`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aioduco.errors import MissingExtra
from aioduco.models.whole_files import whole_file
from aioduco.streaming.report import MEANINGS, StreamStatistics
from aioduco.streaming.shared.block import HISTOGRAMS

if TYPE_CHECKING:
    from collections.abc import Sequence


_PERCENTILES = (("p50", "p50"), ("p99", "p99"), ("p99.9", "p999"), ("max", "max"))


def plot(statistics: StreamStatistics | dict[str, Any], path: str | Path) -> None:
    """Draw the histograms of a stream as a PNG, on logarithmic scales. Needs matplotlib.

    Args:
        statistics: the statistics, or the parsed JSON that `StreamStatistics.save` wrote.
        path: file for the figure.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    with MissingExtra.named("a plot", "plot"):
        from matplotlib.figure import Figure  # noqa: PLC0415 - needed only to plot

    found = statistics if isinstance(statistics, dict) else statistics.as_dict()
    shown = [name for name in HISTOGRAMS if found["buckets"].get(name)]
    figure = Figure(figsize=(9, 2.0 * max(1, len(shown)) + 0.6), layout="constrained")
    ended = f" ({found['reason']})" if found["reason"] != "NONE" else ""
    figure.suptitle(
        f"{found['state']}{ended}: {found['ticks']} ticks, {found['sent']} set-points sent, "
        f"{found['missed']} ticks missed, {found['starved']} starved",
        fontsize="medium",
        parse_math=False,
    )
    for index, name in enumerate(shown):
        axes = figure.add_subplot(len(shown), 1, index + 1)
        depth = name == "depth"
        _draw(axes, found["buckets"][name], scale=1.0 if depth else 1e-3, log=not depth)
        unit = "points" if depth else "µs"
        figures, scale = found["queue" if depth else name], 1.0 if depth else 1e6
        percentiles = [(label, figures[key] * scale) for label, key in _PERCENTILES]
        for _, value in percentiles:
            axes.axvline(value, linewidth=0.8, linestyle="--", color="black")
        said = " · ".join(f"{label} {value:,.0f}" for label, value in percentiles)
        title = f"{name.replace('_', ' ')}: {MEANINGS[name]}"
        axes.set_title(title, fontsize="medium", loc="left")
        axes.set_title(f"dashed: {said} {unit}", fontsize="small", loc="right")
        axes.set_xlabel(unit)
        axes.set_ylabel("times")
    with whole_file(path) as file:
        figure.savefig(file, format=Path(path).suffix.lower().removeprefix(".") or "png", dpi=120)


def _draw(axes: Any, buckets: Sequence[Sequence[int]], *, scale: float, log: bool) -> None:
    """Draw one histogram; buckets are merged so that the bars are visible."""
    bars: dict[int, tuple[float, float, int]] = {}
    for low, high, count in buckets:
        # Eight bars per octave of times; there are few depths, so each has a bar.
        place = round(8 * math.log2(max(low, 1))) if log else low
        before = bars.get(place, (low * scale, high * scale, 0))
        bars[place] = (before[0], high * scale, before[2] + count)
    lows, highs, counts = zip(*bars.values(), strict=True)
    widths = [high - low for low, high in zip(lows, highs, strict=True)]
    axes.bar(lows, counts, width=widths, align="edge")
    axes.set_yscale("log")
    axes.set_ylim(bottom=0.7)
    if log:
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:,.0f}")
