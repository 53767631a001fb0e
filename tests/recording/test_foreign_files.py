"""Recordings of other makers: typed errors, and memory bounded by the file's size."""

from __future__ import annotations

import contextlib
import json
import math
import os
import stat
import struct
import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from for_each import for_each

from aioduco.errors import DucoError, ParameterError, RecordingError
from aioduco.recording import read
from aioduco.recording.container import MAGIC
from aioduco.recording.figures import draw_page
from aioduco.recording.playback import RecordedPath
from aioduco.sim.calibration.evidence import read_evidence
from aioduco.sim.twin import judge, learn
from recording.mcap_records import HEAD, channel, message, record, text

zstandard = pytest.importorskip("zstandard")

END = struct.pack("<BQI", 0x0F, 4, 0) + MAGIC


def chunk(plain: bytes, packed: bytes | None = None, size: int | None = None) -> bytes:
    packed = zstandard.ZstdCompressor().compress(plain) if packed is None else packed
    size = len(plain) if size is None else size
    head = struct.pack("<QQQI", 0, 0, size, 0) + text("zstd")
    return record(6, head + struct.pack("<Q", len(packed)) + packed)


def claims(size: int) -> bytes:
    """A frame whose header says that it unpacks to so much."""
    return b"\x28\xb5\x2f\xfd\xe0" + struct.pack("<Q", size) + b"\x01\x00\x00"


def of_json(topic: str, *values: bytes, at: int = 10**18) -> bytes:
    return chunk(channel(1, topic) + b"".join(message(1, value, at) for value in values))


def deep(opened: bytes, closed: bytes, depth: int) -> bytes:
    return b'{"a":' + opened * depth + closed * depth + b"}"


STRANGE: dict[str, Callable[[], bytes]] = {
    "claims 1 TiB": lambda: chunk(b"", claims(1 << 40), 100),
    "claims 1 TiB, twice": lambda: chunk(b"", claims(1 << 40), 1 << 40),
    "claims 200 MiB, without content": lambda: chunk(b"", claims(200 << 20), 200 << 20),
    "deep lists": lambda: of_json("/commands", deep(b"[", b"]", 200_000)),
    "deep objects": lambda: of_json("/commands", b'{"a":' * 900 + b"1" + b"}" * 900),
    "broken": lambda: of_json("/commands", b"{nope"),
    "a list": lambda: of_json("/joint_states", b"[1, 2]"),
    "a number": lambda: of_json("/events", b"3"),
    "other fields": lambda: of_json("/commands", b'{"a": 1}'),
    "other joints": lambda: of_json("/joint_setpoints", b'{"position": {}}', b'{"position": 1}'),
    "no duration": lambda: of_json(
        "/commands", b'{"function": "f", "arguments": 5, "duration": "long"}'
    ),
    "no text": lambda: of_json("/commands", b'{"n": "\xe4"}'),
    "half a pair": lambda: of_json("/x", b'{"n": "\\ud800"}'),
    "a large number": lambda: of_json("/x", b'{"n": 1' + b"0" * 400 + b"}"),
    "large numbers": lambda: of_json("/x", b'{"n": [1' + b"0" * 400 + b"]}"),
    "a long number": lambda: of_json("/x", b'{"n": 1' + b"0" * 400_000 + b"}"),
    "late": lambda: of_json("/x", b'{"n": 1}', at=(1 << 63) + 5),
    "a strange topic": lambda: of_json("/../../\0/x\\y:z" + "a" * 300, b'{"n": 1}'),
}


def used(path: Path, folder: Path) -> None:
    """Read all that a recording offers."""
    run = read(path)
    list(run.messages())
    for topic in run.topics:
        run.arrays(topic)
    for file in run.to_csv(folder):
        assert file.resolve().parent == folder.resolve()


