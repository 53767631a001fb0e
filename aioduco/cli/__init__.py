"""The command `aioduco`: watch, move and record arms, and simulate a controller."""

from __future__ import annotations

import sys

from aioduco.cli import output

__all__ = ["main"]


def main() -> None:
    """Run the command line."""
    output.guard_streams()
    if sys.argv[1:2] == ["stop"]:
        from aioduco.cli import stopping  # noqa: PLC0415 - for this command alone

        if plain := stopping.plain_stop(sys.argv[2:]):
            stopping.stop_at(plain.address, as_json=plain.json)
            return
    try:
        from aioduco.cli.app import app  # noqa: PLC0415 - what it needs is an extra
    except ModuleNotFoundError as error:
        if error.name in {"typer", "rich"}:
            needs = f"the command aioduco needs {error.name}: pip install 'aioduco[cli]'"
            raise SystemExit(needs) from None
        raise
    app()
