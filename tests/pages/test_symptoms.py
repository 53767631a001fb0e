"""The page of symptoms names every error, and quotes the package's own texts."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.machinery import SourceFileLoader
from types import CodeType

from for_each import for_each

import aioduco.errors
from pages.blocks import ROOT

PAGE = (ROOT / "docs" / "symptoms.md").read_text("utf-8")
ROWS = [line.split(" | ") for line in PAGE.splitlines() if line.startswith("| ")]


def texts() -> Iterator[str]:
    """What the package may say: texts that stand in one place, between the values that come."""
    for file in (ROOT / "aioduco").rglob("*.py"):
        # compiled already, where the package was imported; parsing all of it takes seconds
        codes = [SourceFileLoader(file.stem, str(file)).get_code(file.stem)]
        for code in codes:
            for each in code.co_consts if code else ():
                if isinstance(each, CodeType):
                    codes.append(each)
                elif isinstance(each, str):
                    yield each


def quoted() -> list[str]:
    """What the first column quotes of the package, other than names and code."""
    found = {
        text
        for symptom, *_ in ROWS
        for text in re.findall(r"`([^`]+)`", symptom)
        if " " in text and not re.search(r"[(=]|^(aioduco|pip)", text)
    }
    return sorted(found)


def test_every_error_has_a_row() -> None:
    named = set(re.findall(r"`(\w+)`", " ".join(row[0] for row in ROWS)))
    assert set(aioduco.errors.__all__) - named == {"StopUnconfirmed"} - named


def test_every_row_says_why_and_what_to_do() -> None:
    assert len(ROWS) > 60
    for row in ROWS:
        assert len(row) == 3, row
        assert all(len(cell.strip(" |")) > 2 for cell in row), row


def test_what_is_quoted_is_said() -> None:
    said = "\n".join(texts())
    quotes = quoted()
    assert len(quotes) > 15
    missing = [
        quote
        for quote in quotes
        if not all(part.strip() in said for part in quote.split("…") if part.strip(" ();"))
    ]
    assert missing == []


@for_each("page", ["index.md", "tutorial.md"])
def test_readers_are_led_to_it(page: str) -> None:
    assert "(symptoms.md)" in (ROOT / "docs" / page).read_text("utf-8")
