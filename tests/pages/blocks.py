"""The code blocks of the README files and of the pages, with what the pages say of running them.

A comment before a block says how it is run; without one it is run as it stands. Readers do not see
it:

    <!-- example, after:                 what defines names that the block uses; not printed
    policy = str.upper
    -->
    <!-- example, not run: REASON -->    what cannot be run here, and why
    <!-- examples, one program -->       on a page: each block goes on where the one before ended
    <!-- examples, one session -->       on a page: files and commands of one folder, in their order
    <!-- examples, not run: REASON -->   on a page: none of its blocks

What a block of Python comes after may define `prepare(sim)`, which is called first: `enabled`
brings the arm up, whose joints are then `here`. `enough(n)` ends an endless loop at its n-th call.
"""

from __future__ import annotations

import re
import textwrap
from dataclasses import dataclass
from pathlib import Path

__all__ = ["ROOT", "Block", "Page", "pages"]

ROOT = Path(__file__).resolve().parents[2]
#: languages that are run, by the names after a fence
PYTHON, SHELL = {"python", "pycon"}, {"sh", "console", "bash", "shell"}
#: languages of files that a page has its reader save, under the title of the block
FILES = {"toml", "yaml"}

_FENCE = re.compile(
    r"^(?P<indent>[ ]*)```(?P<language>\w+)(?P<options>[^\n]*)\n(?P<code>.*?)^(?P=indent)```[ ]*$",
    re.MULTILINE | re.DOTALL,
)
_BEFORE = re.compile(
    r"<!-- (?:example, (?P<how>after|not run):\s*(?P<what>(?:(?!-->).)*?)"
    r"|command: (?P<command>\w+))\s*-->\s*\Z",
    re.DOTALL,
)
_WHOLE = re.compile(
    r"<!-- examples, (?P<how>one program|one session|not run)(?:: (?P<what>.*?))?\s*-->", re.DOTALL
)


@dataclass(frozen=True)
class Block:
    """A block of code.

    Attributes:
        page: path of its page from the root of the tree.
        number: which block of its page it is, from 0.
        language: what its fence says: "python", "sh", …
        title: the title that is printed over it; empty without one.
        code: what is printed.
        after: what is run before it, and not printed.
        why_not: why it is not run; empty if it is.
    """

    page: str
    number: int
    language: str
    title: str
    code: str
    after: str = ""
    why_not: str = ""

    @property
    def name(self) -> str:
        """Its name among the cases of a test."""
        return f"{self.page.removeprefix('docs/').removesuffix('.md')}-{self.number}"


@dataclass(frozen=True)
class Page:
    """A page with its blocks of Python and of commands.

    Attributes:
        path: from the root of the tree.
        blocks: those that are Python or commands, in their order.
        whole: "one program", "one session", or empty for blocks that are run one by one.
        why_not: why none of them is run; empty if they are.
    """

    path: str
    blocks: tuple[Block, ...]
    whole: str = ""
    why_not: str = ""


def pages() -> list[Page]:
    """All pages of the tree that have a block of Python or of commands."""
    files = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
    found = (page_of(file.relative_to(ROOT).as_posix(), file.read_text("utf-8")) for file in files)
    return [page for page in found if page.blocks]


def page_of(path: str, text: str) -> Page:
    """A page's blocks of Python and of commands."""
    whole = _WHOLE.search(text)
    why = " ".join((whole["what"] or "").split()) if whole and whole["how"] == "not run" else ""
    blocks = []
    for number, fence in enumerate(_FENCE.finditer(text)):
        title = re.search(r'title="([^"]*)"', fence["options"])
        if fence["language"] not in PYTHON | SHELL | (FILES if title else set()):
            continue
        before = _BEFORE.search(text, 0, fence.start())
        after, why_not = "", why
        if before is not None and before["command"]:
            why_not = f"a command of the README: .ci/run runs it as {before['command']}"
        elif before is not None and before["how"] == "not run":
            why_not = " ".join(before["what"].split())
        elif before is not None:
            after = before["what"]
        code = textwrap.dedent(fence["code"])
        blocks.append(
            Block(path, number, fence["language"], title[1] if title else "", code, after, why_not)
        )
    return Page(path, tuple(blocks), "" if whole is None or why else whole["how"], why)
