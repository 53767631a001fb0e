"""The statistics of a stream: one frozen value, as text, as a table, as JSON."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, NamedTuple

from aioduco.models.whole_files import write_whole
from aioduco.streaming.shared.block import HISTOGRAMS, Block
from aioduco.streaming.shared.histogram import Percentiles
from aioduco.streaming.shared.words import Reason, StatusWord, StreamState, Unmet

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from rich.table import Table


#: what each histogram measures
MEANINGS = {
    "lateness": "how late a tick began",
    "interval": "time between two ticks",
    "round_trip": "set-point sent to answer received",
    "work": "all work of a tick",
    "age": "set-point sent by the program to taken by the worker",
    "depth": "points in the controller's queue",
}


class StreamStatistics(NamedTuple):
    """Statistics of one stream at one moment.

    Attributes:
        state: state of the stream.
        reason: why it ended, or is ending.
        ticks: ticks of the worker.
        sent: set-points sent to the controller.
        missed: ticks that were skipped, because the worker or the controller was not ready in time.
        starved: ticks in which the arm moved, a set-point was due and none had arrived; for the
            track pool, polls at which it was empty before the program had closed the stream.
        limited: ticks in which the limits kept the arm from its target.
        overwritten: set-points that newer ones replaced before the worker took them.
        drained: how often the controller's queue was found empty.
        queued: set-points of the program that wait in the worker's ring.
        depth: points in the controller's queue at the last poll.
        memory: peak size of the worker's process [bytes]; 0 before its end, and for a thread.
        chunks: chunks of actions that the worker has taken.
        chunks_late: of these, chunks some of whose actions were already past.
        chunks_dropped: of these, chunks all of whose actions were already past.
        actions_late: actions that arrived after their time.
        exhausted: how often the actions ran out before a new chunk arrived.
        unmet: requests that the system did not allow.
        priority: the worker's real-time priority; 0: none.
        lateness: how late ticks began, skipped ticks included [s].
        interval: time between two ticks [s].
        round_trip: time from sending a set-point to its answer [s].
        work: time of all work in a tick [s].
        age: time from sending a set-point in the program until the worker takes it [s].
        queue: points in the controller's queue at each poll.
        buckets: the histograms behind these percentiles: by name, a list of lowest value, lowest
            value of the next bucket, and count; in nanoseconds or points.
    """

    state: StreamState
    reason: Reason
    ticks: int
    sent: int
    missed: int
    starved: int
    limited: int
    overwritten: int
    drained: int
    queued: int
    depth: int
    memory: int
    chunks: int
    chunks_late: int
    chunks_dropped: int
    actions_late: int
    exhausted: int
    unmet: tuple[str, ...]
    priority: int
    lateness: Percentiles
    interval: Percentiles
    round_trip: Percentiles
    work: Percentiles
    age: Percentiles
    queue: Percentiles
    buckets: dict[str, list[tuple[int, int, int]]]

    @classmethod
    def of(
        cls, block: Block, state: StreamState, reason: Reason, *, in_process: bool
    ) -> StreamStatistics:
        """Read the statistics from the memory that the worker writes.

        Args:
            block: that memory.
            state: state of the stream.
            reason: why it ended, or is ending.
            in_process: whether the worker is a separate process.
        """
        words = block.status
        # Each count has the name of its word, and each measurement that of its histogram.
        found: dict[str, Any] = {
            name: words[StatusWord[name.upper()]]
            for name in cls._fields
            if name.upper() in StatusWord.__members__
        }
        for name in HISTOGRAMS:
            scale = 1.0 if name == "depth" else 1e-9
            figures = block.histograms[name].snapshot(scale)
            found["queue" if name == "depth" else name] = figures
        flags = Unmet(words[StatusWord.UNMET])
        found |= {
            "state": state,
            "reason": reason,
            "queued": block.ring.level,
            "memory": words[StatusWord.MEMORY] * 1024 if in_process else 0,
            "unmet": tuple(str(flag.name).lower() for flag in flags),
            "buckets": {name: block.histograms[name].buckets() for name in HISTOGRAMS},
        }
        return cls(**found)

    def __repr__(self) -> str:
        late = self.lateness
        return (
            f"<StreamStatistics {self.state.name}"
            f"{f' ({self.reason.name})' if self.reason else ''}: {self.sent} sent, "
            f"{self.missed} missed, {self.starved} starved, {self._chunks()}"
            f"late p50 {late.p50 * 1e6:.0f} µs, "
            f"p99 {late.p99 * 1e6:.0f} µs, max {late.max * 1e6:.0f} µs>"
        )

    def _chunks(self) -> str:
        if not self.chunks:
            return ""
        return f"{self.chunks} chunks ({self.chunks_late} late, {self.chunks_dropped} dropped), "

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values, for JSON."""
        found = self._asdict() | {"state": self.state.name, "reason": self.reason.name}
        plain = {n: each._asdict() for n, each in found.items() if isinstance(each, Percentiles)}
        return found | plain

    def save(self, path: str | Path) -> None:
        """Write the statistics as JSON, from which `aioduco plot` draws a figure."""
        write_whole(path, json.dumps(self.as_dict(), indent=1) + "\n")

    def __rich__(self) -> Table:
        """The table that `rich` prints."""
        counts = (
            f"{self.sent} sent · {self.missed} missed · {self.starved} starved · "
            f"{self.limited} limited · {self.overwritten} overwritten · {self.drained} drained"
        )
        if self.chunks:
            counts += (
                f" · {self.chunks} chunks, {self.chunks_late} late, "
                f"{self.chunks_dropped} dropped, {self.exhausted} times none left"
            )
        if self.priority:
            counts += f" · SCHED_FIFO {self.priority}"
        title = f"{self.state.name}{f' ({self.reason.name})' if self.reason else ''} · {counts}"
        times = [
            (f"{name.replace('_', ' ')}: {meaning}", getattr(self, name))
            for name, meaning in MEANINGS.items()
            if name != "depth"
        ]
        table = times_table(title, [(name, found) for name, found in times if found.samples])
        if self.queue.samples:
            levels = (self.queue.p50, self.queue.p99, self.queue.p999, self.queue.max)
            table.add_row(f"depth: {MEANINGS['depth']}", *(f"{level:.0f}" for level in levels))
        return table


def times_table(title: str, rows: Sequence[tuple[str, Percentiles]]) -> Table:
    """A table of percentiles of times, for `rich`."""
    from rich.table import Table  # noqa: PLC0415 - needed only to print

    table = Table(title=title, title_justify="left")
    for column in ("", "p50", "p99", "p99.9", "max"):
        table.add_column(column, justify="right" if column else "left")
    for name, found in rows:
        values = (found.p50, found.p99, found.p999, found.max)
        table.add_row(name, *(f"{value * 1e6:,.0f} µs" for value in values))
    return table
