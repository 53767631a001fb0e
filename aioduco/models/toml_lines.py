"""Where in a TOML text its fields are: for messages with lines, and for edits that keep the rest.

`tomllib` reads values without their places. Here the text of a valid file is taken apart into its
statements, heads of tables and `key = value`, each of which `tomllib` reads by itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from aioduco.models.toml_files import parse_toml

if TYPE_CHECKING:
    from collections.abc import Iterator


#: keys from the top to a field, with the number of a table in an array of tables, from 0:
#: ("robots", "left", "host"), ("limit", 0, "kind")
TomlPath: TypeAlias = tuple[str | int, ...]


class Statement(NamedTuple):
    """A head of a table, or a key with its value, with its place in the text.

    Attributes:
        begin: its first line, from 1.
        end: its last line.
        text: its text without the last line end, with a comment behind it.
        path: keys of the table or of the value.
        value: the value; None for the head of a table.
    """

    begin: int
    end: int
    text: str
    path: TomlPath
    value: Any


def statements(text: str) -> Iterator[Statement]:
    """Take a text apart.

    Args:
        text: the text of a file that is valid TOML.
    """
    table: TomlPath = ()
    counts: dict[TomlPath, int] = {}
    lines = [each.removesuffix("\r") for each in text.removeprefix("\ufeff").split("\n")]
    begin = 0
    while begin < len(lines):
        end, read = _complete(lines, begin)
        whole = "\n".join(lines[begin:end])
        if read and whole.lstrip().startswith("["):
            many = whole.lstrip().startswith("[[")
            table = _numbered(_keys(read), counts, many=many)
            yield Statement(begin + 1, end, whole, table, None)
        elif read:
            key = _keys(parse_toml(f"{whole[: key_end(whole)]}= 0"))
            value = read
            for each in key:
                value = value[each]
            yield Statement(begin + 1, end, whole, (*table, *key), value)
        begin = end


def line_of(text: str, path: TomlPath) -> int:
    """The line of a field, or of the innermost table around it; 1 if there is none.

    Args:
        text: the text of a file that is valid TOML.
        path: keys from the top to the field.
    """
    best, line = 0, 1
    for each in statements(text):
        if each.path[: len(path)] == path:
            return each.begin
        depth = len(each.path)
        if depth > best and each.path == path[:depth]:
            best, line = depth, each.begin
    return line


def _complete(lines: list[str], begin: int) -> tuple[int, dict[str, Any]]:
    """The line after a statement, and what the statement says; it ends where it can be read."""
    for end in range(begin + 1, len(lines) + 1):
        try:
            return end, parse_toml("\n".join(lines[begin:end]))
        except ValueError:
            continue
    return len(lines), {}


def _keys(read: dict[str, Any]) -> tuple[str, ...]:
    """The keys of a head, or of `key = 0`, which was read by itself."""
    found = []
    inner: Any = read
    while isinstance(inner, dict | list) and inner:
        if isinstance(inner, list):  # of an array of tables
            (inner,) = inner
            continue
        ((key, inner),) = inner.items()
        found.append(key)
    return tuple(found)


def key_end(statement: str) -> int:
    """Where the equals sign behind the key of a statement is; a quoted key may contain others."""
    end = statement.index("=")
    while True:
        try:
            parse_toml(f"{statement[:end]}= 0")
        except ValueError:
            end = statement.index("=", end + 1)
        else:
            return end


def _numbered(keys: tuple[str, ...], counts: dict[TomlPath, int], *, many: bool) -> TomlPath:
    """The path of a head: behind the name of an array of tables comes the number of the table."""
    path: TomlPath = ()
    for depth, key in enumerate(keys, 1):
        path = (*path, key)
        if many and depth == len(keys):
            counts[path] = counts.get(path, -1) + 1
        if path in counts:
            path = (*path, counts[path])
    return path
