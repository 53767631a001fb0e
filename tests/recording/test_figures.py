"""Recordings as pictures, and the commands that draw them."""

from __future__ import annotations

import html
import html.parser
import json
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest
from cli_runner import CliRunner
from for_each import for_each

import aioduco
import aioduco.sync
from aioduco.cli.app import app
from aioduco.cli.sessions import wait_until_ended
from aioduco.errors import ConnectionLost
from aioduco.recording import RecordedMessage, read
from aioduco.recording.channels import ANGLE
from aioduco.recording.container import DATA_END, MAGIC
from aioduco.recording.figures import draw_page, draw_png, drawn, marks, panels
from aioduco.sim import Simulator

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


@pytest.fixture(scope="module")
def sim() -> Iterator[Simulator]:
    with Simulator() as sim:
        yield sim


@pytest.fixture(scope="module")
def whole(sim: Simulator, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("figures") / "run.mcap"
    with aioduco.sync.connect(sim.host, sim.port, state_rate=100, clock=sim.clock) as robot:
        robot.bring_up()
        with robot.record(path):
            robot.motion.movej2([0.2, -0.2, 1.8, 0.1, -1.5, 0.2], v=1.0, a=2.0)
    return path


def content(page: Path) -> dict[str, list[dict[str, list[dict[str, list[float]]]]]]:
    found = re.search(r"const data = (.*);\n", page.read_text(encoding="utf-8"))
    assert found is not None
    values: dict[str, list[dict[str, list[dict[str, list[float]]]]]] = json.loads(found[1])
    return values


@pytest.mark.slow
def test_a_page_has_the_recording_s_numbers_and_asks_for_nothing(
    whole: Path, tmp_path: Path
) -> None:
    page = tmp_path / "run.html"
    run = read(whole)
    draw_page(run, page, run)
    text = page.read_text(encoding="utf-8")
    assert not re.search(r"https?:|src=|href=|@import|url\(", text)
    values = content(page)
    angles = values["panels"][0]
    joints = run.arrays("/joint_states")
    assert len(angles["curves"]) == 12  # of both recordings
    assert str(angles["unit"]) == "°"
    degrees = np.degrees(joints["position"][:, 0])
    assert angles["curves"][0]["y"] == pytest.approx(degrees, rel=1e-6, abs=1e-7)
    assert angles["curves"][0]["x"] == pytest.approx(joints["time"], abs=1e-4)
    assert "movej2" in [text for _, text in values["marks"]]


#: texts that a page must show as they are, in a file's name or in what was recorded
FOREIGN = (
    "</script><img src=x onerror=alert(1)>",
    "<!--<script>",
    "</title><script>alert(1)</script>",
    "@DATA@",
    "@TITLE@<b>",
    "&lt;b&gt;",
    "\u2028$x^$\\1",
)


class Elements(html.parser.HTMLParser):
    """What a parser of the standard library finds in a page."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.scripts: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        assert not [name for name, _ in attrs if name.startswith("on")]

    def handle_data(self, data: str) -> None:
        if self.tags[-1:] == ["script"]:
            self.scripts.append(data)


class Strange:
    """A recording with a foreign name and foreign commands and events."""

    duration = 1.0
    topics: ClassVar = {"/joint_states": 2}

    def __init__(self, text: str) -> None:
        self.path = Path(text.replace("/", "\u2215"))
        self._text = text

    def arrays(self, topic: str) -> dict[str, Any]:
        return {"time": np.array([0.0, 1.0]), "position": np.zeros((2, 6))}

    def messages(self, *topics: str) -> list[RecordedMessage]:
        command = {"lane": "motion", "error": "", "function": self._text}
        return [
            RecordedMessage("/commands", 0.0, 0, command),
            RecordedMessage("/events", 0.5, 0, {"event": self._text}),
        ]


class Plain(Strange):
    """A recording in which the arm turned, without a force."""

    topics: ClassVar = {"/joint_states": 2, "/wrench": 2}

    def __init__(self) -> None:
        super().__init__("movej2")

    def arrays(self, topic: str) -> dict[str, Any]:
        times = {"time": np.array([0.0, 1.0])}
        if topic == "/wrench":
            return times | {f"force.{axis}": np.zeros(2) for axis in "xyz"}
        return times | {"position": np.ones((2, 6)), "velocity": np.full((2, 6), np.nan)}


@for_each("lane, marked", [("motion", True), ("blocking", True), ("call", False)])
def test_motions_are_marked_whichever_call_makes_them(lane: str, marked: bool) -> None:
    command = {"lane": lane, "error": "", "function": "movej2"}
    run: Any = SimpleNamespace(messages=lambda *_: [RecordedMessage("/commands", 0.5, 0, command)])
    assert marks(run) == [(0.5, "movej2")] * marked


def test_a_panel_of_zeros_is_left_out_unless_there_is_no_other() -> None:
    assert [panel.title for panel in panels(Plain())] == ["joint angles"]  # type: ignore[arg-type]
    only: Any = Strange("no motion")
    assert [panel.title for panel in panels(only)] == ["joint angles"]


@pytest.mark.slow
def test_what_only_the_second_recording_has_is_named() -> None:
    pytest.importorskip("matplotlib")

    class Forced(Plain):
        def arrays(self, topic: str) -> dict[str, Any]:
            forces = {f"force.{axis}": np.ones(2) for axis in "xyz"}
            return super().arrays(topic) | (forces if topic == "/wrench" else {})

    class Unforced(Plain):
        topics: ClassVar = {"/joint_states": 2}

    *_, force = drawn(Unforced(), Forced()).axes  # type: ignore[arg-type]
    legend = force.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["x", "y", "z"]


@for_each("steps, shown", [(1, False), (3, True)])
def test_a_distance_of_one_step_of_a_recording_is_none(steps: int, shown: bool) -> None:
    class Followed(Plain):
        topics: ClassVar = {"/joint_states": 2, "/joint_setpoints": 2}

        def arrays(self, topic: str) -> dict[str, Any]:
            behind = steps / ANGLE if topic == "/joint_states" else 0.0
            return {"time": np.array([0.0, 1.0]), "position": np.full((2, 6), 1.0 - behind)}

    titles = [panel.title for panel in panels(Followed())]  # type: ignore[arg-type]
    assert ("behind the set-points" in titles) is shown


def test_joints_are_compared_with_the_set_points_of_the_same_time() -> None:
    """They were with those of the same number, also if a channel had begun later."""

    class Later(Plain):
        topics: ClassVar = {"/joint_states": 3, "/joint_setpoints": 2}

        def arrays(self, topic: str) -> dict[str, Any]:
            times = np.array([0.0, 1.0, 2.0])[topic == "/joint_setpoints" :]
            return {"time": times, "position": np.repeat(times[:, None], 6, axis=1)}

    assert [panel.title for panel in panels(Later())] == ["joint angles"]  # type: ignore[arg-type]


@pytest.mark.slow
def test_no_legend_and_no_name_of_a_mark_lies_over_a_curve() -> None:
    pytest.importorskip("matplotlib")
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415

    figure = drawn(Plain())  # type: ignore[arg-type]
    FigureCanvasAgg(figure).draw()  # type: ignore[no-untyped-call]
    strip, *rest = figure.axes
    assert [text.get_text() for text in strip.texts] == ["movej2", "movej2"]
    assert not strip.lines or all(len(set(line.get_xdata())) == 1 for line in strip.lines)  # type: ignore[arg-type]
    for axes in rest:
        legend = axes.get_legend()
        assert legend is not None
        assert legend.get_window_extent().y0 > axes.get_window_extent().y1 - 3  # pixels
        assert not axes.texts


@for_each("text", FOREIGN)
def test_no_text_of_a_recording_is_read_as_html(text: str, tmp_path: Path) -> None:
    page = tmp_path / "run.html"
    run: Any = Strange(text)
    draw_page(run, page)
    written = page.read_text(encoding="utf-8")
    found = Elements()
    found.feed(written)
    plain = Elements()
    other: Any = Strange("a plain name")
    draw_page(other, page)
    plain.feed(page.read_text(encoding="utf-8"))
    assert found.tags == plain.tags, "no element comes from the recording"
    (script,) = [each for each in found.scripts if "const data" in each]
    values = json.loads(re.search(r"const data = (.*);\n", script)[1])  # type: ignore[index]
    assert values["marks"] == [[0.0, text], [0.5, text]]
    for sign in "<>&":
        assert sign not in re.search(r"const data = (.*);\n", script)[1]  # type: ignore[index]
    assert f"<h1>{html.escape(run.path.name)} (1.0 s)</h1>" in written


@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")
@pytest.mark.slow
def test_a_browser_runs_nothing_of_a_recording(tmp_path: Path) -> None:
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        for text in FOREIGN:
            page = tmp_path / "run.html"
            run: Any = Strange(text)
            draw_page(run, page)
            opened = chromium.new_page()
            opened.on("dialog", lambda _: pytest.fail("a text of the recording ran"))
            opened.goto(page.as_uri())
            assert opened.locator("canvas").count() == 1, "the page draws"
            assert opened.locator("img, b").count() == 0
            opened.close()
        chromium.close()


@pytest.mark.slow
@pytest.mark.parametrize(("name", "shown"), [("run$x^$", "run$x^$"), ("run\udcff", "run?")])
def test_a_name_of_a_file_is_no_formula_and_may_be_no_text(
    whole: Path, tmp_path: Path, name: str, shown: str
) -> None:
    pytest.importorskip("matplotlib")
    strange = tmp_path / f"{name}.mcap"
    shutil.copy(whole, strange)
    draw_png(read(strange), tmp_path / "run.png")
    assert (tmp_path / "run.png").stat().st_size > 1000
    draw_page(read(strange), tmp_path / "run.html")
    assert f"{shown}.mcap" in (tmp_path / "run.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_of_many_points_the_lowest_and_the_highest_are_drawn(whole: Path, tmp_path: Path) -> None:
    from aioduco.recording import figures  # noqa: PLC0415

    times = np.linspace(0.0, 100.0, 50_001)
    values = np.zeros(50_001)
    values[[123, 40_000]] = 7.0, -3.0
    found = figures._points(times, values)
    assert len(found["x"]) <= 4_000
    assert (max(found["y"]), min(found["y"])) == (7.0, -3.0)  # type: ignore[type-var]  # no None


@pytest.mark.slow
def test_commands_draw_a_recording(whole: Path, tmp_path: Path) -> None:
    runner = CliRunner()
    for name in ("a.png", "a.html"):
        done = runner.invoke(app, ["plot", str(whole), str(tmp_path / name), "--over", str(whole)])
        assert done.exit_code == 0, done.output
        assert (tmp_path / name).stat().st_size > 10_000
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    cut = tmp_path / "cut.mcap"
    data = whole.read_bytes()
    at = len(MAGIC)
    while data[at] != DATA_END:
        at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")
    cut.write_bytes(data[: at + 1])
    done = runner.invoke(app, ["plot", str(cut)])
    assert "was cut off" in done.output
    for name in ("picture", "picture.mcap"):  # matplotlib would write picture.png
        done = runner.invoke(app, ["plot", str(whole), str(tmp_path / name)])
        assert done.exit_code == 1
        assert "a name that ends in .png" in done.output
    assert not [*tmp_path.glob("picture*")]
    (tmp_path / "no.mcap").write_text("nothing")
    done = runner.invoke(app, ["plot", str(tmp_path / "no.mcap")])
    assert done.exit_code == 1
    assert "is no recording" in done.output


def test_an_empty_recording_is_not_drawn(tmp_path: Path) -> None:
    head = tmp_path / "head.mcap"
    head.write_bytes(MAGIC)
    with pytest.raises(aioduco.ParameterError, match="samples of the state"):
        panels(read(head))


@pytest.mark.slow
def test_the_command_records_until_it_is_told_to_end(sim: Simulator, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    done = CliRunner().invoke(
        app, ["record", sim.host, "--port", str(sim.port), "-o", str(path), "--seconds", "0.5"]
    )
    assert done.exit_code == 0, done.output
    assert "entries" in done.output
    assert read(path).complete
    command = [sys.executable, "-m", "aioduco.cli", "record", sim.host, "-o", str(path)]
    with subprocess.Popen(
        [*command, "--port", str(sim.port)], stdout=subprocess.PIPE, text=True
    ) as program:
        assert program.stdout is not None
        assert "run-1.mcap; Ctrl-C" in program.stdout.readline()
        program.send_signal(signal.SIGINT)
        assert "entries" in program.stdout.read()
        assert program.wait(60) == 0
    assert read(tmp_path / "run-1.mcap").complete
    nobody = CliRunner().invoke(app, ["record", "127.0.0.1", "--port", "1", "-o", str(path)])
    assert nobody.exit_code == 1
    assert not (tmp_path / "run-2.mcap").exists()


@pytest.mark.parametrize("back", [False, True])
def test_that_the_controller_does_not_answer_is_said(
    back: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("aioduco.cli.sessions._SILENT", 0.0)
    feed = SimpleNamespace(error=None)
    errors = [None, ConnectionLost("it broke"), ConnectionLost("it broke"), None][
        : 4 if back else 3
    ]

    def sleep(_: float) -> None:
        feed.error = errors.pop(0)

    robot: Any = SimpleNamespace(feed=feed, sleep=sleep)
    assert wait_until_ended("recording", robot, lambda: bool(errors), None) is back
    lines = ["the controller does not answer: it broke", "it answers again"]
    assert capsys.readouterr().err.splitlines() == lines[: 2 if back else 1]
