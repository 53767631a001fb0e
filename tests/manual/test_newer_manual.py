"""What manual 4.3 adds: each function says truly whether the wire has it."""

from __future__ import annotations

import json
from pathlib import Path

from aioduco._wire import idl
from aioduco.models.names import place

DATA = json.loads((Path(__file__).parents[1] / "data" / "manual-4.3.json").read_text("utf-8"))


def test_additions_say_whether_they_are_on_the_wire() -> None:
    wire = idl.functions()
    known = {entry["name"] for entry in DATA["new"] if entry["status"] == "on the 3.8 wire"}
    assert known == {entry["name"] for entry in DATA["new"]} & set(wire)
    assert known == {"abort", "get_eaxis_info", "get_system_value_lists"}
    assert {entry["status"] for entry in DATA["new"]} == set(DATA["statuses"])


def test_additions_without_arguments_are_functions_of_the_robot() -> None:
    sent = {entry["name"] for entry in DATA["new"] if entry["status"] == "without arguments"}
    assert sent == set(idl.functions().newer)
    assert all(place(name) for name in sent)


def test_additions_are_not_in_the_older_manual() -> None:
    older = json.loads((Path(__file__).parents[1] / "data" / "manual-3.8.json").read_text("utf-8"))
    names = [entry["name"] for entry in DATA["new"]]
    assert len(names) == len(set(names))
    assert not set(names) & {entry["name"] for entry in older["functions"]}
