"""Tell whether the program handles an error that a call is about to raise, from its source.

A preflight goes on past a motion that cannot be carried out. A program that handles the error must
see it, as with a real arm. So the lines that wait for a call are compared with the `try` blocks
around them. Where that is not certain, the error counts as handled.
"""

from __future__ import annotations

import ast
import builtins
import linecache
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping


#: context managers that end an error
_SUPPRESSING = frozenset({"suppress", "raises"})
#: attributes by which a program asks a task for its error instead of awaiting it
_ASKING = frozenset({"exception", "outcome", "add_done_callback"})


class WaitingLine(NamedTuple):
    """A line that waits for a call, and gets its error.

    Attributes:
        file: path of the file.
        line: number of the line.
        names: global names there.
        library: whether it belongs to an installed library, not to the program.
        later: whether the error comes to another line of the file: that which waits for the task.
    """

    file: str
    line: int
    names: Mapping[str, Any]
    library: bool = False
    later: bool = False


class _Handler(NamedTuple):
    """Errors that are handled between two lines; None for all of them."""

    first: int
    last: int
    kinds: ast.expr | None
    raises: bool


class _Handlers(NamedTuple):
    """The handlers of a file, and whether it asks tasks for their errors."""

    all: tuple[_Handler, ...]
    asks: bool


def handled(waiting: Iterable[WaitingLine], kind: type[BaseException]) -> bool:
    """Whether the program handles an error of a kind.

    Args:
        waiting: the lines that wait for the call.
        kind: class of the error.
    """
    return any(_handled_at(line, kind) for line in waiting)


def _handled_at(at: WaitingLine, kind: type[BaseException]) -> bool:
    handlers = _handlers_of(at.file)
    if at.later and handlers.asks:
        return True
    return any(
        (at.later or each.first <= at.line <= each.last)
        # a library that raises the error again, such as one for command lines, does not handle it
        and not (at.library and each.raises)
        and _matches(each.kinds, at.names, kind)
        for each in handlers.all
    )


@cache
def _handlers_of(file: str) -> _Handlers:
    """Read a file's handlers; a file that cannot be read has none."""
    try:
        tree = ast.parse("".join(linecache.getlines(file)))
    except (SyntaxError, ValueError):
        return _Handlers((), asks=False)
    nodes = list(ast.walk(tree))
    found = tuple(each for node in nodes for each in _of_node(node))
    return _Handlers(found, asks=any(map(_asks, nodes)))


def _of_node(node: ast.AST) -> Iterator[_Handler]:
    match node:
        case ast.Try() | ast.TryStar():
            for handler in node.handlers:
                raises = isinstance(handler.body[-1], ast.Raise)
                yield _Handler(*_lines(node.body), handler.type, raises)
        case ast.With() | ast.AsyncWith():
            for item in node.items:
                made = item.context_expr
                if isinstance(made, ast.Call) and _name(made.func) in _SUPPRESSING:
                    kinds = ast.Tuple(elts=made.args, ctx=ast.Load())
                    yield _Handler(*_lines(node.body), kinds, raises=False)


def _lines(body: list[ast.stmt]) -> tuple[int, int]:
    return body[0].lineno, body[-1].end_lineno or body[-1].lineno


def _asks(node: ast.AST) -> bool:
    """Whether an expression asks a task for its end, without raising its error."""
    match node:
        case ast.keyword(arg="return_exceptions"):
            return True
        case ast.Await(value=ast.Call(func=ast.Attribute(attr="wait") as called)):
            return _name(called.value) not in ("asyncio", "anyio")
        case ast.Attribute():
            return node.attr in _ASKING
    return False


def _name(node: ast.expr) -> str:
    """The last part of a name such as `contextlib.suppress`."""
    match node:
        case ast.Name():
            return node.id
        case ast.Attribute():
            return node.attr
    return ""


def _matches(kinds: ast.expr | None, names: Mapping[str, Any], kind: type[BaseException]) -> bool:
    match kinds:
        case ast.Tuple():
            return any(_matches(each, names, kind) for each in kinds.elts)
        case ast.Name() | ast.Attribute():
            found = _found(kinds, names)
            return not isinstance(found, type) or issubclass(kind, found)
    return True  # all errors, or an expression whose value is not known


def _found(node: ast.expr, names: Mapping[str, Any]) -> Any:
    """The value of a name, without running any of the program; None if it is not known."""
    match node:
        case ast.Name():
            return names.get(node.id, getattr(builtins, node.id, None))
        case ast.Attribute():
            owner = _found(node.value, names)
            return vars(owner).get(node.attr) if hasattr(owner, "__dict__") else None
    return None
