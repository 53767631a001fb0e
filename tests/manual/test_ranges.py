"""The manual's data against the wire, and the named ranges against the manual's data."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

from for_each import for_each

from aioduco._wire import idl
from aioduco.models import ranges
from aioduco.models.rules import (
    Choice,
    Duration,
    Flags,
    Integer,
    Integers,
    OrCurrent,
    OrForever,
    Points,
    Rule,
    Text,
    Vector,
)

FOLDER = Path(__file__).parents[1] / "data"
DATA = json.loads((FOLDER / "manual-3.8.json").read_text("utf-8"))
#: which rule checks which parameter
TABLES = tomllib.loads((FOLDER / "rules.toml").read_text("utf-8"))
USES, COMMON, NAMES, BEYOND, OTHER_UNITS, STRUCTS = (
    TABLES[name] for name in ("uses", "common", "names", "beyond", "other_units", "structs")
)
MANUAL: dict[str, dict[str, Any]] = {function["name"]: function for function in DATA["functions"]}
#: checked by a builder, not by a rule
BUILT = {"op", "op_list", "param", "realtime_data"}

PARAMETERS: dict[str, dict[str, Any]] = {
    f"{name}.{parameter['name']}": parameter
    for name, function in MANUAL.items()
    if function["wire"]
    for parameter in function["parameters"]
    if not parameter.get("out")
}
RULES = {
    name: rule
    for name, rule in vars(ranges).items()
    if isinstance(rule, Rule) and not name.startswith("_")
}
RULE_OF = {use: RULES[name] for name, uses in USES.items() for use in uses.split()}


def rule_of(key: str) -> Rule | None:
    function, _, name = key.partition(".")
    if key in RULE_OF:
        return RULE_OF[key]
    return RULES.get(COMMON.get(name) or (NAMES.get(function, "") if name == "name" else ""))


RANGED = [key for key, parameter in PARAMETERS.items() if "ranges" in parameter]


def test_the_data_is_whole() -> None:
    assert len(MANUAL) == 188
    assert list(DATA["sections"]) == [f"1.3.{number}" for number in range(1, 17)]
    assert {function["section"] for function in MANUAL.values()} == set(DATA["sections"])
    assert len(RANGED) >= 100


def test_every_function_of_the_manual_is_on_the_wire_or_says_why_not() -> None:
    wire = idl.functions()
    for name, function in MANUAL.items():
        if function["wire"] is None:
            assert name in {"DucoCobot", "open", "close", "get_version"}
            assert function["wire_reason"]
        else:
            assert function["wire"] in wire, name
            assert function["wire"] == name or function["wire_reason"]


def test_every_parameter_of_the_wire_is_in_the_manual_or_known_to_be_missing() -> None:
    missing = {
        (name, parameter)
        for name, function in MANUAL.items()
        if function["wire"]
        for parameter in idl.functions()[function["wire"]].parameters
        if parameter not in {entry["wire"] for entry in function["parameters"]}
    }
    assert missing == {
        ("start_record_track", "interval"),
        ("fc_move", "block"),
        ("trackCartMotion", "radius"),
        ("movec_eaxis", "mode"),
    }


@for_each("key", [k for k, p in PARAMETERS.items() if "choices" in p])
def test_choices_agree(key: str) -> None:
    rule = rule_of(key)
    choices = PARAMETERS[key]["choices"]
    if isinstance(rule, Integers):
        rule = rule.element
    if isinstance(rule, Integer):
        assert (rule.low, rule.high) == (choices[0], choices[-1])
        assert len(choices) == rule.high - rule.low + 1
    else:
        assert isinstance(rule, Choice)
        assert sorted(rule.choices) == choices


@for_each("key", [k for k, p in PARAMETERS.items() if "length" in p])
def test_lengths_agree(key: str) -> None:
    rule = rule_of(key)
    assert isinstance(rule, (Vector, Flags, Integers, OrCurrent))
    assert rule.length == PARAMETERS[key]["length"]


def test_counts_and_sizes_agree() -> None:
    found = 0
    for key, parameter in PARAMETERS.items():
        rule = rule_of(key)
        if "max_points" in parameter:
            assert isinstance(rule, (Points, Integer))
            assert rule.high == parameter["max_points"]
            found += 1
        if "max_bytes" in parameter:
            assert isinstance(rule, Text)
            assert rule.max_bytes == parameter["max_bytes"]
            found += 1
    assert found == 5


def test_units_agree() -> None:
    compared = 0
    for key, parameter in PARAMETERS.items():
        rule = rule_of(key)
        unit = parameter.get("unit")
        if unit is None or key in OTHER_UNITS:
            continue
        if isinstance(rule, (Duration, OrForever)):
            assert unit == "ms"  # our interface takes seconds
        elif isinstance(rule, Points):
            assert rule.element.unit == unit, key
        elif isinstance(rule, OrCurrent):
            assert rule.rule.unit == unit, key
        else:
            assert getattr(rule, "unit", None) == unit, key
        compared += 1
    assert compared >= 130


def test_every_parameter_has_a_rule_or_a_builder() -> None:
    without = {
        key
        for key, parameter in PARAMETERS.items()
        if rule_of(key) is None and parameter["name"] not in BUILT and parameter["wire"]
    }
    bools = {key for key in without if PARAMETERS[key]["type"] in {"bool", "vector<bool>"}}
    # the lengths are those of the lists beside them
    assert without - bools == {
        "modbus_write_multiple_regs.len",
        "modbus_write_multiple_coils.len",
    }


def test_the_table_names_parameters_that_exist_and_each_rule_is_used() -> None:
    assert set(RULE_OF) <= set(PARAMETERS)
    used = {*USES, *COMMON.values(), *NAMES.values()}
    assert set(RULES) - used == set(BEYOND)


def test_each_rule_names_the_section_of_a_function_that_uses_it() -> None:
    for name, uses in USES.items():
        source = STRUCTS.get(name) or RULES[name].source
        sections = {MANUAL[use.partition(".")[0]]["section"] for use in uses.split()}
        assert source in sections or not source.startswith("1.3"), name
