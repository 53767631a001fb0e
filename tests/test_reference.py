"""Each section of the robot has a page in the reference, with an example. `pages` runs them."""

from __future__ import annotations

import re
from pathlib import Path

from for_each import for_each

import aioduco
from aioduco.api.section import Section

PAGES = Path(__file__).parents[1] / "docs" / "reference"
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
#: pages of sections that have another name
NAMES = {
    "kinematics": "controller_kinematics",
    "optimization": "settings",
    "log": "settings",
    "version": "system",
}


def sections() -> list[str]:
    robot = aioduco.connect("192.0.2.1")
    names = aioduco.Robot.__annotations__
    return [name for name in names if isinstance(getattr(robot, name), Section)]


@for_each("section", sections())
def test_each_section_has_a_page_with_an_example(section: str) -> None:
    text = (PAGES / f"{NAMES.get(section, section)}.md").read_text("utf-8")
    assert f"# robot.{section}" in text or f"robot.{section}" in text.splitlines()[0]
    assert any(f"robot.{section}." in block for block in BLOCK.findall(text))
