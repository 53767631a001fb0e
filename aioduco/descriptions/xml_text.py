"""Numbers and elements as text."""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["numbers", "pretty"]


def numbers(values: Iterable[float]) -> str:
    """Give numbers to twelve digits; what is only rounding of a zero is zero."""
    return " ".join(f"{round(float(value), 14) + 0.0:.12g}" for value in values)


def pretty(root: ET.Element, remark: str) -> str:
    """Give a whole file, indented by two spaces.

    Args:
        root: its root.
        remark: what a reader of the file should know first.
    """
    ET.indent(root)
    text = ET.tostring(root, encoding="unicode")
    return f'<?xml version="1.0"?>\n<!-- {remark} -->\n{text}\n'
