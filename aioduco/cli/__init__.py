"""The command `aioduco`: watch, move and record arms, and simulate a controller."""

from __future__ import annotations

__all__ = ["main"]


def main() -> None:
    """Run the command line."""
    try:
        from aioduco.cli.app import app  # noqa: PLC0415 - what it needs is an extra
    except ModuleNotFoundError as error:
        if error.name in {"typer", "rich"}:
            needs = f"the command aioduco needs {error.name}: pip install 'aioduco[cli]'"
            raise SystemExit(needs) from None
        raise
    app()
