"""What is read from a file that may be another maker's, or damaged: one error for all of it."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, ParamSpec, TypeVar

from aioduco.errors import DucoError, RecordingError

if TYPE_CHECKING:
    from collections.abc import Callable


P = ParamSpec("P")
T = TypeVar("T")

#: what content raises that is not as the channel's format says
_UNREADABLE = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)


def of_any_maker(function: Callable[P, T]) -> Callable[P, T]:
    """A function that reads contents of a recording; it raises `RecordingError` if it cannot."""

    @functools.wraps(function)
    def reading(*args: P.args, **kwargs: P.kwargs) -> T:
        try:
            return function(*args, **kwargs)
        except DucoError:
            raise
        except _UNREADABLE as error:
            raise RecordingError(
                f"the recording's channels are not as aioduco writes them: {error!r:.300}"
            ) from error

    return reading
