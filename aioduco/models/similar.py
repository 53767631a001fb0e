"""Names that a person wrote wrongly: which of the known ones was meant."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["did_you_mean", "unknown"]

#: characters of the longest text that may be a name, and is shown whole
_LONGEST = 100


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """The nearest of the known names, as the end of a message: ": did you mean 'left'?".

    Args:
        name: what was written.
        known: the names that there are.

    Returns:
        The text; empty if no name is near.
    """
    import difflib  # noqa: PLC0415 - for errors alone

    if len(name) > _LONGEST:
        return ""
    by_case = {each.casefold(): each for each in known}
    near = difflib.get_close_matches(name.casefold(), by_case, n=1, cutoff=0.6)
    return f": did you mean {by_case[near[0]]!r}?" if near else ""


def unknown(name: str, known: Iterable[str], *, most: int = 12) -> str:
    """What to say of a name that is not known: the nearest one, and what there is.

    Args:
        name: what was written.
        known: the names that there are.
        most: number of names up to which all are listed.
    """
    names = list(known)
    listed = f"; there are {', '.join(names) or 'none'}" if len(names) <= most else ""
    shown = name if len(name) <= _LONGEST else f"{name[:_LONGEST]}…"
    return f"{shown!r} is not known{listed}{did_you_mean(name, names)}"
