"""How long a program waits: the one rule for all times that never go onto the wire."""

from __future__ import annotations

from typing import Final

from aioduco.models.rules import Number

__all__ = ["SECONDS"]

#: a time limit, or a deadline from now on
SECONDS: Final = Number(0.0, unit="s", open_low=True, source="this package")
