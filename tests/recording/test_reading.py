"""Reading back: the numbers of other readers, files that were cut off, tables."""

from __future__ import annotations

import contextlib
import csv
import json
import struct
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pytest
from mcap.reader import make_reader
from pyarrow import parquet

import aioduco
import aioduco.sync
from aioduco.models.numpy_on_use import json_value
from aioduco.models.pose import Pose
from aioduco.recording import RecordedRun, read
from aioduco.recording.channels import ANGLE, LENGTH, QUATERNION, SPEED
from aioduco.recording.container import CHANNEL, CHUNK, DATA_END, MAGIC, MESSAGE, METADATA, SCHEMA
from aioduco.sim import Simulator
from recording.mcap_records import channel, decoded, message, record, text


@pytest.fixture
def run(whole: Path) -> RecordedRun:
    return read(whole)


@pytest.mark.slow
def test_the_numbers_are_those_of_the_format_s_own_readers(whole: Path, run: RecordedRun) -> None:
    ours = {topic: list(run.messages(topic)) for topic in run.topics}
    counts = dict.fromkeys(run.topics, 0)
    with whole.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_header().profile == "aioduco"
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            mine = ours[channel.topic][counts[channel.topic]]
            counts[channel.topic] += 1
            assert mine.time_ns == message.log_time
            if channel.message_encoding == "json":
                assert mine.data == json.loads(message.data)
                continue
            theirs = decoded(schema.data, schema.name, message.data)
            match schema.name:
                case "foxglove.JointStates":
                    assert mine.data["names"] == [joint.name for joint in theirs.joints]
                    for name in ("position", "velocity"):
                        assert mine.data[name] == [getattr(joint, name) for joint in theirs.joints]
                    stamp = theirs.timestamp
                    assert stamp.seconds * 10**9 + stamp.nanos == message.log_time
                case "foxglove.FrameTransforms":
                    for one in theirs.transforms:
                        stamp = one.timestamp
                        assert stamp.seconds * 10**9 + stamp.nanos == message.log_time
                        part = mine.data[one.child_frame_id]
                        assert part["parent"] == one.parent_frame_id
                        place, turned = one.translation, one.rotation
                        assert part["translation"] == [place.x, place.y, place.z]
                        assert part["rotation"] == [turned.x, turned.y, turned.z, turned.w]
                case "foxglove.Log":
                    for name in ("message", "name", "file", "line"):
                        assert mine.data[name] == getattr(theirs, name)
                    level = theirs.DESCRIPTOR.fields_by_name["level"].enum_type
                    assert mine.data["level"] == level.values_by_number[theirs.level].name
                case name:
                    pytest.fail(f"a schema that is not compared: {name}")
        told = {each.name: each.metadata for each in reader.iter_metadata()}
    assert counts == run.topics
    assert int(told["aioduco.end"]["written"]) == sum(counts.values())
    assert counts["/joint_states"] > 10
    assert counts["/log"] >= 1


@pytest.mark.slow
def test_arrays_are_what_was_recorded_within_their_grids(run: RecordedRun) -> None:
    joints = run.arrays("/joint_states")
    assert joints["position"].shape == joints["velocity"].shape == (len(joints["time"]), 6)
    assert joints["position"][-1] == pytest.approx([0.4, -0.2, 1.8, 0.1, -1.5, 0.2], abs=0.01)
    assert np.all(joints["position"] * ANGLE % 1 == 0)
    assert np.all(joints["velocity"] * SPEED % 1 == 0)
    assert np.all(np.diff(joints["time"]) > 0)
    assert 0 <= joints["time"][0] < joints["time"][-1] <= run.duration
    frames = run.arrays("/tf")
    assert set(frames["flange.parent"]) <= {"tcp", None}
    assert np.linalg.norm(frames["tcp.rotation"], axis=1) == pytest.approx(1.0, abs=1e-5)
    with pytest.raises(aioduco.ParameterError, match="/joint_states"):
        run.arrays("/nothing")


