"""The rule for a word of a few."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.errors import ParameterError
from aioduco.models.similar import did_you_mean

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["one_of"]


def one_of(name: str, value: object, known: Iterable[str], *, besides: str = "") -> str:
    """Check that an argument is one of a few words, and return it.

    Args:
        name: the parameter's name.
        value: the argument, of any type.
        known: the words that there are.
        besides: what else the parameter takes, for the message.

    Raises:
        ParameterError: it is another word, of which the nearest is named, or no text.
    """
    words = list(known)
    if isinstance(value, str) and value in words:
        return str(value)
    listed = [*(f'"{word}"' for word in words), *([besides] if besides else [])]
    near = did_you_mean(value, words) if isinstance(value, str) else ""
    expected = " or ".join(filter(None, (", ".join(listed[:-1]), listed[-1])))
    raise ParameterError(name, value, expected + near)
