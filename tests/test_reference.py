"""The examples of the reference pages run as they are printed, against the simulator."""

from __future__ import annotations

import ast
import builtins
import inspect
import re
import types
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import aioduco
from aioduco.api.section import Section
from aioduco.sim import Simulator
from aioduco.testing import eventually_async

if TYPE_CHECKING:
    from collections.abc import Iterator

PAGES = Path(__file__).parents[1] / "docs" / "reference"
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
#: pages of sections that have another name
NAMES = {
    "kinematics": "controller_kinematics",
    "optimization": "settings",
    "log": "settings",
    "version": "system",
}
#: pages on which `robot` is not the awaited one
OTHERS = {"sync", "compat"}

EXAMPLES = [
    pytest.param(code, id=f"{page.stem}-{number}")
    for page in sorted(PAGES.glob("*.md"))
    if page.stem not in OTHERS
    for number, code in enumerate(BLOCK.findall(page.read_text("utf-8")))
]


@pytest.fixture
def sim() -> Iterator[Simulator]:
    with Simulator(speed=10) as running:
        yield running


@pytest.mark.parametrize("code", EXAMPLES)
async def test_an_example_runs(code: str, sim: Simulator) -> None:
    compiled = compile(code, "example", "exec", ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)
    async with aioduco.connect(sim.host, sim.port) as robot:
        made = types.FunctionType(compiled, {"robot": robot, "__builtins__": builtins})()
        if inspect.iscoroutine(made):
            await made
    await eventually_async(lambda: not sim.moving)


def sections() -> list[str]:
    robot = aioduco.connect("192.0.2.1")
    return [name for name, each in vars(robot).items() if isinstance(each, Section)]


@pytest.mark.parametrize("section", sections())
def test_each_section_has_a_page_with_an_example(section: str) -> None:
    text = (PAGES / f"{NAMES.get(section, section)}.md").read_text("utf-8")
    assert f"# robot.{section}" in text or f"robot.{section}" in text.splitlines()[0]
    assert any(f"robot.{section}." in block for block in BLOCK.findall(text))
