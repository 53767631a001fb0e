"""Files that a failed test leaves: the recording, its events, last states, plots, and a picture."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from aioduco.errors import DucoError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from aioduco.recording.run import RecordedMessage
    from aioduco.sim import Simulator


#: name of the recording
RECORDING = "run.mcap"
#: channels of which each message is a line, and those whose last message is kept
_LINES = ("/commands", "/tasks", "/events", "/log")
_LAST = ("/joint_states", "/joint_setpoints", "/state", "/io", "/wrench")


def leave_artefacts(folder: Path, simulator: Simulator | None) -> list[str]:
    """Write files about an arm's run next to its recording.

    Args:
        folder: folder to write to; it also has the recording, if there is one.
        simulator: the simulated controller; None for a real arm.

    Returns:
        The names of the files, and messages about those that could not be written.
    """
    found = []
    if (folder / RECORDING).exists():
        found += [RECORDING, *_texts(folder)]
    else:
        found.append("no recording: pip install 'aioduco[record]' for one")
    if simulator is not None:
        found.append(_picture(folder / "arm.png", simulator))
    return found


def _texts(folder: Path) -> Iterator[str]:
    from aioduco.recording import read  # noqa: PLC0415 - an extra
    from aioduco.recording.figures import draw_page  # noqa: PLC0415 - with NumPy

    try:
        run = read(folder / RECORDING)
        lines = [_line(message) for message in run.messages(*_LINES)]
        (folder / "events.txt").write_text("\n".join([*lines, ""]), encoding="utf-8")
        yield "events.txt"
        last: dict[str, Any] = {message.topic: message.data for message in run.messages(*_LAST)}
        text = json.dumps(last, indent=2, ensure_ascii=False)
        (folder / "states.json").write_text(text + "\n", encoding="utf-8")
        yield "states.json"
        draw_page(run, folder / "run.html")
        yield "run.html"
    except DucoError as error:
        yield f"not all of the recording could be read: {error}"


def _line(message: RecordedMessage) -> str:
    data = message.data
    if message.topic == "/log":
        return f"{message.time:9.3f}  {data.get('name', '')}: {data.get('message', '')}"
    return f"{message.time:9.3f}  {message.topic[1:]} {json.dumps(data, ensure_ascii=False)}"


def _picture(path: Path, simulator: Simulator) -> str:
    try:
        from PIL import Image  # noqa: PLC0415 - an extra

        Image.fromarray(simulator.render()).save(path)
    except (ImportError, DucoError, OSError) as error:
        return f"no picture: {error}"
    return path.name
