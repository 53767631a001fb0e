"""TOML files that people edit: the one reader, and a writer that changes nothing but the text."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    import os
    from collections.abc import Iterable

_TEXT: Final = r"""(?:"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')"""
_PART: Final = rf"(?:[\w-]++|{_TEXT})"
#: keys of so many parts that they cost time: the square of their number; texts and comments are
#: passed over
_LONG_KEYS: Final = re.compile(
    r""""{3}[\s\S]*?"{3}|'{3}[\s\S]*?'{3}|#[^\n]*+|"""
    rf"(?P<key>(?<![\w-]){_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{15,}}+)|{_TEXT}|[\w-]++"
)
#: squares of the numbers of parts that are read at most
_WORK: Final = 1_000_000

#: keys that TOML writes without quotes, and what it does not have between quotes
_BARE_KEY: Final = re.compile(r"[A-Za-z0-9_-]+")
_ESCAPED: Final = re.compile(r'["\\\x00-\x08\x0a-\x1f\x7f]')

#: bytes of the largest file that is read; a person edits none that is larger
_LARGEST: Final = 1 << 26


def read_text(path: str | os.PathLike[str]) -> str:
    """Read a file as it is, without the byte order mark that some editors write.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is not UTF-8, or larger than 64 MiB; the message has the line of the first.
            Or the path is none.
    """
    try:
        target = Path(path)
    except TypeError as error:
        raise ValueError(f"{path!r} is not the name of a file") from error
    with target.open("rb") as file:
        data = file.read(_LARGEST + 1)  # a device has no end
    if len(data) > _LARGEST:
        raise ValueError(f"it is larger than {_LARGEST >> 20} MiB")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ValueError(f"line {line} is not UTF-8: save it as UTF-8") from error


def read_toml(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read a TOML file.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is no TOML; the message has the line.
    """
    return parse_toml(read_text(path))


def parse_toml(text: str) -> dict[str, Any]:
    """Parse a text of TOML.

    Raises:
        ValueError: it is no TOML; the message has the line.
    """
    import tomllib  # noqa: PLC0415 - most programs read none

    if not isinstance(text, str):
        raise ValueError(f"{text!r} is no text")  # noqa: TRY004 - as all else that is no TOML
    work = 0
    for key in _LONG_KEYS.finditer(text):
        work += len(re.findall(_PART, key["key"] or "")) ** 2
        if work > _WORK:
            line = text.count("\n", 0, key.start()) + 1
            raise ValueError(f"a key is nested too deep (at line {line})")
    try:
        read = tomllib.loads(text.removeprefix("\ufeff"))
    except RecursionError:
        raise ValueError("it is nested too deep") from None
    _check_numbers(read)
    return read


def _check_numbers(read: dict[str, Any]) -> None:
    """Refuse whole numbers that TOML does not have: those beyond 64 bits fit into no float."""
    left: list[tuple[object, object]] = list(read.items())
    while left:
        name, value = left.pop()
        if isinstance(value, dict):
            left += value.items()
        elif isinstance(value, list):
            left += ((name, each) for each in value)
        elif isinstance(value, int) and not -(1 << 63) <= value < 1 << 63:
            raise ValueError(f"{name} has a whole number beyond 64 bits")


def key_text(name: str) -> str:
    """A key as TOML writes it: with quotes if it needs them."""
    return name if _BARE_KEY.fullmatch(name) else quoted(name)


def quoted(text: str) -> str:
    """A text as TOML writes it; a lone surrogate, as of a file's name, becomes U+FFFD."""
    whole = text.encode("utf-8", "surrogatepass").decode("utf-8", "replace")
    return f'"{_ESCAPED.sub(lambda found: _escape(found[0]), whole)}"'


def listed(values: Iterable[float]) -> str:
    """Numbers as TOML writes them in a list, to four decimals."""
    return ", ".join(f"{round(value, 4) + 0.0:.4f}".rstrip("0").rstrip(".") for value in values)


def _escape(char: str) -> str:
    return f"\\{char}" if char in '"\\' else f"\\u{ord(char):04X}"


def rewrite(path: str | os.PathLike[str], text: str) -> None:
    """Write a file completely or not at all; it stays the same file but for its text.

    As `whole_file`. An existing file also keeps its byte order mark, and its line ends if the text
    has none of its own but "\\n".

    Raises:
        OSError: it cannot be written; an existing one stays unchanged.
        ParameterError: the path is none.
    """
    from aioduco.models.ranges import FILE  # noqa: PLC0415 - most programs write none
    from aioduco.models.whole_files import whole_file  # noqa: PLC0415

    path = FILE("path", path)
    before = path.read_bytes() if path.is_file() else b""
    plain = text.removeprefix("\ufeff")
    if b"\r\n" in before and "\r" not in plain:
        plain = plain.replace("\n", "\r\n")
    mark = b"\xef\xbb\xbf" if before.startswith(b"\xef\xbb\xbf") else b""
    data = mark + plain.encode()
    with whole_file(path) as file:
        file.write(data)
