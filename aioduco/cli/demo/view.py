"""Progress of a running demonstration: a live panel on a terminal, plain lines elsewhere."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.console import Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from aioduco.models.enums import Outcome

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.cli.demo.report import MotionRecord, Report
    from aioduco.cli.safe_console import SafeConsole
    from aioduco.models.state import RobotStatus


_STYLES = {
    Outcome.FINISHED: "green",
    Outcome.BLENDED: "cyan",
    Outcome.STOPPED: "yellow",
}


class View:
    """Shows the progress of the stage while it runs; this one shows nothing."""

    def open(self, report: Report) -> None:
        """The demonstration begins."""

    def note(self, text: str) -> None:
        """Something happened that is no motion."""

    def began(self, motion: MotionRecord) -> None:
        """The controller accepted a motion."""

    def ended(self, motion: MotionRecord) -> None:
        """A motion has ended."""

    def sample(self, status: RobotStatus) -> None:
        """A sample of the arm arrived."""

    def close(self) -> None:
        """Nothing more will be shown."""


def view_for(console: SafeConsole) -> View:
    """A live view if the console is a terminal, else a plain one."""
    return LiveView(console) if console.is_terminal else PlainView(console)


def outcome_text(motion: MotionRecord) -> Text:
    """Outcome of a motion, or the state of its task while it runs."""
    if motion.outcome is None:
        return Text(motion.state, style="bold")
    style = _STYLES.get(motion.outcome, "red") if motion.ok else "bold red"
    text = Text(motion.outcome.value, style=style)
    if not motion.ok:
        text.append(f", expected {motion.expected.value}")
    return text


def milliradians(error: float | None) -> str:
    """A tracking error as the table shows it."""
    return "not seen" if error is None else f"{error * 1e3:.2f} mrad"


class PlainView(View):
    """One line per event: for logs, pipes and CI."""

    def __init__(self, console: SafeConsole) -> None:
        self._console = console

    def open(self, report: Report) -> None:
        """Print where it runs."""
        kind = "a simulated arm" if report.simulated else "the arm"
        self._line(f"demo on {kind} {report.model} at {report.controller}")

    def note(self, text: str) -> None:
        """Print it."""
        self._line(text)

    def ended(self, motion: MotionRecord) -> None:
        """Print one line."""
        self._line(
            f"{motion.name}: {outcome_text(motion).plain} after {motion.duration:.2f} s, "
            f"tracking error {milliradians(motion.tracking_error)}"
        )

    def _line(self, text: str) -> None:
        self._console.print(text, markup=False, highlight=False, soft_wrap=True)


class LiveView(View):
    """A panel that is redrawn in place: joints, pose of the tool, motions with their states."""

    def __init__(self, console: SafeConsole) -> None:
        self._motions: list[MotionRecord] = []
        self._notes: list[str] = []
        self._actual: Sequence[float] = (0.0,) * 6
        self._tcp: Sequence[float] = (0.0,) * 6
        self._state = ""
        self._title = ""
        self._live = Live(
            console=console, get_renderable=self._render, refresh_per_second=12, transient=True
        )

    def open(self, report: Report) -> None:
        """Start to draw on the terminal's lower lines."""
        self._title = f"{report.model} at {report.controller}"
        self._live.start()

    def note(self, text: str) -> None:
        """Show it among the last lines."""
        self._notes.append(text)

    def began(self, motion: MotionRecord) -> None:
        """Show it as running."""
        self._motions.append(motion)

    def sample(self, status: RobotStatus) -> None:
        """Keep it for the next drawing."""
        self._actual, self._tcp = tuple(status.joints), tuple(status.pose)
        self._state = status.state.name.lower()

    def close(self) -> None:
        """Release the terminal."""
        self._live.stop()

    def _render(self) -> Group:
        return Group(self._head(), self._joints(), self._tasks(), *self._last_notes())

    def _head(self) -> Text:
        return Text.assemble((self._title, "bold"), "  ", (self._state, "dim"))

    def _joints(self) -> Table:
        table = Table(box=None, show_header=False, padding=(0, 1))
        names = ("x", "y", "z", "rx", "ry", "rz")
        for joint, (angle, name, part) in enumerate(
            zip(self._actual, names, self._tcp, strict=True), start=1
        ):
            shown = f"{part * 1e3:9.1f} mm" if joint <= 3 else f"{math.degrees(part):9.1f} °"
            table.add_row(
                f"J{joint}",
                f"{math.degrees(angle):8.2f} °",
                ProgressBar(total=360.0, completed=(math.degrees(angle) + 180.0) % 360.0, width=24),
                name,
                shown,
            )
        return table

    def _tasks(self) -> Table:
        table = Table(box=None, show_header=False, padding=(0, 1))
        for motion in self._motions[-6:]:
            number = "" if motion.task_id is None else str(motion.task_id)
            table.add_row(number, motion.function, motion.name, outcome_text(motion))
        return table

    def _last_notes(self) -> list[Text]:
        return [Text(note, style="dim") for note in self._notes[-3:]]


def summary(report: Report) -> Table:
    """The table at the end: each motion with outcome, duration and greatest tracking error."""
    table = Table(
        title=f"aioduco demo: {report.model} at {report.controller}",
        caption="tracking error: the greatest difference of commanded and actual joints",
        box=SIMPLE_HEAD,
    )
    for heading in ("motion", "function", "outcome"):
        table.add_column(heading, no_wrap=True)
    for heading in ("duration", "tracking error"):
        table.add_column(heading, justify="right", no_wrap=True)
    for motion in report.motions:
        table.add_row(
            motion.name,
            motion.function,
            outcome_text(motion),
            f"{motion.duration:.2f} s",
            milliradians(motion.tracking_error),
        )
    return table
