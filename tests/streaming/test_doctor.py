"""The examination of machine and network: `aioduco doctor`, and `aioduco plot`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from cli_runner import CliRunner
from for_each import for_each

from aioduco.cli.app import app
from aioduco.cli.stream_figure import plot
from aioduco.cli.stream_rate import Examination, holdable
from aioduco.streaming.report import StreamStatistics
from aioduco.streaming.shared.histogram import Percentiles
from aioduco.streaming.shared.words import Reason, StreamState

from .conftest import Controller


def figures(late: float, work: float) -> StreamStatistics:
    zeros: dict[str, Any] = dict.fromkeys(StreamStatistics._fields, 0)
    nothing = dict.fromkeys(("interval", "age", "queue"), Percentiles(0, 0.0, 0.0, 0.0, 0.0, 0.0))
    working = Percentiles(1000, work, work, work, work, work)
    return StreamStatistics(**zeros | nothing)._replace(
        state=StreamState.ENDED,
        reason=Reason.CLOSED,
        ticks=1000,
        unmet=(),
        lateness=Percentiles(1000, late, late, late, late, late),
        round_trip=working,
        work=working,
        buckets={"lateness": [(1000, 2000, 3)]},
    )


def better_table() -> Any:
    found = figures(1e-4, 2e-4)
    return Examination(found, found, 4, "performance", 1000.0, 1000.0).__rich__()


@for_each(
    "late, work, rate",
    [(1e-4, 2e-4, 1000.0), (5e-4, 6e-4, 500.0), (3e-3, 4e-3, 125.0), (0.1, 0.0, 0.0)],
)
def test_a_rate_is_held_if_lateness_and_work_fit(late: float, work: float, rate: float) -> None:
    assert holdable(figures(late, work)) == rate


def test_advice_says_what_would_help() -> None:
    poor = Examination(figures(0.01, 0.01), None, 1, "powersave", 30.0, 0.0)
    text = " ".join(poor.advice)
    for word in ("one processor", "powersave", "held the worker up for 10.0 ms", "SCHED_FIFO"):
        assert word in text
    assert "1000 Hz can be held: depth=40 bridges" in text
    better = Examination(figures(4e-4, 6e-4), figures(1e-4, 2e-4), 4, "performance", 500.0, 1000.0)
    (advice,) = better.advice
    assert "under SCHED_FIFO 1000 Hz can be held instead of 500 Hz" in advice
    assert Examination(figures(0, 0), figures(0, 0), 4, "", 1000.0, 1000.0).advice == ()


def test_uneven_answers_are_the_network_only_where_the_machine_is_not_to_blame() -> None:
    uneven = Percentiles(1000, 1e-3, 1e-4, 5e-3, 8e-3, 0.01)
    quiet = figures(1e-4, 0.0)._replace(round_trip=uneven)
    assert "cable" in " ".join(Examination(quiet, quiet, 4, "", 125.0, 125.0).advice)
    busy = figures(8e-3, 0.0)._replace(round_trip=uneven)
    assert "cable" not in " ".join(Examination(busy, busy, 4, "", 60.0, 60.0).advice)


@for_each("late, depth", [(1e-4, 20), (0.015, 60), (3.0, 1000)])
def test_a_depth_is_given_that_bridges_what_was_seen(late: float, depth: int) -> None:
    found = figures(late, late)
    assert Examination(found, found, 4, "", 0.0, 0.0).depth == depth


@pytest.mark.slow
def test_figures_as_text_table_json_and_picture(tmp_path: Path) -> None:
    shown = figures(1e-4, 2e-4)
    assert "late p50 100 µs" in repr(shown)
    table = shown.__rich__()
    assert [column.header for column in table.columns][1:5] == ["p50", "p99", "p99.9", "max"]
    assert table.row_count == 3
    assert better_table().row_count == 4
    shown.save(tmp_path / "figures.json")
    assert '"reason": "CLOSED"' in (tmp_path / "figures.json").read_text()
    plot(shown, tmp_path / "figure.png")
    assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_doctor_measures_and_plot_draws_it(controller: Controller, tmp_path: Path) -> None:
    figures = tmp_path / "figures.json"
    port = str(controller.server.port)
    shown = CliRunner().invoke(
        app, ["doctor", "127.0.0.1", "--port", port, "--seconds", "0.2", "--json", str(figures)]
    )
    assert shown.exit_code == 0, shown.output
    assert "can be held" in shown.output
    assert set(controller.names()) == {"get_robot_state"}
    drawn = CliRunner().invoke(app, ["plot", str(figures)])
    assert drawn.exit_code == 0, drawn.output
    assert (tmp_path / "figures.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_doctor_without_a_controller_says_so() -> None:
    shown = CliRunner().invoke(app, ["doctor", "127.0.0.1", "--port", "1", "--seconds", "0.2"])
    assert shown.exit_code == 1
    assert "cannot connect" in shown.output


@pytest.mark.slow
def test_plot_says_what_it_cannot_draw(tmp_path: Path) -> None:
    (tmp_path / "figures.json").write_text("{}")
    shown = CliRunner().invoke(app, ["plot", str(tmp_path / "figures.json")])
    assert shown.exit_code == 1
    assert "cannot be drawn: it is neither a recording" in shown.output
    (tmp_path / "figures.json").write_text("{")
    shown = CliRunner().invoke(app, ["plot", str(tmp_path / "figures.json")])
    assert shown.exit_code == 1
    assert shown.output.endswith(
        "cannot be drawn: it is neither a recording, .mcap, nor a file of StreamStatistics.save\n"
    )
    page = CliRunner().invoke(app, ["plot", str(tmp_path / "figures.json"), "figures.html"])
    assert page.exit_code == 2
