"""One test of a whole table, which names each row that fails."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any

import pytest

__all__ = ["for_each"]

_Test = Callable[..., Any]


def for_each(names: str, rows: Iterable[Any]) -> Callable[[_Test], _Test]:
    """Make a test of one row a test of all rows, that tries each of them.

    For rows that take far less than the milliseconds which each test of its own takes. The test's
    fixtures are made once for all of them.

    Args:
        names: the parameters that a row is given to, as `parametrize` has them.
        rows: the table.
    """
    given, table = names.replace(",", " ").split(), list(rows)

    def of_all(test: _Test) -> _Test:
        def arguments(row: Any) -> dict[str, Any]:
            return dict(zip(given, row if len(given) > 1 else (row,), strict=True))

        def tried(**fixtures: Any) -> None:
            with _told(table) as each:
                for row, of_row in each:
                    with of_row:
                        test(**fixtures, **arguments(row))

        async def awaited(**fixtures: Any) -> None:
            with _told(table) as each:
                for row, of_row in each:
                    with of_row:
                        await test(**fixtures, **arguments(row))

        made: Any = wraps(test)(awaited if inspect.iscoroutinefunction(test) else tried)
        signature = inspect.signature(test)
        left = [one for name, one in signature.parameters.items() if name not in given]
        made.__signature__ = signature.replace(parameters=left)
        return made  # type: ignore[no-any-return]

    return of_all


@contextmanager
def _told(table: list[Any]) -> Iterator[Iterator[tuple[Any, Any]]]:
    """The rows, each with a block that keeps its error; all errors are raised at the end."""
    failed: list[BaseException] = []

    @contextmanager
    def of_row(row: Any) -> Iterator[None]:
        try:
            yield
        except (Exception, pytest.fail.Exception) as exc:  # also of `pytest.raises`
            exc.add_note(f"in the row {row}")
            failed.append(exc)

    assert table, "the table is empty"
    yield ((row, of_row(row)) for row in table)
    if failed:
        raise BaseExceptionGroup(f"{len(failed)} of {len(table)} rows", failed)
