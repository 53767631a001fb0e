"""The fidelity ledger is complete, and names existing tests."""

from __future__ import annotations

import inspect
import json
import re
from pathlib import Path

from for_each import for_each

from aioduco._wire import idl
from aioduco._wire.rpc import Functions
from aioduco.sim.handlers import NOT_PUBLIC, Handlers

HERE = Path(__file__).parent
LEDGER = (HERE.parents[1] / "docs" / "fidelity.md").read_text(encoding="utf-8")
FUNCTIONS = (HERE.parents[1] / "docs" / "functions.md").read_text(encoding="utf-8")
MANUAL = json.loads((HERE.parent / "data" / "manual-3.8.json").read_text(encoding="utf-8"))
#: functions of the manual that are not on the wire: the vendor's client has them
CLIENT_SIDE = {"DucoCobot", "open", "close", "get_version"}


def tables(head: str) -> list[list[str]]:
    """The rows of all tables with this head."""
    rows: list[list[str]] = []
    current = ""
    for line in LEDGER.splitlines():
        if not line.startswith("|"):
            current = ""
        elif not current:
            current = line
        elif not line.startswith("|---") and current == head:
            rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return rows


ROWS = tables("| behaviour | source | test |")
MISSING = tables("| not simulated | source | why |")
GROUPS = tables("| function | why |")
REFUSED = {name: row[1] for row in GROUPS for name in re.findall(r"`(\w+)`", row[0])}


@for_each("row", ROWS)
def test_each_row_has_a_source_and_a_test(row: list[str]) -> None:
    behaviour, source, test = row
    assert behaviour
    assert re.match(r"manual|maker|wire|seen|public programs|assumption|own decision|IEC", source)
    found = re.fullmatch(r"`([\w./]+\.py)::(\w+)`", test)
    assert found is not None
    module = (HERE / found[1]).read_text(encoding="utf-8")
    assert re.search(rf"^(async )?def {found[2]}\(", module, re.MULTILINE)


def test_every_line_of_a_table_is_in_one() -> None:
    lines = [line for line in LEDGER.splitlines() if line.startswith("|")]
    rows = [*ROWS, *MISSING, *GROUPS]
    assert len(ROWS) > 200
    heads = len(re.findall(r"^\|(?!-).*\n\|---", LEDGER, re.MULTILINE))
    assert len(lines) == len(rows) + 2 * heads


@for_each("row", MISSING)
def test_what_is_not_simulated_has_a_source_and_a_reason(row: list[str]) -> None:
    what, source, why = row
    assert what
    assert re.match(r"manual|seen", source)
    assert why


def test_every_function_is_in_its_section_of_the_page_of_functions_once() -> None:
    sections: dict[str, list[str]] = {}
    for block in FUNCTIONS[: FUNCTIONS.index("## Older controllers")].split("\n## ")[1:]:
        sections[block.split()[0]] = re.findall(r"^\| `(\w+)`", block, re.MULTILINE)
    named = [name for each in sections.values() for name in each]
    assert sorted(set(named) - CLIENT_SIDE) == sorted(idl.functions())
    assert len(named) == len(set(named))
    for function in MANUAL["functions"]:
        assert (function["wire"] or function["name"]) in sections[function["section"]]


def test_each_section_of_the_page_of_functions_leads_to_tables() -> None:
    headings = set(re.findall(r"^## (.+)$", LEDGER, re.MULTILINE))
    lines = re.findall(r"^Simulated: .+$", FUNCTIONS, re.MULTILINE)
    assert len(lines) == FUNCTIONS.count("\n| function | here | what it does | missing |")
    assert {name for line in lines for name in re.findall(r"\[(.+?)\]\(", line)} <= headings


# -- the functions themselves --------------------------------------------------------------------


@for_each("name", sorted(idl.functions()))
def test_each_function_is_simulated_or_refused_with_a_reason(name: str) -> None:
    """What no section of the handlers has is left to the generated client, which refuses it."""
    left = getattr(Handlers, name) is getattr(Functions, name)
    assert left is (name in NOT_PUBLIC)
    assert left is (name in REFUSED)


@for_each("name", sorted(set(idl.functions()) - set(NOT_PUBLIC)))
def test_each_handler_takes_what_the_wire_brings(name: str) -> None:
    handler = getattr(Handlers, name)
    theirs = list(inspect.signature(getattr(Functions, name)).parameters)
    assert list(inspect.signature(handler).parameters) == theirs
    command = inspect.getclosurevars(handler).nonlocals.get("command")
    if command is not None:  # it gets the controller, and all but `block` by name
        ours = inspect.signature(command).parameters.values()
        named = [each.name for each in ours if each.kind is not each.VAR_KEYWORD][2:]
        given = [each for each in theirs[1:] if each != "block"]
        assert named == given[: len(named)]
        assert len(named) == len(given) or len(named) < len(ours) - 2


def test_the_reasons_are_those_that_callers_get() -> None:
    assert REFUSED == NOT_PUBLIC
