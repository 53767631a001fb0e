"""The README's program and commands: what a newcomer copies must work as it stands."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from aioduco.sim import Simulator

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
CHINESE = (ROOT / "README.zh-CN.md").read_text(encoding="utf-8")


def program(text: str) -> str:
    (found,) = re.findall(r"^```python\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL)
    return str(found)


def command(text: str, name: str) -> str:
    pattern = rf"^<!-- command: {name} -->\n```sh\n(.*?)\n```"
    (found,) = re.findall(pattern, text, flags=re.MULTILINE | re.DOTALL)
    return str(found)


def test_program_runs_as_it_stands(tmp_path: Path) -> None:
    """Only the address is another one: that of a simulated controller."""
    source = program(README)
    with Simulator(speed=10) as sim:
        there = source.replace('"192.168.1.10"', f'"{sim.host}", {sim.port}')
        assert there != source
        file = tmp_path / "program.py"
        file.write_text(there, encoding="utf-8")
        done = subprocess.run(
            [sys.executable, "-W", "error", str(file)],
            check=False,
            capture_output=True,
            text=True,
            timeout=50,
        )
        assert (done.returncode, done.stderr) == (0, "")
        first, last = done.stdout.splitlines()
        assert re.fullmatch(r"task \d+ runs, the program goes on", first)
        assert last == "Outcome.FINISHED"
        assert not sim.moving


def test_program_is_short() -> None:
    assert len([line for line in program(README).splitlines() if line.strip()]) <= 12


@pytest.mark.parametrize("name", ["run", "test"])
def test_each_command_is_one_line_that_makes_its_own_environment(name: str) -> None:
    line = command(README, name)
    assert "\n" not in line
    first, *rest = (shlex.split(part) for part in line.split("&&"))
    assert first == ["python3", "-m", "venv", ".venv"]
    assert all(words[0].startswith(".venv/bin/") for words in rest)


def test_quick_start_has_the_same_program() -> None:
    assert program(README) in (ROOT / "docs" / "quickstart.md").read_text(encoding="utf-8")


def test_chinese_readme_has_the_same_program_and_commands() -> None:
    assert program(CHINESE) == program(README)
    for name in ("run", "test"):
        assert command(CHINESE, name) == command(README, name)


@pytest.mark.parametrize("text", [README, CHINESE], ids=["en", "zh"])
def test_links_lead_somewhere(text: str) -> None:
    targets = [link for link in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in link]
    assert targets
    assert [link for link in targets if not (ROOT / link).exists()] == []


def test_pictures_are_small() -> None:
    begins = {".png": b"\x89PNG\r\n\x1a\n", ".gif": b"GIF89a"}
    pictures = [ROOT / picture for picture in re.findall(r"!\[[^]]*\]\(([^)]+)\)", README)]
    assert [picture.suffix for picture in pictures] == [".gif", ".png"]
    for picture in pictures:
        data = picture.read_bytes()
        assert data.startswith(begins[picture.suffix])
        assert len(data) < 400_000
