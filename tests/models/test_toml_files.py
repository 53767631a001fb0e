"""TOML files that people edit: any byte order mark and line ends are read, and kept."""

from __future__ import annotations

import copy
import json
import math
import os
import stat
import tomllib
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from for_each import for_each

from aioduco import Cell, DucoError, Joints, ParameterError, TaughtPoints, WaypointFileError
from aioduco.cli import robots_file
from aioduco.integrations.fleet import FleetFileError, FleetSettings
from aioduco.models.toml_files import key_text, parse_toml, quoted, read_text, rewrite
from aioduco.recording.playback import WaypointFile, read_envelope
from aioduco.sim import ArmProfile

#: keys of 20,000 parts, each on the second line
DEEP = {
    "a dotted key": ".".join(["a"] * 20_000) + " = 1",
    "a head": f"[{'.'.join(['a'] * 20_000)}]",
    "quoted": " . ".join(['"a.b"'] * 20_000) + " = 1",
    "in a table": f"x = {{ {'.'.join(['a'] * 20_000)} = 1 }}",
    "many": "\n" + "\n".join(f"[{'.'.join([f'a{n}'] * 400)}]" for n in range(20)),
}

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


@for_each(
    "name, data", product(READERS, [b"[", b"\xff\xfea", MARK + b"x", b"a = " + b"[" * 100_000])
)
def test_every_reader_refuses_what_is_no_toml(name: str, data: bytes, tmp_path: Path) -> None:
    read, _, error = READERS[name]
    path = tmp_path / "file.toml"
    path.write_bytes(data)
    with pytest.raises(error, match=r"file\.toml"):
        read(path)


@pytest.mark.parametrize("name", [name for name in READERS if name != "robots"])
def test_every_reader_says_that_a_file_is_missing(name: str, tmp_path: Path) -> None:
    read, _, error = READERS[name]
    with pytest.raises(error, match=r"file\.toml.* read.*No such file"):
        read(tmp_path / "file.toml")


@for_each("name", sorted(READERS.keys() - {"robots"}))
def test_every_reader_says_that_a_name_is_none(name: str) -> None:
    read, _, error = READERS[name]
    for path in (5, None, 1.5):
        with pytest.raises(error, match="name of a file"):
            read(path)  # type: ignore[arg-type]


def test_robots_need_no_file(tmp_path: Path) -> None:
    assert robots(tmp_path / "file.toml") == ({}, "")


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
    assert {each.name for each in tmp_path.iterdir()} == {"folder", "real.toml"}


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