@for_each("kind", STRANGE)
def test_a_strange_file_is_read_or_refused_by_a_typed_error(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(HEAD + STRANGE[kind]() + END)
    tracemalloc.start()
    try:
        for use in (
            lambda: used(path, tmp_path / "csv"),
            lambda: RecordedPath.of(read(path)),
            lambda: draw_page(read(path), tmp_path / "run.html"),
            lambda: judge(path, arm="gcr5_910"),
            lambda: learn(path, arm="gcr5_910"),
            lambda: read_evidence(path),
        ):
            with contextlib.suppress(DucoError):
                use()
        assert tracemalloc.get_traced_memory()[1] < 300 << 20
    finally:
        tracemalloc.stop()


def test_the_times_are_those_of_the_recording_also_beside_a_field_of_this_name(
    tmp_path: Path,
) -> None:
    path = tmp_path / "run.mcap"
    rows = (message(1, b'{"time": 7, "x": 1}', 10**18 + at * 10**9) for at in range(3))
    path.write_bytes(HEAD + channel(1, "/x") + b"".join(rows) + END)
    found = read(path).arrays("/x")
    assert {name: values.tolist() for name, values in found.items()} == {
        "time": [0.0, 1.0, 2.0], "x": [1, 1, 1]
    }  # fmt: skip


def joints(**changed: Any) -> bytes:
    """A file of a moving arm, of which the sample in the middle is changed."""
    rows: list[dict[str, Any]] = [{"position": [0.01 * number] * 6} for number in range(11)]
    rows[5] |= changed
    told = enumerate(json.dumps(row).encode() for row in rows)
    samples = b"".join(message(1, row, 10**18 + number * 10**7) for number, row in told)
    return HEAD + chunk(channel(1, "/joint_setpoints") + samples) + END


@for_each("names", [[f"joint_{number}" for number in (6, 5, 4, 3, 2, 1)], [*"abcdef"]])
def test_joints_in_another_order_are_no_path(names: list[str], tmp_path: Path) -> None:
    """Each joint was to follow the angles of another one."""
    path = tmp_path / "run.mcap"
    path.write_bytes(joints(names=names))
    with pytest.raises(RecordingError, match=f"{names[0]}, {names[1]}.* joint_1 to joint_6"):
        RecordedPath.of(read(path))


@for_each("position", [None, [0.0, 0.0, math.nan, 0.0, 0.0, 0.0]])
def test_a_sample_without_joints_is_missing(position: Any, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(joints(position=position))
    found = RecordedPath.of(read(path))
    assert found.positions[:, 0].tolist() == [0.01 * number for number in range(11) if number != 5]


@pytest.mark.slow
def test_a_small_file_does_not_unpack_to_gigabytes(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    plain = channel(1, "/x") + message(1, b"{}")
    large = plain + record(0x99, bytes(60 << 20))
    path.write_bytes(HEAD + chunk(large) * 5 + END)
    with pytest.raises(RecordingError, match="unpacks to more than"):
        read(path)


def test_a_large_file_takes_no_memory_by_itself(tmp_path: Path) -> None:
    """An attachment of 3 GiB, as other makers' files have, before the messages."""
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        file.write(HEAD + struct.pack("<BQ", 0x09, 3 << 30))
        file.seek(3 << 30, os.SEEK_CUR)
        file.write(of_json("/x", b'{"n": 1}') + END)
    tracemalloc.start()
    try:
        run = read(path)
        assert (run.complete, run.topics) == (True, {"/x": 1})
        assert tracemalloc.get_traced_memory()[1] < 16 << 20
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("size", [5 << 40, 1 << 62, (1 << 64) - 1])
def test_a_record_that_claims_more_than_the_file_has_ends_it(size: int, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    whole = HEAD + of_json("/x", b'{"n": 1}')
    for kind in (0x06, 0x09):
        path.write_bytes(whole + struct.pack("<BQ", kind, size) + END)
        run = read(path)
        assert (run.complete, run.topics) == (False, {"/x": 1})


def test_what_is_kept_is_bounded_for_large_files_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("aioduco.recording.container._MOST", 1 << 20)
    path = tmp_path / "run.mcap"
    messages = [message(1, bytes(1 << 16)) for _ in range(20)]
    path.write_bytes(HEAD + channel(1, "/x") + b"".join(messages[:10]) + END)
    assert read(path).topics == {"/x": 10}
    path.write_bytes(HEAD + channel(1, "/x") + b"".join(messages) + END)
    with pytest.raises(RecordingError, match="unpacks to more than"):
        read(path)


@pytest.mark.slow
def test_a_small_file_does_not_hold_millions_of_messages(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("aioduco.recording.container._ALWAYS", 1 << 24)
    path = tmp_path / "run.mcap"
    path.write_bytes(HEAD + chunk(channel(1, "/x") + message(1, b"") * 44_000) + END)
    with pytest.raises(RecordingError, match="unpacks to more than"):
        read(path)


@pytest.mark.slow
def test_a_long_recording_is_within_the_bound(tmp_path: Path) -> None:
    """Thousands of messages that differ in their time alone, as of an arm that stands."""
    path = tmp_path / "run.mcap"
    body = json.dumps({"position": [0.1] * 6, "velocity": [0.0] * 6}).encode()
    chunks = [
        chunk(channel(1, "/x") + b"".join(message(1, body, 10**18 + n * 2_000_000 + k * 10**9)
                                          for n in range(500)))
        for k in range(60)
    ]  # fmt: skip
    path.write_bytes(HEAD + b"".join(chunks) + END)
    run = read(path)
    assert (run.complete, run.topics) == (True, {"/x": 30_000})
    spent = 60 * 500 * (len(body) + 31 + 512)
    assert spent < (1 << 28) + 100 * path.stat().st_size


@pytest.mark.skipif(sys.platform == "win32", reason="rights of Unix")
def test_what_is_recorded_is_readable_by_its_owner_alone(tmp_path: Path) -> None:
    from aioduco.recording.writer import _created  # noqa: PLC0415

    def rights(path: Path) -> int:
        return stat.S_IMODE(path.stat().st_mode)

    path, number = _created(tmp_path / "new.mcap")

    os.close(number)
    assert rights(path) == 0o600
    path.write_bytes(HEAD + of_json("/x", b'{"n": 1}') + END)
    run: Any = read(path)
    written = [run.to_mcap(tmp_path / "indexed.mcap"), *run.to_csv(tmp_path / "csv")]
    assert [rights(each) for each in written] == [0o600] * len(written)


def test_each_channel_has_a_table_of_its_own(tmp_path: Path) -> None:
    """Two topics had one file, of which the later one was left; long names had none."""
    topics = ["/a/b", "/a_b", "a_b", "/A_b", "/" + "部件" * 90]
    channels = b"".join(channel(number, topic) for number, topic in enumerate(topics, 1))
    said = b"".join(message(number, b'{"n": %d}' % number) for number in range(1, 6))
    path = tmp_path / "run.mcap"
    path.write_bytes(HEAD + chunk(channels + said) + END)
    files = read(path).to_csv(tmp_path / "csv")
    assert len({file.name.casefold() for file in files}) == 5
    assert sorted(file.read_text().splitlines()[1][-1] for file in files) == list("12345")


def test_tables_in_the_place_of_a_file_are_a_typed_error(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(HEAD + of_json("/x", b'{"n": 1}') + END)
    run = read(path)
    for write in (run.to_csv, run.to_parquet):
        with pytest.raises(RecordingError, match="cannot be written"):
            write(path)
        with pytest.raises(ParameterError, match="folder"):
            write(None)  # type: ignore[arg-type]
    with contextlib.chdir(tmp_path):
        assert run.to_csv(".") == [Path("x.csv")]
    with pytest.raises(ParameterError, match="path"):
        run.to_mcap(5)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="topic"):
        run.arrays(["/x"])  # type: ignore[arg-type]
