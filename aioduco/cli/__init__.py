"""The command `aioduco`: watch, move and record arms, and simulate a controller."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Final

from aioduco.cli import output

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]

#: commands that pass texts on, which may be empty
_FREE: Final = ("call", "sim-do")


def main() -> None:
    """Run the command line."""
    output.guard_streams()
    try:
        with output.ended_by_output():
            _run()
    except SystemExit as ended:
        if ended.code:
            output.drop_unwritten()
        raise


def _run() -> None:
    _refuse_empty(sys.argv[1:])
    if sys.argv[1:2] == ["stop"]:
        from aioduco.cli import stopping  # noqa: PLC0415 - for this command alone

        if plain := stopping.plain_stop(sys.argv[2:]):
            stopping.stop_at(plain.address, as_json=plain.json)
            return
    try:
        from aioduco.cli.app import app_for  # noqa: PLC0415 - what it needs is an extra
    except ModuleNotFoundError as error:
        if error.name in {"typer", "rich"}:
            needs = f"the command aioduco needs {error.name}: pip install 'aioduco[cli]'"
            raise SystemExit(needs) from None
        raise
    app_for(sys.argv[1:])()


def _refuse_empty(words: Sequence[str]) -> None:
    """End if an argument is empty: a variable that is not set must not stand for a default."""
    if words[:1] and words[0] in _FREE:
        return
    for number, word in enumerate(words, 1):
        if not word or (word.startswith("--") and word.endswith("=")):
            before = words[number - 2] if number > 1 else "aioduco"
            where = word or f"the one after {before}"
            output.say(f"an argument is empty, {where}: is a variable empty?", error=True)
            raise SystemExit(2)
