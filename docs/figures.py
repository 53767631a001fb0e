"""Write the figures of the pages from the results of the benchmarks.

    python docs/figures.py            write the pages
    python docs/figures.py --check    compare the whole text with what is committed

The results are `benchmarks/results/*.json`. Comments in a page say which figures it shows:

    49 µs<!-- figure: streaming / pacing / busy / process / late_p99_us -->

    <!-- table: guard / stop / * / * :: p50_us; p99_us; stops :: idle -->

    <!-- measured: guard -->

A table, up to the next blank line, has a row for each object that its path leads to; `*` stands for
all keys, which name the row. The columns are keys of the rows, and one may have a heading:
`p50_us = as a median [µs]`. What follows is a regular expression, if not all rows are shown.
`measured` tells date, commit and machine. Numbers are shown with three significant digits; the
exact ones stay in the file.

A percentile is shown only if enough was measured: p99 from 100 samples on, p99.9 from 1,000. How
many there were is the nearest of `COUNTS`, in the same object or one that it is part of.
"""

from __future__ import annotations

import argparse
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
RESULTS = ROOT / "benchmarks" / "results"

UNITS = {
    "us": "µs", "ms": "ms", "s": "s", "hz": "Hz", "rad": "rad", "mrad": "mrad", "m": "m",
    "percent": "%",
}  # fmt: skip
#: units of time in seconds
SECONDS = {"µs": 1e-6, "ms": 1e-3, "s": 1.0}

#: keys that say how many samples a percentile is of; calls a second are a lower bound, since each
#: measurement lasts longer than that
COUNTS = (
    "calls", "ticks", "stops", "times", "motions", "samples", "cycles", "queries", "calls_a_second",
)  # fmt: skip
#: not enough was measured
TOO_FEW = "–"

#: a figure in the text of a page, its unit, and the results file and keys that it is from
FIGURE = re.compile(r"[\d.,]+ ([^\s<]+)(?=<!-- figure: (.+?) -->)")
TABLE = re.compile(r"(<!-- table: (.+?) -->\n)(?:\|.*\n)*")
MEASURED = re.compile(r"^.*?(?=<!-- measured: (\w+) -->)", re.MULTILINE)
PERCENTILE = re.compile(r"(?<![a-z])p(\d\d(?:\.\d)?)(?![\d.])")


def result(name: str) -> dict[str, Any]:
    """What a benchmark wrote."""
    found: dict[str, Any] = json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))
    return found


def enough(name: str, samples: int | None) -> bool:
    """Whether so many samples tell the percentile that a figure is named by, if it is one."""
    found = PERCENTILE.search(name)
    if found is None or float(found[1]) <= 50:
        return True
    return round((samples or 0) * (1 - float(found[1]) / 100), 6) >= 1


def samples_of(value: dict[str, Any], known: int | None) -> int | None:
    """How many samples there were, by an object, or by what it is part of."""
    counts = [value[key] for key in COUNTS if isinstance(value.get(key), int | float)]
    return int(counts[0]) if counts else known


def follow(
    value: dict[str, Any], keys: list[str], names: tuple[str, ...] = (), known: int | None = None
) -> Iterator[tuple[tuple[str, ...], dict[str, Any], int | None]]:
    """The objects that a path leads to: what names each, itself, and its number of samples."""
    known = samples_of(value, known)
    if not keys:
        yield names, value, known
        return
    key, *rest = keys
    for name in value if key == "*" else [key]:
        if isinstance(value.get(name), dict):
            yield from follow(value[name], rest, (*names, name) if key == "*" else names, known)


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


def table(asked: str) -> str:
    """A Markdown table; the first column is text, the others are numbers to the right."""
    path, columns, *chosen = (part.strip() for part in asked.split("::"))
    name, *keys = path.split(" / ")
    wanted = [column.strip().partition(" = ")[::2] for column in columns.split(";")]
    lines = [
        "| | " + " | ".join(title or heading(key) for key, title in wanted) + " |",
        "|---|" + "---:|" * len(wanted),
    ]
    figures = {key: value for key, value in result(name).items() if key != "machine"}
    for names, row, samples in follow(figures, keys):
        title = ", ".join(names)
        if chosen and not re.search(chosen[0], title):
            continue
        if not enough(title, samples):
            raise ValueError(f"{title!r} of {asked!r} is of too few samples: {samples}")
        cells = [cell(row.get(key, "")) if enough(key, samples) else TOO_FEW for key, _ in wanted]
        lines.append("| " + " | ".join([title, *cells]) + " |")
    if len(lines) == 2:
        raise ValueError(f"no row is left of {asked!r}")
    return "\n".join(lines) + "\n"


def measured(name: str) -> str:
    """When, from which commit and on what a result was measured."""
    machine = result(name).get("machine")
    if machine is None:
        return "Date and machine were not kept. "
    about = [machine["processor"], f"{machine['cores']} cores", machine["system"]]
    about.append(f"Python {machine['python']}")
    if "wake_up_us" in machine:
        wake_up = machine["wake_up_us"]
        about.append(f"a bare process wakes up in {wake_up['p50']} µs, p99 {wake_up['p99']}")
    commit = f", commit {machine['commit']}" if "commit" in machine else ""
    return f"Measured {machine['date']}{commit}: {'; '.join(about)}. "


def figure(match: re.Match[str]) -> str:
    """A figure and its unit, with two significant digits."""
    unit, path = match[1], match[2]
    name, *keys, last = path.split(" / ")
    [(_, row, samples)] = follow(result(name), keys)
    if not enough(last, samples):
        raise ValueError(f"{path} is of too few samples: {samples}")
    value = row[last]
    kind = UNITS.get(last.rpartition("_")[2], "")
    if kind != unit and kind in SECONDS:
        value *= SECONDS[kind] / SECONDS[unit]
    return f"{float(f'{value:.2g}'):,g} {unit}"


def page(text: str) -> str:
    """The whole text of a page, as it should be."""
    text = TABLE.sub(lambda match: match[1] + table(match[2]), text)
    text = MEASURED.sub(lambda match: measured(match[1]), text)
    return FIGURE.sub(figure, text)


def main() -> int:
    """Write the pages, or compare them."""
    parser = argparse.ArgumentParser(description="the figures of the pages")
    parser.add_argument("--check", action="store_true", help="compare, change nothing")
    check: bool = parser.parse_args().check
    differ = False
    for path in (*ROOT.glob("*.md"), *HERE.rglob("*.md")):
        found = path.read_text(encoding="utf-8")
        wanted = page(found)
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
