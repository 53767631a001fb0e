"""Carries out a page: saves its files, and types its commands, in their order.

    python -m pages.tutorial WHEEL     the tutorial, in a fresh environment made from the wheel

`.ci/tutorial` builds the wheel and runs this. It needs Python's own library alone.
"""

from __future__ import annotations

import json
import os
import re
import sys
import tempfile
import time
from pathlib import Path

from pages.blocks import FILES, PYTHON, Page, pages
from pages.session import CommandFailed, Session, commands

__all__ = ["carry_out"]

#: the title of a terminal whose command goes on while the next block is typed
BESIDE = "third terminal"
FETCHED = {"PIP_NO_INDEX", "PIP_FIND_LINKS"}


def carry_out(page: Page, session: Session) -> int:
    """Do what a page says.

    Args:
        page: one session.
        session: where.

    Returns:
        How many commands were run.
    """
    run = 0
    for block in page.blocks:
        if block.why_not:
            continue
        if block.language in PYTHON | FILES:
            session.write(block.title, block.code)
            continue
        for command in commands(block.code, block.language):
            run += 1
            if block.title == BESIDE:
                session.begin(command)
                wait_for_moving(session, True)
            else:
                session.run(command)
        if "kill" in block.code or "crash" in block.code or "aioduco stop" in block.code:
            wait_for_moving(session, False)
    session.wait()
    return run


def wait_for_moving(session: Session, moving: bool) -> None:
    """Ask until the arm moves, or stands: what is typed next is meant for then."""
    until = time.monotonic() + 120.0
    while time.monotonic() < until:
        answer = session.run("aioduco status --json", quiet=True)
        if json.loads(answer.splitlines()[-1])["moving"] is moving:
            return
    raise CommandFailed(f"the arm {'does not move' if moving else 'moves on'}")


def main(wheel: str) -> None:
    """Run the tutorial from a wheel, and print what is typed and what comes of it."""
    (page,) = [page for page in pages() if page.path == "docs/tutorial.md"]
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        environment = {
            "PATH": f"{folder}/.venv/bin{os.pathsep}{os.environ['PATH']}",
            "HOME": str(folder),
            "XDG_CONFIG_HOME": str(folder / ".config"),
            "PIP_DISABLE_PIP_VERSION_CHECK": "1",
            "MPLBACKEND": "Agg",
            "NO_COLOR": "1",
            # where pip finds what it needs, if that was fetched beforehand
            **{name: value for name, value in os.environ.items() if name in FETCHED},
        }
        # In a clone it is `.[extras]`; here it is the same of the wheel.
        replaced = {"'.[": f"'{Path(wheel).resolve()}[", "pip install ": "pip install -q "}
        with Session(folder, environment, replaced, echo=True) as session:
            run = carry_out(page, session)
            found = session.run("python -c 'import aioduco; print(aioduco.__file__)'", quiet=True)
            if not re.match(rf"{folder}/\.venv/", found):
                raise CommandFailed(f"not the wheel's: {found}")
    print(f"{run} commands of {page.path}, in {time.monotonic() - begin:.0f} s: all of them work")  # noqa: T201


if __name__ == "__main__":
    main(sys.argv[1])
