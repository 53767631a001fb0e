"""`aioduco init`: a project with a cell, a supervised program, tests and a workflow."""

from __future__ import annotations

import math
import shlex
import shutil
from importlib import resources
from pathlib import Path  # noqa: TC003 - typer evaluates the annotations
from string import Template
from typing import Final

from aioduco.cli import extras
from aioduco.cli.exit_codes import fail
from aioduco.cli.options import wrong_option
from aioduco.cli.output import say
from aioduco.models.address import parse_address
from aioduco.models.toml_files import quoted

#: the files of a project, as texts with $ before what is filled in: in the folder `project`
_FILES: Final = (
    "cell.toml", "main.py", "test_main.py", "pytest.ini", "requirements.txt",
    ".github/workflows/checks.yml", "README.md",
)  # fmt: skip


def init(
    folder: Path,
    model: str = "gcr5_910",
    host: str = "127.0.0.1",
) -> None:
    """Write a project: a cell, a supervised program, tests on the simulator, a workflow.

    It runs as it is: pytest, then aioduco preflight main.py --cell cell.toml. Nothing is sent to an
    arm.

    aioduco init demo

    Exit codes: 0 written; 1 it cannot be written; 2 wrong options.

    Args:
        folder: Folder of the project; it must not exist yet.
        model: The arm.
        host: Address of its controller; that of a simulator if left out.
    """
    arm = extras.arm(model)
    from aioduco.models.pose import Joints, Pose  # noqa: PLC0415 - for this command alone

    with wrong_option():
        parse_address(host, name="--host")
    # Points that every arm reaches: below where its flange is in the first configuration, and
    # farther out, as the table is, so that the arm is not folded over it.
    ready = Pose.from_matrix(arm.fkine(Joints.deg(20, -10, 100, 0, -90, 0).array))
    height = round(ready.z - 0.08, 2)
    numbers = {
        "x": round(1.2 * ready.x * 1e3),
        "y": round(130 * arm.reach),
        "z": round(height * 1e3),
        "turn": round(math.degrees(ready.rz)),
        "plane_z": round(height - 0.05, 3),
        "table_x": round(1.4 * ready.x, 3),
        "table_length": round(ready.x, 3),
        "table_z": round(height - 0.11, 3),
    }
    texts = resources.files("aioduco.cli") / "project"
    words = {"name": folder.name, "model": model, "host": quoted(host)}
    try:
        folder.mkdir(parents=True)
    except FileExistsError:
        fail(f"{folder} exists already; nothing was written")
    except OSError as error:
        fail(f"{folder} cannot be written: {error.strerror or error}")
    try:
        for name in _FILES:
            path = folder / name
            text = Template((texts / f"{path.name}.txt").read_text("utf-8"))
            path.parent.mkdir(parents=True, exist_ok=True)
            said = text.substitute(numbers, **words)
            # the name of a folder may be no text
            path.write_text(said, encoding="utf-8", errors="backslashreplace")
    except OSError as error:
        shutil.rmtree(folder, ignore_errors=True)  # a part of a project would be taken for a whole
        fail(f"{folder} cannot be written: {error.strerror or error}; nothing of it was left")
    say(f"written to {folder}: {', '.join(_FILES)}")
    inside = f"cd {shlex.quote(str(folder))}"
    say(f"try it: {inside} && pytest && aioduco preflight main.py --cell cell.toml")
