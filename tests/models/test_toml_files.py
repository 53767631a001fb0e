"""TOML files that people edit: read with any mark and line ends, and rewritten as they were."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import pytest

from aioduco import Joints, ParameterError, TaughtPoints, WaypointFileError
from aioduco.cli import robots_file
from aioduco.integrations.fleet import FleetFileError, FleetSettings
from aioduco.models.toml_files import read_text, rewrite
from aioduco.recording.playback import WaypointFile, read_envelope

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

MARK = b"\xef\xbb\xbf"
HOME = Joints.deg(30, -15, 105, 0, -90, 0)


def robots(path: Path) -> object:
    return robots_file._read(path)


#: by name: a reader, a file that it reads, and the error of one that it cannot
READERS: dict[str, tuple[Callable[[Path], Any], str, type[Exception]]] = {
    "waypoints": (
        WaypointFile.read,
        "[[waypoint]]\njoints_deg = [0, 0, 90, 0, -90, 0]\n",
        WaypointFileError,
    ),
    "points": (TaughtPoints.load, "[a]\njoints = [0, 0, 1, 0, -1, 0]\n", ParameterError),
    "envelope": (
        read_envelope,
        'arm = "gcr5_910"\n[[limit]]\nkind = "tool_speed"\nmost = 0.5\n',
        ParameterError,
    ),
    "fleet": (FleetSettings.read, '[fleet]\nname = "cell"\n', FleetFileError),
    "robots": (robots, '[left]\nhost = "10.0.0.1"\n', robots_file.WrongAddress),
}


@pytest.mark.cases(5)
@pytest.mark.parametrize("name", READERS)
def test_every_reader_takes_a_byte_order_mark_and_any_line_ends(name: str, tmp_path: Path) -> None:
    read, text, _ = READERS[name]
    path = tmp_path / "file.toml"
    plain = text.encode()
    found = []
    for data in (
        plain,
        MARK + plain,
        plain.replace(b"\n", b"\r\n"),
        MARK + plain.replace(b"\n", b"\r\n"),
    ):
        path.write_bytes(data)
        made = read(path)
        found.append(repr(getattr(made, "limits", made)))
    assert len(set(found)) == 1


@pytest.mark.cases(5)
@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize("data", [b"[", b"\xff\xfea", MARK + b"x", b"a = " + b"[" * 100_000])
def test_every_reader_refuses_what_is_no_toml(name: str, data: bytes, tmp_path: Path) -> None:
    read, _, error = READERS[name]
    path = tmp_path / "file.toml"
    path.write_bytes(data)
    with pytest.raises(error, match=r"file\.toml"):
        read(path)


def saved_waypoints(path: Path) -> None:
    file = WaypointFile.read(path)
    file.add("b", HOME)
    file.save(path)


def saved_points(path: Path) -> None:
    points = TaughtPoints.load(path)
    points["b"] = HOME
    points.save(path)


@pytest.mark.cases(4)
@pytest.mark.parametrize("mark", [b"", MARK])
@pytest.mark.parametrize("end", [b"\n", b"\r\n"])
@pytest.mark.parametrize("kind", ["waypoints", "points"])
def test_a_saved_file_is_the_same_but_for_its_text(
    kind: str, end: bytes, mark: bytes, tmp_path: Path
) -> None:
    real, link = tmp_path / "real.toml", tmp_path / "folder" / "link.toml"
    link.parent.mkdir()
    before = mark + READERS[kind][1].encode().replace(b"\n", end)
    real.write_bytes(before)
    real.chmod(0o640)
    link.symlink_to(real)
    {"waypoints": saved_waypoints, "points": saved_points}[kind](link)
    after = real.read_bytes()
    assert link.is_symlink()
    assert real.stat().st_mode & 0o777 == 0o640
    assert after.startswith(mark + b"[")
    assert after.count(b"\n") == after.count(end)
    if kind == "waypoints":
        assert after.startswith(before)
    assert "b" in str(READERS[kind][0](link).__dict__)
    assert [each.name for each in tmp_path.iterdir()] == ["folder", "real.toml"] or len(
        list(tmp_path.iterdir())
    ) == 2


def test_a_failed_save_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "cell.toml"
    TaughtPoints({"a": HOME}).save(path)
    before = path.read_bytes()

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        TaughtPoints({"b": HOME}).save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_text_with_its_own_line_ends_is_written_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "mixed.toml"
    mixed = 'a = 1\r\nb = 2\nc = "x"\r\n'
    path.write_bytes(mixed.encode())
    rewrite(path, read_text(path) + "d = 3\n")
    assert path.read_bytes() == (mixed + "d = 3\n").encode()


@pytest.mark.parametrize("name", READERS)
def test_a_file_that_no_person_wrote_is_refused_before_it_is_read_whole(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read, text, error = READERS[name]
    file = tmp_path / "file.toml"
    file.write_text(text + "#" * 1000)
    read(file)
    monkeypatch.setattr("aioduco.models.toml_files._LARGEST", 1000)
    with pytest.raises(error, match="larger than"):
        read(file)
