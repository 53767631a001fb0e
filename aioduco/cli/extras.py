"""What the commands check before they begin: installed extras, names of arms."""

from __future__ import annotations

import importlib.util

import typer

__all__ = ["check_model", "need"]

_BRINGS = {"sim": ("mujoco", "ruckig"), "cli": ("matplotlib",)}


def need(extra: str) -> None:
    """End with a message that says what to install, if an extra is missing."""
    missing = [name for name in _BRINGS[extra] if importlib.util.find_spec(name) is None]
    if missing:
        typer.echo(f"this needs {' and '.join(missing)}: pip install 'aioduco[sim,cli]'", err=True)
        raise typer.Exit(1)


def check_model(model: str) -> None:
    """Refuse the name of an arm that is not known, and list the known ones."""
    from aioduco.kinematics import models  # noqa: PLC0415 - not every command needs it

    if model not in models():
        raise typer.BadParameter(
            f"no arm {model!r}; known are {', '.join(models())}", param_hint="--model"
        )
