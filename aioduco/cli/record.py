"""`aioduco record`: record what an arm does to a file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aioduco.cli import extras
from aioduco.cli.addresses import CellFile, Host, Port, robot_at
from aioduco.cli.exit_codes import fail
from aioduco.cli.options import Duration, require_writable
from aioduco.cli.output import say
from aioduco.cli.sessions import observing_session, wait_until_ended

#: entries up to which a recording is read back at its end: some 3 s
_READ_BACK = 100_000


def record(
    host: Host = None,
    output: Annotated[Path, typer.Option("--output", "-o")] = Path("run.mcap"),
    port: Port = None,
    cell: CellFile = None,
    rate: Annotated[float, typer.Option(min=1, max=1000)] = 125.0,
    seconds: Duration = None,
    forces: bool = True,
) -> None:
    """Record what an arm does, until Ctrl-C, whichever program moves it. This moves nothing.

    It only reads from the controller. It sends no heartbeat, and ending it stops nothing.

    aioduco record 192.168.1.10 -o run.mcap

    Exit codes: 0 the file is complete; 1 nothing was recorded, it ended early, or the controller
    did not answer at the end; 2 wrong options; 143 SIGTERM: the file is complete.

    Args:
        output: File to write. An existing file is kept.
        rate: Samples per second.
        forces: Also record forces and external torques.
    """
    require_writable("--output", output)
    extras.need("record")
    address = robot_at(host, port, cell)
    with observing_session(address, state_rate=rate) as robot:
        recording = robot.record(output, forces=forces)
        with recording:
            what = f"recording to {recording.path}"
            answered = wait_until_ended(what, robot, lambda: recording.running, seconds)
    figures = recording.statistics()
    dropped = f", {figures.dropped} dropped" if figures.dropped else ""
    say(f"{recording.path}: {figures.written} entries{dropped}, {figures.size} bytes")
    if recording.error is not None:
        fail(f"it ended early: {recording.error}")
    if figures.longest_gap:
        say(f"longest time without a sample of the moving arm: {figures.longest_gap:.3f} s")
        say(playable(recording.path, figures.written))
    if not answered:
        fail("the controller did not answer at the end: nothing of that time was recorded")


def playable(path: Path, entries: int) -> str:
    """Whether `aioduco play` takes a recording, and what it bridges in it."""
    if entries > _READ_BACK:
        return f"it is long: aioduco play {path} --check says whether it can be played"
    from aioduco.errors import DucoError  # noqa: PLC0415
    from aioduco.kinematics.catalogue import model_named  # noqa: PLC0415
    from aioduco.recording import read  # noqa: PLC0415
    from aioduco.recording.playback import RecordedPath, check_path  # noqa: PLC0415
    from aioduco.recording.playback.sample_times import gaps_in_words  # noqa: PLC0415

    try:
        motion = RecordedPath.of(read(path))
    except DucoError as exc:
        return f"it cannot be played: {exc}"
    model = model_named(motion.arm)
    found = () if model is None else check_path(motion, model)
    if found:
        return f"it cannot be played: {'; '.join(str(each) for each in found)}"
    bridged = f"; bridged: {gaps_in_words(motion.gaps)}" if motion.gaps else ""
    return f"it can be played: {motion.duration:.2f} s of motion{bridged}"
