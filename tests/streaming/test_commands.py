"""`aioduco doctor` and `aioduco plot`."""

from __future__ import annotations

from pathlib import Path

import pytest
from cli_runner import CliRunner

from aioduco.cli.app import app

from .conftest import Controller


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
