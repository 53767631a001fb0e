"""Results in the types of JSON, for `--json`."""

from __future__ import annotations

import dataclasses
import enum
import json
import math
from typing import Any

import typer

__all__ = ["plain", "print_json"]


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
    typer.echo(json.dumps(plain(value), allow_nan=False))