@pytest.mark.parametrize("kind", DEEP)
def test_a_key_that_is_nested_too_deep_is_refused_before_it_is_parsed(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def parsed(_: str) -> None:
        raise AssertionError("it takes 30 s")

    monkeypatch.setattr("tomllib.loads", parsed)
    with pytest.raises(ValueError, match=r"nested too deep \(at line [1-9]"):
        parse_toml(f"# a file\n{DEEP[kind]}\n")


@pytest.mark.slow
def test_what_only_looks_like_a_deep_key_is_read() -> None:
    dots = "a.b." * 20_000
    numbers = ", ".join(["0.5"] * 20_000)
    text = f'# {dots}\nlong = "{dots}"\nraw = """\n{dots}\n"""\nlist = [{numbers}]\n'
    found = parse_toml(text)
    assert (len(found["long"]), len(found["list"])) == (80_000, 20_000)
    assert parse_toml("a.b.c.d = 1") == {"a": {"b": {"c": {"d": 1}}}}


#: by name: a reader, and a file with each kind of field
WHOLE: dict[str, tuple[Callable[[Path], Any], str]] = {
    "points": (
        TaughtPoints.load,
        "a = {joints = [0,0,1,0,-1,0]}\nb = {pose_mm_deg = [1,2,3,4,5,6]}",
    ),
    "waypoints": (
        WaypointFile.read,
        """
        arm = "GCR5 910"
        defaults = {speed_deg_s = 20}
        waypoint = [{name = "a", joints_deg = [0,0,90,0,-90,0], motion = "line", dwell_s = 1.0}]
        """,
    ),
    "envelope": (
        read_envelope,
        """
        arm = "gcr5_910"
        limit = [
          {kind = "box", at = [0,0,1], size = [1,1,1], keep = "in", bodies = ["tool"], name = "x"},
          {kind = "tool_speed", most = 0.5, action = "slow", speed = 0.1},
        ]
        """,
    ),
    "fleet": (
        FleetSettings.read,
        """
        fleet = {name = "c", gateway = "a", listen = ["tcp/127.0.0.1:0"], rate = 5.0, expect = []}
        arm = [{name = "l", host = "10.0.0.1", port = 7003}]
        """,
    ),
    "robots": (robots, """default = "left"\nleft = {host = "10.0.0.1", port = 7003}"""),
    "profile": (
        ArmProfile.load,
        """
        model = "gcr5_910"
        geometry = {d2 = {value = 0.1411, low = 0.1410, high = 0.1412}, theta3 = 0.002}
        times = {enable = 0.7}
        sources = ["run.mcap"]
        """,
    ),
    "cell": (
        Cell.load,
        """
        arm = "gcr5_910"
        robots = {default = "l", l = {host = "10.0.0.1", mounting = "wall", model = "gcr10_1300"}}
        tool = {tcp_mm_deg = [0,0,150,0,0,90], load = [1.2,0,0,0.05], thing = [{kind = "rod"}]}
        gripper = {kind = "robotiq_2f85", unit = 9, timeout = 5.0}
        points = {a = {pose = [0.1,0,0.3,0,0,0], frame = "table"}, b = {joints_deg = [0,0,9,0,9,0]}}
        frames = {table = {pose = [0.5,0,0,0,0,0]}}
        scene = {padding = 0.01, thing = [{kind = "box", at = [0.5,0,0.1], size = [0.3,0.6,0.1]}]}
        limit = [{kind = "tool_speed", most = 0.5, robot = "l"}]
        defaults = {speed_deg_s = 20}
        waypoint = [{joints_deg = [1,2,3,4,5,6]}]
        """,
    ),
}
OTHERS: list[Any] = [
    *(True, 0, -1, 10**25, 1.5, math.nan, math.inf, "", "x", [], [1], ["a"], [[1]], {}, {"a": 1}),
    *([{}], [math.nan] * 6, [10**25] * 6, ["1"] * 6, [0] * 3, [0] * 6, [1e308] * 6, [True] * 6),
]


def places(value: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    if place:
        yield place
    inner: Any = ()
    if isinstance(value, (dict, list)):
        inner = value.items() if isinstance(value, dict) else enumerate(value)
    for key, each in inner:
        yield from places(each, (*place, key))


def toml(value: Any) -> str:
    if isinstance(value, dict):
        pairs = (f"{json.dumps(key)} = {toml(each)}" for key, each in value.items())
        return f"{{{', '.join(pairs)}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    return str(value) if isinstance(value, float) else json.dumps(value)


@pytest.mark.parametrize("name", WHOLE)
def test_a_value_of_another_kind_is_refused_by_a_typed_error(
    name: str, tmp_path: Path, thorough: bool
) -> None:
    read, text = WHOLE[name]
    path = tmp_path / "file.toml"
    path.write_text(text, encoding="utf-8")
    read(path)
    whole, wrong = tomllib.loads(text), []
    for number, place in enumerate(list(places(whole))[:: 1 if thorough else 5]):
        others = OTHERS[number % 5 :: 5] if thorough else [OTHERS[number % len(OTHERS)]]
        for other in others:
            changed = copy.deepcopy(whole)
            inner = changed
            for key in place[:-1]:
                inner = inner[key]
            inner[place[-1]] = other
            lines = [f"{json.dumps(key)} = {toml(value)}" for key, value in changed.items()]
            path.write_text("\n".join(lines), encoding="utf-8")
            try:
                read(path)
            except (DucoError, FleetFileError, robots_file.WrongAddress):
                pass
            except Exception as error:  # all of them in one message
                wrong.append(f"{place} = {other!r}: {error!r}")
    assert not wrong, "\n".join(wrong)


@for_each(
    "text",
    ["", 'a "b"', "back\\slash", "two\nlines", "a\r", "a\tb", "\x00\x1b", "\x7f", "é 部件 😀"],
)
def test_any_text_can_be_written_into_every_file(text: str, tmp_path: Path) -> None:
    assert tomllib.loads(f"{key_text(text)} = {quoted(text)}") == {text: text}
    path = tmp_path / "file.toml"
    ArmProfile("gcr5_910", sources=(text,)).save(path)
    assert ArmProfile.load(path).sources == (text,)
    assert WaypointFile.new(arm=text).arm == text


def test_the_name_of_a_file_that_is_no_text_can_be_written(tmp_path: Path) -> None:
    path = tmp_path / "file.toml"
    ArmProfile("gcr5_910", sources=("run\udcff.mcap",)).save(path)
    assert ArmProfile.load(path).sources[0].startswith("run\ufffd")


@pytest.mark.linux("named pipes")
def test_what_is_no_file_is_written_to_and_not_replaced(tmp_path: Path) -> None:
    """As root, `/dev/null` itself would become a file."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    try:
        rewrite(pipe, 'name = "é"\n')
        assert os.read(reader, 100) == 'name = "é"\n'.encode()
    finally:
        os.close(reader)
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert list(tmp_path.iterdir()) == [pipe]
