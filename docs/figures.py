"""Write the tables of `docs/benchmarks.md` from `benchmarks/results/*.json`.

    python docs/figures.py            write the page
    python docs/figures.py --check    compare the whole text with what is committed

A results file is one JSON object. `title`, `command` and `machine` are shown above its tables, and
`notes` (a text or a list of texts) below them. Each other key whose value is a list of objects
becomes a table: one row per object, one column per key of the first. Numbers are shown with three
significant digits; the exact ones stay in the file.
"""

from __future__ import annotations

import argparse
import difflib
import json
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
PAGE = HERE / "benchmarks.md"
RESULTS = HERE.parent / "benchmarks" / "results"
BEGIN = "<!-- figures:begin -->"
END = "<!-- figures:end -->"


def cell(value: Any) -> str:
    """One value as a table shows it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}"
    if isinstance(value, float):
        return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"
    return str(value).replace("|", "\\|")


def heading(key: str) -> str:
    """A key as the head of a column: underscores are spaces, a unit stands in brackets."""
    words = key.split("_")
    units = {"us": "µs", "ms": "ms", "s": "s", "hz": "Hz", "rad": "rad", "percent": "%"}
    if len(words) > 1 and words[-1] in units:
        return f"{' '.join(words[:-1])} [{units[words[-1]]}]"
    return " ".join(words)


def table(rows: list[dict[str, Any]]) -> list[str]:
    """A Markdown table; the first column is text, the others are numbers to the right."""
    keys = list(rows[0])
    lines = [
        "| " + " | ".join(heading(key) for key in keys) + " |",
        "|---|" + "---:|" * (len(keys) - 1),
    ]
    lines += ["| " + " | ".join(cell(row.get(key, "")) for key in keys) + " |" for row in rows]
    return lines


def section(path: Path) -> list[str]:
    """The text for one results file."""
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    lines = [f"## {data.get('title', path.stem.replace('_', ' ').capitalize())}", ""]
    if "command" in data:
        lines += [f"`{data['command']}`", ""]
    if "machine" in data:
        machine = data["machine"]
        if isinstance(machine, dict):
            machine = ", ".join(str(value) for value in machine.values())
        lines += [f"Machine: {machine}.", ""]
    for key, value in data.items():
        if isinstance(value, list) and value and all(isinstance(row, dict) for row in value):
            lines += [f"### {heading(key).capitalize()}", "", *table(value), ""]
    notes = data.get("notes", [])
    for note in [notes] if isinstance(notes, str) else notes:
        lines += [note, ""]
    return lines


def page() -> str:
    """The whole text of the page, as it should be."""
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    lines = [line for path in sorted(RESULTS.glob("*.json")) for line in section(path)]
    body = "\n".join(lines).strip()
    return f"{before}{BEGIN}\n\n{body}\n\n{END}{after}"


def main() -> int:
    """Write the page, or compare it."""
    parser = argparse.ArgumentParser(description="the figures of docs/benchmarks.md")
    parser.add_argument("--check", action="store_true", help="compare, change nothing")
    check: bool = parser.parse_args().check
    wanted, found = page(), PAGE.read_text(encoding="utf-8")
    if not check:
        PAGE.write_text(wanted, encoding="utf-8")
        return 0
    if wanted == found:
        return 0
    names = ("docs/benchmarks.md", "made from benchmarks/results/*.json")
    sys.stdout.writelines(
        difflib.unified_diff(
            found.splitlines(keepends=True), wanted.splitlines(keepends=True), *names
        )
    )
    return 1


if __name__ == "__main__":
    sys.exit(main())
