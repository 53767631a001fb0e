"""The page about scenes, collisions and pictures tells what the simulator does."""

from __future__ import annotations

import re
from pathlib import Path

from aioduco.sim.controller.monitoring import LEVELS

PAGE = Path(__file__).parents[2] / "docs" / "scene.md"


def test_its_shares_are_those_of_the_levels() -> None:
    told = re.search(r"\| share \| off \|(.*)\|", PAGE.read_text("utf-8"))
    assert told is not None
    shares = [float(share.strip(" %")) / 100 for share in told[1].split("|")]
    assert shares == list(LEVELS.values())[1:]
