"""The rule for a word of a few."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.errors import ParameterError
from aioduco.models.similar import did_you_mean

if TYPE_CHECKING:
    from collections.abc import Iterable


#: words of which all are listed as a person would say them
_MANY = 7


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
    near = did_you_mean(value, words) if isinstance(value, str) else ""
    raise ParameterError(name, value, _listed(words, besides) + near)


def _listed(words: list[str], besides: str) -> str:
    if len(words) > _MANY:
        return f"one of {', '.join(words)}" + (f", or {besides}" if besides else "")
    known = [*(f'"{word}"' for word in words), *([besides] if besides else [])]
    return " or ".join(filter(None, (", ".join(known[:-1]), known[-1])))
