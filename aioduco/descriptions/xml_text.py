"""Convert numbers and XML elements to text."""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from aioduco.kinematics.mjcf_elements import numbers
from aioduco.models.bounds import shown

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["bounds", "numbers", "pretty", "rgba"]


def rgba(colour: Iterable[float]) -> str:
    """Return an opaque colour as red, green, blue and 1."""
    return f"{numbers(colour)} 1"


def bounds(low: float, high: float) -> tuple[str, str]:
    """Return two limits with twelve digits, each rounded to the inside."""
    return shown(low, low=True, digits=12), shown(high, digits=12)


def pretty(root: ET.Element, remark: str) -> str:
    """Return the text of a whole file, indented by two spaces.

    Args:
        root: root element of the file.
        remark: comment at the top of the file.
    """
    ET.indent(root)
    text = ET.tostring(root, encoding="unicode")
    return f'<?xml version="1.0"?>\n<!-- {remark} -->\n{text}\n'
