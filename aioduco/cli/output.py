"""What commands print: lines, and results in the types of JSON, for `--json`."""

from __future__ import annotations

import dataclasses
import enum
import json
import math
import sys
from typing import Any

__all__ = ["plain", "print_json", "say"]


def say(text: str, *, error: bool = False) -> None:
    """Print a line to the standard output, or to the standard error."""
    print(text, file=sys.stderr if error else sys.stdout, flush=True)


def plain(value: Any) -> Any:
    """A result in the types of JSON; NaN and infinities become None."""
    if isinstance(value, enum.Enum):
        return value.name
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, str | int | bool | None):
        return value
    return _parts(value)


def _parts(value: Any) -> Any:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        names = [field.name for field in dataclasses.fields(value)]
        return {name: plain(getattr(value, name)) for name in names}
    if callable(
        tolist := getattr(value, "tolist", None)
    ):  # a NumPy value; NumPy is not loaded here
        return plain(tolist())
    if isinstance(value, dict):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(each) for each in value]
    return str(value)


def print_json(value: Any) -> None:
    """Print a result as one line of JSON."""
    say(json.dumps(plain(value), allow_nan=False))
