"""A file is written completely or not at all, whatever writes it."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import typer

from aioduco.cli import picture
from aioduco.cli.exit_codes import write_file
from aioduco.errors import ParameterError
from aioduco.kinematics import arm
from aioduco.models.whole_files import whole_file, write_whole
from aioduco.recording.tables import write_csv
from aioduco.sim.twin import TwinLimits
from aioduco.streaming.report import StreamStatistics

BEFORE = "what was there\n"


def _fails_half_way(path: Path) -> None:
    with whole_file(path) as file:
        file.write(b"new")
        file.flush()
        raise OSError(errno.ENOSPC, "full")


def test_what_was_there_stays_if_the_new_content_does_not_fit(tmp_path: Path) -> None:
    path = tmp_path / "figures.json"
    path.write_text(BEFORE)
    path.chmod(0o640)
    with pytest.raises(OSError, match="full") as failed:
        _fails_half_way(path)
    assert str(failed.value) == f"[Errno {errno.ENOSPC}] full: {str(path)!r}"
    assert path.read_text() == BEFORE
    write_whole(path, "new\n")
    assert (path.read_bytes(), path.stat().st_mode & 0o777) == (b"new\n", 0o640)
    assert [*tmp_path.iterdir()] == [path]
    with pytest.raises(IsADirectoryError) as failed:
        write_whole(tmp_path, "new\n")
    assert str(failed.value).endswith(f"directory: {str(tmp_path)!r}")
    with pytest.raises(ParameterError, match="path is 5, but must be the name of a file"):
        write_whole(5, "new\n")  # type: ignore[arg-type]  # wrong on purpose


def _statistics(path: Path) -> None:
    made = SimpleNamespace(as_dict=lambda: {"ticks": [*range(100)]})
    StreamStatistics.save(cast("Any", made), path)


def _pictures(path: Path) -> None:
    chance = np.random.default_rng(1)
    shown = [chance.integers(0, 255, (32, 32, 3), dtype=np.uint8) for _ in range(2)]
    picture.save(path, shown, [1.0, 1.0])


def _table(path: Path) -> None:
    write_csv([(path.stem, {"time": np.arange(1000.0)})], path.parent)


def _option(path: Path) -> None:
    try:
        write_file(path, "x" * 1000)
    except typer.Exit as ended:
        raise OSError from ended


WRITERS = {
    "statistics.json": _statistics,
    "limits.json": lambda path: TwinLimits.of(arm("gcr5_910")).save(path),
    "figure.png": _pictures,
    "figure.gif": _pictures,
    "table.csv": _table,
    "report.html": _option,
}


@pytest.mark.linux("limits of the size of files")
@pytest.mark.slow  # a process, as the limit is one of a process
@pytest.mark.parametrize("name", WRITERS)
def test_each_writer_keeps_what_was_there_on_a_full_disk(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text(BEFORE)
    # by itself: this file is what it runs, and knows no other of the tests
    done = subprocess.run(
        [sys.executable, __file__, str(path)], check=False, capture_output=True, text=True
    )
    assert (done.returncode, done.stdout) == (0, "refused\n"), done.stderr
    assert path.read_text() == BEFORE
    assert [*tmp_path.iterdir()] == [path]


if __name__ == "__main__":
    import resource

    sys.dont_write_bytecode = True  # Python would leave the first 100 bytes, and others read them
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))  # bytes; pipes have no such limit
    try:
        WRITERS[os.path.basename(sys.argv[1])](Path(sys.argv[1]))  # noqa: PTH119 - a text
    except OSError:
        sys.stdout.write("refused\n")


def test_a_file_with_the_longest_name_is_written(tmp_path: Path) -> None:
    for name in ("a" * 255, "部" * 85):
        write_whole(tmp_path / name, "new")
        assert (tmp_path / name).read_text() == "new"


def test_two_threads_that_write_one_file_do_not_mix(tmp_path: Path) -> None:
    path, opened, written = tmp_path / "file", threading.Event(), threading.Event()

    def slow() -> None:
        with whole_file(path) as file:
            file.write(b"slow" * 10)
            file.flush()
            opened.set()
            written.wait(60.0)

    thread = threading.Thread(target=slow)
    thread.start()
    try:
        assert opened.wait(60.0)
        write_whole(path, "quick")
        assert path.read_text() == "quick"
    finally:
        written.set()
        thread.join()
    assert path.read_text() == "slow" * 10
    assert [*tmp_path.iterdir()] == [path]
