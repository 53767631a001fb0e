"""Channels of a recording as tables for other programs: CSV and Parquet."""

from __future__ import annotations

import csv
import io
import itertools
import json
import re
from typing import TYPE_CHECKING, Any, Final

from aioduco._process.platform import private
from aioduco.errors import MissingExtra
from aioduco.models.whole_files import whole_file

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    Channels = Iterable[tuple[str, dict[str, NDArray[Any]]]]

#: bytes of a channel's name in that of its file: names of files have 255
_LONGEST: Final = 200


def columns(arrays: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any] | list[str]]:
    """Make a column for each number: "position", shape (n, 6), gives "position_1" to "position_6".

    Other values become text: JSON, if they have parts.
    """
    found: dict[str, NDArray[Any] | list[str]] = {}
    for name, array in arrays.items():
        if array.dtype == object:
            found[name] = [
                value if isinstance(value, str) else "" if value is None else json.dumps(value)
                for value in array
            ]
        elif array.ndim == 1:
            found[name] = array
        else:
            for index in range(array.shape[1]):
                found[f"{name}_{index + 1}"] = array[:, index]
    return found


def write_csv(channels: Channels, folder: Path) -> list[Path]:
    """Write each channel, given its topic, as a CSV file; `RecordedRun.to_csv` describes it."""
    paths: list[Path] = []
    for topic, arrays in channels:
        found = columns(arrays)
        path = _free(folder, topic, ".csv", paths)
        with whole_file(path, private) as data:
            file = io.TextIOWrapper(data, encoding="utf-8", errors="replace", newline="")
            writer = csv.writer(file)
            writer.writerow(found)
            plain = [c if isinstance(c, list) else c.tolist() for c in found.values()]
            writer.writerows(zip(*plain, strict=True))
            file.detach()
        paths.append(path)
    return paths


def write_parquet(channels: Channels, metadata: dict[str, str], folder: Path) -> list[Path]:
    """Write each channel as a Parquet file; `RecordedRun.to_parquet` describes it."""
    with MissingExtra.named("a table in Parquet", "parquet"):
        import pyarrow as pa  # noqa: PLC0415 - an extra
        from pyarrow import parquet  # noqa: PLC0415
    paths: list[Path] = []
    for topic, arrays in channels:
        path = _free(folder, topic, ".parquet", paths)
        table = pa.table(dict(columns(arrays)))
        with whole_file(path, private) as file:
            parquet.write_table(table.replace_schema_metadata(metadata), file)
        paths.append(path)
    return paths


def _free(folder: Path, topic: str, ending: str, taken: Sequence[Path]) -> Path:
    """The file of a channel: two topics, such as "/a/b" and "/a_b", never get the same one."""
    plain = re.sub(r"[^\w.\-]", "_", topic.strip("/"))
    name = plain.encode()[:_LONGEST].decode(errors="ignore")
    others = {each.name.casefold() for each in taken}
    numbered = (f"{name}{f'_{number}' * (number > 1)}{ending}" for number in itertools.count(1))
    return folder / next(each for each in numbered if each.casefold() not in others)
