"""Checks before a command begins: installed extras, names of arms."""

from __future__ import annotations

import importlib.util
from typing import TYPE_CHECKING

import typer

from aioduco.cli.exit_codes import fail
from aioduco.errors import MissingExtra
from aioduco.models.similar import did_you_mean

if TYPE_CHECKING:
    from aioduco.kinematics import Arm


_BRINGS = {
    "sim": ("mujoco",),
    "plot": ("matplotlib", "PIL"),
    "plan": ("ompl",),
    "calibrate": ("scipy",),
    "sweep": ("distributed",),
    "record": ("foxglove", "zstandard"),
    "parquet": ("pyarrow",),
    "fleet": ("zenoh",),
    "panel": ("viser",),
}


def need(*extras: str) -> None:
    """End with a message that says what to install, if a package of the extras is missing.

    Args:
        extras: names of extras: "sim", "plot", "plan", "calibrate", "sweep", "record", "parquet",
            "fleet", "panel".
    """
    missing = {
        extra: [name for name in _BRINGS[extra] if importlib.util.find_spec(name) is None]
        for extra in extras
    }
    names = [name for absent in missing.values() for name in absent]
    if names:
        install = ",".join(["cli", *(extra for extra, absent in missing.items() if absent)])
        fail(str(MissingExtra("this", " and ".join(names), install)))


def arm(model: str) -> Arm:
    """Return the arm with a name; refuse an unknown name, and list the known ones."""
    from aioduco.kinematics import arm as arm_of  # noqa: PLC0415 - NumPy is not for all commands
    from aioduco.kinematics import models  # noqa: PLC0415

    if model not in models():
        raise typer.BadParameter(
            f"no arm is named {model!r}{did_you_mean(model, models())}; there are "
            f"{', '.join(models())}",
            param_hint="--model",
        )
    return arm_of(model)
