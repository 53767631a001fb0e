"""Names that a person wrote wrongly: which of the known ones was meant."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable

#: characters of the longest text that may be a name, and is shown whole
_LONGEST = 100
#: likeness (`difflib`) from which a name is a misspelt one: a letter or two of `envelope`
_MISSPELT = 0.8


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """The nearest of the known names, as the end of a message: ": did you mean 'left'?".

    Args:
        name: what was written.
        known: the names that there are.

    Returns:
        The text; empty if no name is near.
    """
    import difflib  # noqa: PLC0415 - for errors alone

    if not isinstance(name, str) or len(name) > _LONGEST:
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


class MisspeltRefused:
    """Base of classes on which nothing is set by a misspelt name of a property.

    Python would otherwise take such a name silently, and the property would stay as it was. All
    other names are free for what a program keeps with the object, also one with the property's name
    as one of its words: `my_envelope`.
    """

    __slots__ = ()

    if not TYPE_CHECKING:  # a type checker would otherwise accept every name

        def __setattr__(self, name: str, value: Any) -> None:
            if not name.startswith("_") and not hasattr(type(self), name):
                _refuse_misspelt(self, name)
            object.__setattr__(self, name, value)


def _refuse_misspelt(one: object, name: str) -> None:
    import difflib  # noqa: PLC0415 - for names that a program sets

    words = name.casefold().split("_")
    for kind in type(one).__mro__:
        for known, found in vars(kind).items():
            if not isinstance(found, property) or found.fset is None:
                continue
            own = known in words and any(word not in ("", known) for word in words)
            if not own and difflib.get_close_matches("".join(words), [known], cutoff=_MISSPELT):
                raise AttributeError(
                    f"a {type(one).__name__} has no {name!r}: did you mean {known!r}? Nothing was "
                    f"set. For something of your own, take a name that is less like {known!r}"
                )