@pytest.mark.slow
async def test_transforms_are_the_poses_of_the_arm(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Simulator() as sim:
        async with aioduco.connect(sim.host, sim.port, clock=sim.clock) as robot:
            await robot.bring_up()
            await robot.frames.set_tool_data("long", [0.1, 0.0, 0.2, 0.0, 0.3, 0.0], [1, 0, 0, 0])
            async with robot.record(tmp_path / "run.mcap") as recording:
                taken: list[str] = []
                put = recording._writer.put

                def seen(kind: str, *rest: Any) -> None:
                    taken.append(kind)
                    put(kind, *rest)

                monkeypatch.setattr(recording._writer, "put", seen)
                # The flange comes with the next samples, and so does the one of another tool.
                for tool in ("long", "short"):
                    if tool == "short":
                        await robot.frames.set_tool_data(tool, [0, 0, 0.1, 0, 0, 0], [1, 0, 0, 0])
                    taken.clear()
                    with robot.feed.subscribe() as samples:
                        after: list[str] = []
                        # One question about it may have been under way while the tool changed.
                        while after.count("flange") < 2 or after[::-1].index("flange") < 3:
                            sample = await anext(samples)
                            after = [each for each in taken if each in ("flange", "sample")]
            pose = sample.status.pose
            flange = await robot.state.get_flange_pose()
    arrays = read(tmp_path / "run.mcap").arrays("/tf")

    def last(name: str) -> Pose:
        rows = [i for i, parent in enumerate(arrays[f"{name}.parent"]) if parent is not None]
        place, turned = (
            arrays[f"{name}.translation"][rows[-1]],
            arrays[f"{name}.rotation"][rows[-1]],
        )
        if place.dtype == object:
            place, turned = np.array(place, float), np.array(turned, float)
        return Pose.from_quaternion(place, turned / np.linalg.norm(turned), order="xyzw")

    near = {"position": 3 / LENGTH, "rotation": 8 / QUATERNION}
    assert last("tcp").almost_equal(pose, **near)
    assert (last("tcp") @ last("flange")).almost_equal(flange, **near)


@pytest.mark.slow
def test_a_file_that_is_cut_off_anywhere_is_read_up_to_there(whole: Path, tmp_path: Path) -> None:
    data = whole.read_bytes()
    before = 0
    for length in range(8, len(data), 101):
        part = tmp_path / "part.mcap"
        part.write_bytes(data[:length])
        found = read(part)
        count = sum(found.topics.values())
        assert count >= before, "what could be read of a shorter one is missing"
        before = count
        for _ in found.messages():
            pass
    assert before == sum(read(whole).topics.values())
    part.write_bytes(data[:400])
    assert repr(read(part)).endswith("cut off>")


@pytest.mark.slow
def test_a_garbled_chunk_ends_what_is_read(whole: Path, tmp_path: Path) -> None:
    data = bytearray(whole.read_bytes())
    at, chunks = 8, []
    while data[at] != 0x0F:
        (length,) = struct.unpack_from("<Q", data, at + 1)
        if data[at] == 6:
            chunks.append((at + 9, length))
        at += 9 + length
    start, length = chunks[-1]
    data[start + length // 2] ^= 0xFF
    bad = tmp_path / "bad.mcap"
    bad.write_bytes(data)
    found = read(bad)
    assert not found.complete
    assert sum(found.topics.values()) < sum(read(whole).topics.values())


@pytest.mark.parametrize(
    ("kind", "content"),
    [
        pytest.param(MESSAGE, struct.pack("<HIQQ", 7, 0, 0, 0), id="unknown channel"),
        pytest.param(MESSAGE, b"\0" * 21, id="short message"),
        pytest.param(SCHEMA, b"\0", id="short schema"),
        pytest.param(CHANNEL, b"\0" * 3, id="short channel"),
        pytest.param(CHANNEL, struct.pack("<HHI", 2, 0, 9) + b"/x", id="short text"),
        pytest.param(CHANNEL, b"\0" * 4 + text(b"\xff") + text(b"json"), id="no UTF-8"),
        pytest.param(METADATA, text(b"\xff") + text(b""), id="no UTF-8 in metadata"),
        pytest.param(METADATA, text(b"end") + struct.pack("<I", 9), id="short metadata"),
        pytest.param(CHUNK, b"\0" * 27, id="short chunk"),
        pytest.param(
            CHUNK,
            struct.pack("<QQQI", 0, 0, 2, 0) + text(b"") + struct.pack("<Q", 2) + b"\5\1",
            id="incomplete record in a chunk",
        ),
    ],
)
def test_a_damaged_record_ends_what_is_read(kind: int, content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "bad.mcap"
    before = [
        record(METADATA, text(b"aioduco") + text(text(b"arm") + text(b"gcr5"))),
        channel(1, "/io"),
        message(1, b'{"a": 1}', 5),
    ]
    after = [before[-1], record(DATA_END, b"\0" * 4), MAGIC]
    path.write_bytes(MAGIC + b"".join([*before, *after]))
    assert read(path).complete
    path.write_bytes(MAGIC + b"".join([*before, record(kind, content), *after]))
    found = read(path)
    assert not found.complete
    assert found.metadata == {"arm": "gcr5"}
    assert [each.data for each in found.messages()] == [{"a": 1}]


def test_a_file_that_was_cut_off_after_its_messages_is_not_complete(tmp_path: Path) -> None:
    """Other readers need what was there: a summary, and the end."""
    path = tmp_path / "cut.mcap"
    data = MAGIC + channel(1, "/io") + message(1, b"{}") + record(DATA_END, b"\0" * 4)
    for end, complete in ((record(2, bytes(20)) + MAGIC, True), (record(2, bytes(20)), False)):
        path.write_bytes(data + end)
        assert (read(path).complete, read(path).topics) == (complete, {"/io": 1})


def test_a_damaged_begin_is_that_of_the_first_message(tmp_path: Path) -> None:
    path = tmp_path / "bad.mcap"
    records = [
        record(METADATA, text(b"aioduco") + text(text(b"started") + text(b"1?"))),
        channel(1, "/io"),
        message(1, b'{"a": 1}', 5),
        record(DATA_END, b"\0" * 4),
        MAGIC,
    ]
    path.write_bytes(MAGIC + b"".join(records))
    found = read(path)
    assert found.started_ns == 5
    assert not found.complete


@pytest.mark.slow
def test_no_changed_byte_makes_a_file_unreadable(whole: Path, tmp_path: Path) -> None:
    data = whole.read_bytes()
    bad = tmp_path / "bad.mcap"
    for at in range(8, len(data), 53):
        changed = bytearray(data)
        changed[at] ^= 0xFF
        bad.write_bytes(changed)
        with contextlib.suppress(aioduco.RecordingError):  # its compression has another name
            for message in read(bad).messages():
                assert message.topic


def test_what_is_no_recording_is_refused(tmp_path: Path) -> None:
    with pytest.raises(aioduco.RecordingError, match="cannot be read"):
        read(tmp_path / "none.mcap")
    (tmp_path / "text.mcap").write_text("hello")
    with pytest.raises(aioduco.RecordingError, match="is no recording"):
        read(tmp_path / "text.mcap")


@pytest.mark.slow
def test_tables_have_the_same_numbers(run: RecordedRun, tmp_path: Path) -> None:
    arrays = run.arrays("/joint_states")
    assert {path.stem for path in run.to_csv(tmp_path)} == {name[1:] for name in run.topics}
    run.to_parquet(tmp_path)
    with (tmp_path / "joint_states.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    table = parquet.read_table(tmp_path / "joint_states.parquet")
    assert table.schema.metadata[b"address"] == run.metadata["address"].encode()
    for index in range(6):
        column = arrays["position"][:, index].tolist()
        assert [float(row[f"position_{index + 1}"]) for row in rows] == column
        assert table[f"position_{index + 1}"].to_pylist() == column
    assert table["time"].to_pylist() == arrays["time"].tolist()
    tasks = parquet.read_table(tmp_path / "tasks.parquet")
    assert tasks["outcome"].to_pylist()[-1] == "FINISHED"
    assert str(tasks.schema.field("id").type) == "int64"
    assert str(tasks.schema.field("duration").type) == "double"
    with (tmp_path / "tasks.csv").open(encoding="utf-8", newline="") as file:
        assert all(row["id"].isdigit() for row in csv.DictReader(file))


@pytest.mark.slow
def test_an_index_is_added_and_nothing_else(whole: Path, run: RecordedRun, tmp_path: Path) -> None:
    path = run.to_mcap(tmp_path / "indexed.mcap")
    found = read(path)
    assert found.complete
    assert list(found.messages()) == list(run.messages())
    assert found.metadata == run.metadata
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert summary.chunk_indexes
    assert all(index.message_index_offsets for index in summary.chunk_indexes)
    with pytest.raises(aioduco.RecordingError, match="exists"):
        run.to_mcap(path)
    data, at = whole.read_bytes(), 8
    while data[at] != DATA_END:
        at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data[:at])
    part = read(cut)
    assert part.topics
    assert not part.complete
    mended = read(part.to_mcap(tmp_path / "mended.mcap"))
    assert list(mended.messages()) == list(part.messages())


def test_an_index_that_cannot_be_written_leaves_no_file(
    run: RecordedRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The library's error was raised, and its part of a file stood in the way of the next one."""

    def full(file: BinaryIO, **_: object) -> None:
        file.write(MAGIC)
        raise RuntimeError("I/O error from writing")

    monkeypatch.setattr("foxglove.open_mcap", full)
    with pytest.raises(aioduco.RecordingError, match=r"x\.mcap cannot be written: I/O error"):
        run.to_mcap(tmp_path / "x.mcap")
    assert not (tmp_path / "x.mcap").exists()


def test_values_become_what_json_knows() -> None:
    found = json_value(
        {"a": (1, float("nan")), 2: b"\x01", "x": np.array([1.0]), "p": Pose(*[0.0] * 6)},
        recorded=True,
    )
    assert found["a"] == [1, None]
    assert found["2"] == "01"
    assert found["x"] == [1.0]
    assert json.dumps(found)
