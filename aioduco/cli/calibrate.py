"""`aioduco calibrate`: estimate what a simulator needs to know of an arm, from recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aioduco.cli import extras
from aioduco.cli.exit_codes import ended_by_errors, writing
from aioduco.cli.options import require_writable
from aioduco.cli.output import say


def calibrate(
    recordings: Annotated[list[Path], typer.Argument(exists=True, dir_okay=False)],
    output: Annotated[Path, typer.Option("--output", "-o")] = Path("arm.toml"),
    model: str | None = None,
) -> None:
    """Make a profile of an arm from recordings of it, for `aioduco sim --profile`. Nothing moves.

    Every value has an interval that holds it in 95 of 100 cases. What the recordings do not show is
    left out, and said.

    aioduco check 192.168.1.10 --motions run.mcap

    aioduco calibrate run.mcap -o arm.toml

    aioduco sim --profile arm.toml

    Exit codes: 0 written; 1 the recordings do not fit the arm, or show nothing; 2 wrong options.

    Args:
        recordings: Recordings of one arm, from `aioduco check HOST --motions`.
        output: Profile to write. An existing one is replaced.
        model: The arm. Default: what the controller reported.
    """
    require_writable("--output", output, *recordings)
    extras.need("record", "calibrate")
    if model is not None:
        extras.arm(model)
    from aioduco.sim.calibration import calibrate as estimate  # noqa: PLC0415 - for this command

    with ended_by_errors():
        found = estimate(recordings, model=model)
    say(str(found))
    with writing(output):
        found.profile.save(output)
    say(f"written to {output}")
