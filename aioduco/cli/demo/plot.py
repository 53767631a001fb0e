"""The plot of a demonstration: the path in space, commanded against actual joints, the difference.

It draws into a figure of its own, without pyplot: nothing is global, and no window is opened.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from aioduco.cli.demo.script import PART
from aioduco.models.whole_files import whole_file

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from numpy.typing import NDArray

    from aioduco.cli.demo.report import Report

    #: positions of the joints' origins in the base frame [m], shape (n, 3), from joints [rad]
    Skeleton = Callable[[NDArray[np.float64]], NDArray[np.float64]]


_COLOURS = ("#1f77b4", "#d95f02", "#2ca02c", "#c0392b", "#7b5ea7", "#8c6d31")
_GHOSTS = 7  # number of arms that are drawn along the way


def save(report: Report, path: Path, skeleton: Skeleton | None = None) -> None:
    """Draw a report and write it as a PNG.

    Args:
        report: the report to draw; it must have samples.
        path: file to write.
        skeleton: positions of the arm's joints, to draw the arm itself; None draws only the path.
    """
    figure = draw(report, skeleton)
    with whole_file(path) as file:
        figure.savefig(file, format="png", pil_kwargs={"optimize": True})


def draw(report: Report, skeleton: Skeleton | None = None) -> Figure:
    """Draw a report as a figure."""
    figure = Figure(figsize=(11, 5.4), dpi=90, layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(0.8, 1.2), height_ratios=(2.2, 1.0), wspace=0.1)
    space = figure.add_subplot(grid[:, 0], projection="3d")
    joints = figure.add_subplot(grid[0, 1])
    errors = figure.add_subplot(grid[1, 1], sharex=joints)
    _draw_space(space, report, skeleton)
    _draw_joints(joints, report)
    _draw_errors(errors, report)
    where = "simulated" if report.simulated else report.controller
    figure.suptitle(
        f"aioduco demo: {report.model.upper().replace('_', '-')} ({where})", fontsize=11
    )
    return figure


def _draw_space(axes: Any, report: Report, skeleton: Skeleton | None) -> None:
    tcp = np.array([sample.pose[:3] for sample in report.samples])
    points = [tcp]
    if skeleton is not None:
        actual = np.array([sample.joints for sample in report.samples])
        for row, weight in zip(
            np.linspace(0, len(actual) - 1, _GHOSTS).astype(int),
            np.linspace(0.15, 1.0, _GHOSTS),
            strict=True,
        ):
            arm = skeleton(actual[row])
            points.append(arm)
            axes.plot(*arm.T, color=(0.2, 0.25, 0.3, weight), lw=3, marker="o", ms=4)
    axes.plot(*tcp.T, color=_COLOURS[1], lw=1.5)
    if report.part:
        _draw_part(axes, np.asarray(report.part))
    every = np.concatenate([*points, np.zeros((1, 3))])
    low, high = every.min(axis=0), every.max(axis=0)
    middle, half = (low + high) / 2, (high - low).max() / 2
    for name, centre in zip("xyz", middle, strict=True):
        getattr(axes, f"set_{name}lim")(centre - half, centre + half)
        getattr(axes, f"set_{name}label")(f"{name} [m]", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.set_box_aspect((1, 1, 1))
    axes.view_init(elev=20, azim=-60)


def _draw_part(axes: Any, places: NDArray[np.float64]) -> None:
    """Draw the box where it lay, was carried and lies at the end, with the way between."""
    axes.plot(*places.T, color=_COLOURS[3], lw=1.0, ls=":")
    for place, weight in zip(places, np.linspace(0.35, 1.0, len(places)), strict=True):
        low = place - 0.5 * PART
        axes.bar3d(*low, PART, PART, PART, color=_COLOURS[3], alpha=weight, shade=True)
    for place, text in zip(places, ("picked up", "carried", "put down"), strict=False):
        axes.text(*(place - (0.0, 0.0, 1.6 * PART)), text, fontsize=7, color=_COLOURS[3])


def _draw_joints(axes: Any, report: Report) -> None:
    at = report.times()
    expected = np.rad2deg([sample.expected_joints for sample in report.samples])
    actual = np.rad2deg([sample.joints for sample in report.samples])
    for joint, colour in enumerate(_COLOURS):
        axes.plot(at, actual[:, joint], color=colour, lw=1.8, label=f"joint {joint + 1}")
        axes.plot(at, expected[:, joint], color="black", lw=0.8, ls=(0, (3, 3)))
    axes.plot([], [], color="black", lw=0.8, ls=(0, (3, 3)), label="commanded")
    _shade(axes, report)
    axes.set_ylabel("joints [°]", fontsize=8)
    axes.tick_params(labelsize=7, labelbottom=False)
    axes.legend(fontsize=7, ncols=7, loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)


def _draw_errors(axes: Any, report: Report) -> None:
    at = report.times()
    errors = np.rad2deg(report.errors())
    for joint, colour in enumerate(_COLOURS):
        axes.plot(at, errors[:, joint], color=colour, lw=0.9)
    _shade(axes, report)
    axes.set_ylabel("behind [°]", fontsize=8)
    axes.set_xlabel("time [s]", fontsize=8)
    axes.tick_params(labelsize=7)


def _shade(axes: Any, report: Report) -> None:
    """Mark each motion, in red if it did not end as expected."""
    axes.margins(x=0.01)
    axes.grid(visible=True, alpha=0.25)
    for number, motion in enumerate(report.motions):
        if not motion.ok:
            axes.axvspan(motion.begin, motion.end, color="#c0392b", alpha=0.15, lw=0)
        elif number % 2 == 0:
            axes.axvspan(motion.begin, motion.end, color="black", alpha=0.05, lw=0)
