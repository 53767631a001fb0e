"""Files that are written completely or not at all: a full disk loses nothing that was there."""

from __future__ import annotations

import errno
import os
import threading
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING

from aioduco.models.ranges import FILE

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


@contextmanager
def whole_file(
    path: str | os.PathLike[str], opener: Callable[[str, int], int] | None = None
) -> Iterator[IO[bytes]]:
    """Open a file for writing, which takes the place of an existing one when the block has ended.

    The file behind a symbolic link is written, and an existing file keeps its mode. A device or a
    pipe is not replaced by a file: what is written goes to it.

    Args:
        path: the file.
        opener: makes a new file, as of `open`.

    Raises:
        OSError: it cannot be written; an existing one stays unchanged. The error names the file.
        ParameterError: the path is none.
    """
    target = Path(os.path.realpath(FILE("path", path)))
    # one for each thread: two may write the same file. The name of the file itself may be the
    # longest that there is
    beside = f".{target.name[:40]}.{os.getpid()}.{threading.get_ident():x}"
    part = target.with_name(beside)
    try:
        if target.exists() and not target.is_file():
            with target.open("wb") as file:
                yield file
            return
        mode = target.stat().st_mode & 0o7777 if target.exists() else None
        if mode is not None and not os.access(target, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        try:
            with open(part, "wb", opener=opener) as file:
                if mode is not None:
                    part.chmod(mode)
                yield file
                file.flush()
                os.fsync(file.fileno())
            part.replace(target)
        finally:
            part.unlink(missing_ok=True)
    except OSError as error:
        if error.errno is None:
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error


def write_whole(path: str | os.PathLike[str], text: str, errors: str = "strict") -> None:
    """Write a text to a file, in UTF-8, completely or not at all: see `whole_file`."""
    data = text.encode("utf-8", errors)
    with whole_file(path) as file:
        file.write(data)
