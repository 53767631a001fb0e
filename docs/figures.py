"""Write the tables of `docs/benchmarks.md`, and the figures in other pages, from the results.

    python docs/figures.py            write the pages
    python docs/figures.py --check    compare the whole text with what is committed

The results are `benchmarks/results/*.json`. In the other pages a comment behind a figure names it:

    49 µs<!-- figure: streaming / pacing / busy / process / late_p99_us -->

A results file holds the `machine` that it was measured on, single figures, and tables: objects
whose values are objects of figures, one row each, or lists of such objects. Tables may be nested in
further objects, which become headings. Numbers are shown with three significant digits; the exact
ones stay in the file.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import json
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
PAGE = HERE / "benchmarks.md"
BENCHMARKS = ROOT / "benchmarks"
BEGIN = "<!-- figures:begin -->"
END = "<!-- figures:end -->"

UNITS = {
    "us": "µs", "ms": "ms", "s": "s", "hz": "Hz", "rad": "rad", "mrad": "mrad", "m": "m",
    "percent": "%",
}  # fmt: skip

#: a figure in the text of a page, its unit, and the results file and keys that it is from
NAMED = re.compile(r"[\d.,]+ (\S+)(?=<!-- figure: (.+?) -->)")
#: units of time in seconds
SECONDS = {"µs": 1e-6, "ms": 1e-3, "s": 1.0}


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
    """A key in words: underscores are spaces, and a unit at its end stands in brackets."""
    first, _, last = key.rpartition("_")
    if first and last in UNITS:
        return f"{first.replace('_', ' ')} [{UNITS[last]}]"
    return key.replace("_", " ")


def rows_of(value: Any) -> list[dict[str, Any]] | None:
    """The rows of a table, if that is what the value is."""
    if isinstance(value, dict):
        value = [{"": name} | row for name, row in value.items() if isinstance(row, dict)]
    if not isinstance(value, list) or not value:
        return None
    if not all(isinstance(row, dict) for row in value):
        return None
    plain = all(not isinstance(figure, dict | list) for row in value for figure in row.values())
    return value if plain else None


def table(rows: list[dict[str, Any]]) -> list[str]:
    """A Markdown table; the first column is text, the others are numbers to the right."""
    keys = list(dict.fromkeys(key for row in rows for key in row))
    return [
        "| " + " | ".join(heading(key) for key in keys) + " |",
        "|---|" + "---:|" * (len(keys) - 1),
        *("| " + " | ".join(cell(row.get(key, "")) for key in keys) + " |" for row in rows),
    ]


def blocks(value: dict[str, Any], level: int) -> Iterator[str]:
    """The single figures of an object, then its tables under their headings."""
    single = {key: one for key, one in value.items() if not isinstance(one, dict | list)}
    if single:
        yield ", ".join(f"{heading(key)}: {cell(one)}" for key, one in single.items()) + "."
    for key, one in value.items():
        if (rows := rows_of(one)) is not None:
            yield "#" * level + f" {key}"
            yield "\n".join(table(rows))
        elif isinstance(one, dict):
            yield "#" * level + f" {key}"
            yield from blocks(one, level + 1)


def section(path: Path) -> Iterator[str]:
    """The text for one results file."""
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    machine: dict[str, Any] = data.pop("machine", {})
    packages = machine.pop("packages", {})
    script = BENCHMARKS / f"{path.stem}.py"
    yield f"## {path.stem.replace('_', ' ').capitalize()}"
    if script.exists():
        module = ast.parse(script.read_text(encoding="utf-8"))
        yield (ast.get_docstring(module) or "").split("\n")[0]
    # what no script of its own measures says by which command it was measured
    yield f"`{data.pop('command', f'python benchmarks/{script.name} --save')}`"
    yield from blocks(data, 3)
    known = [f"{key} {value}" for key, value in machine.items()]
    known += [f"{name} {version}" for name, version in packages.items()]
    if known:
        yield f"Measured on: {', '.join(known)}."


def page() -> str:
    """The whole text of the page, as it should be."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    after = rest.partition(END)[2]
    files = sorted((BENCHMARKS / "results").glob("*.json"))
    body = [block for path in files for block in section(path)]
    return "\n\n".join([before + BEGIN, *body, END + after])


def named(match: re.Match[str]) -> str:
    """A figure and its unit, with two significant digits."""
    unit, path = match[1], match[2]
    name, *keys = path.split(" / ")
    value: Any = json.loads((BENCHMARKS / "results" / f"{name}.json").read_text(encoding="utf-8"))
    for key in keys:
        value = value[key]
    measured = UNITS.get(keys[-1].rpartition("_")[2], "")
    if measured != unit:
        value *= SECONDS[measured] / SECONDS[unit]
    return f"{float(f'{value:.2g}'):,g} {unit}"


def pages() -> Iterator[tuple[Path, str]]:
    """The pages with figures, each with its text as it should be."""
    yield PAGE, page()
    for path in (*ROOT.glob("*.md"), *HERE.rglob("*.md")):
        if path != PAGE:
            yield path, NAMED.sub(named, path.read_text(encoding="utf-8"))


def main() -> int:
    """Write the pages, or compare them."""
    parser = argparse.ArgumentParser(description="the figures of the pages")
    parser.add_argument("--check", action="store_true", help="compare, change nothing")
    check: bool = parser.parse_args().check
    differ = False
    for path, wanted in pages():
        found = path.read_text(encoding="utf-8")
        if wanted == found:
            continue
        differ = True
        if not check:
            path.write_text(wanted, encoding="utf-8")
            continue
        names = (str(path.relative_to(ROOT)), "made from benchmarks/results/*.json")
        old, new = found.splitlines(keepends=True), wanted.splitlines(keepends=True)
        sys.stdout.writelines(difflib.unified_diff(old, new, *names))
    return int(check and differ)


if __name__ == "__main__":
    sys.exit(main())
