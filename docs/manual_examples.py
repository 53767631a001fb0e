"""Write `docs/guides/manual-examples.md`: every example that the manual prints, in three dialects.

    python docs/manual_examples.py            write the page
    python docs/manual_examples.py --check    fail if the page is out of date

The examples are functions of the files in `examples/manual`; their docstrings begin with the
section of the manual and the number of the example in it.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
import textwrap
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = ROOT / "examples" / "manual"
PAGE = ROOT / "docs" / "guides" / "manual-examples.md"

#: groups in the manual's order, with what there is to know of each
GROUPS = {
    "project": (
        "1.3.4 Programs (脚本控制)",
        "The manual's functions fill a parameter; these return.",
    ),
    "serial": (
        "1.3.6 RS-485 (can 及 485 总线)",
        """Bytes are signed on the wire. `aioduco` gives `bytes`, and takes them or numbers from 0
        to 255; the vendor's class takes 255 and −1 as the same byte, and gives signed ones. A write
        that fails raises in `aioduco`; the vendor's class returns False.""",
    ),
    "modbus": (
        "1.3.9 Modbus",
        """The manual's examples call registers of unit 1 and coils of unit 2 by one name. A signal
        is one of both: the files define it anew between them, by functions that are on the wire,
        and not in the manual. `aioduco` counts what is written by itself.""",
    ),
    "realtime": (
        "1.3.15 Realtime control (实时控制函数)",
        """The manual sends a point, sleeps for a millisecond, and hopes. Here the queue is kept at
        a depth. In a program of your own, use [`robot.realtime.stream`](../streams.md), which does
        this from a process of its own.""",
    ),
}
DIALECTS = {"async": "aioduco", "sync": "aioduco.sync", "compat": "aioduco.compat"}

HEAD = """# The manual's examples

<!-- examples, not run: functions of examples/manual, which tests/manual runs whole -->

Every example of code that manual 3.8 prints in its list of functions, in three dialects: by
`aioduco`, by `aioduco.sync`, and by the vendor's class in `aioduco.compat`. Which one is for whom,
and how a program is brought over, says [From the vendor's SDK](from-the-vendor-sdk.md).

The functions below stand in the files of `examples/manual`, which are run as they are:
`python examples/manual/serial_sync.py` on a simulated controller, with an address behind it on
yours. Tests run each of them on the simulated controller, and check what it gives.
Written by `docs/manual_examples.py`.
"""


class Example(NamedTuple):
    """One example in one dialect: its number, what it does, its code."""

    number: str
    about: str
    code: str


def examples(path: Path) -> list[Example]:
    """The examples in a file, in its order."""
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    found = []
    for node in ast.parse(text).body:
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        match = re.match(r"(1\.3\.\d+-\d+): (.+)", ast.get_docstring(node) or "")
        if match is None:
            continue
        body = lines[node.body[1].lineno - 1 : node.end_lineno]
        code = re.sub(r"  # noqa: .*", "", textwrap.dedent("\n".join(body)))
        found.append(Example(match[1], match[2], re.sub(r"^return ", "", code, flags=re.MULTILINE)))
    return found


def numbers(dialect: str) -> list[str]:
    """The numbers of all examples that a dialect has, in the page's order."""
    return [one.number for group in GROUPS for one in examples(EXAMPLES / f"{group}_{dialect}.py")]


def page() -> str:
    """The whole text of the page."""
    parts = [HEAD]
    for group, (title, about) in GROUPS.items():
        files = {dialect: EXAMPLES / f"{group}_{dialect}.py" for dialect in DIALECTS}
        parts.append(f"\n## {title}\n\n{textwrap.fill(' '.join(about.split()), 100)}\n")
        for each in zip(*(examples(path) for path in files.values()), strict=True):
            first = each[0]
            if len({one.number for one in each}) != 1:
                raise SystemExit(f"{group}: the files have not the same examples: {each}")
            parts.append(
                f"\n### Example {first.number}\n\n{first.about[0].upper()}{first.about[1:]}"
            )
            parts.append('\n\n<div class="grid" markdown>\n')
            for title_, one in zip(DIALECTS.values(), each, strict=True):
                parts.append(f'\n```python title="{title_}"\n{one.code}\n```\n')
            parts.append("\n</div>\n")
    return "".join(parts)


def main() -> int:
    """Write the page, or compare it."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--check", action="store_true", help="fail if the page is out of date")
    text = page()
    if not parser.parse_args().check:
        PAGE.write_text(text, encoding="utf-8")
        return 0
    if PAGE.exists() and PAGE.read_text(encoding="utf-8") == text:
        sys.stdout.write("manual-examples.md is up to date\n")
        return 0
    sys.stdout.write("manual-examples.md is out of date: run python docs/manual_examples.py\n")
    return 1


if __name__ == "__main__":
    sys.exit(main())
