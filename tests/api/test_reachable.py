"""Every function of the manual and of the wire is there, and documented."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from functools import cache
from typing import Any

from for_each import for_each

import aioduco
from aioduco._wire import idl
from aioduco.api.section import Section
from api.cases import DATA, MANUAL, NOBODY

#: what is on the robot itself, since it is for all of it
ON_THE_ROBOT = {"stop", "pause", "resume", "abort"}
#: what a program has no use for, and why
EXCEPTIONS = {
    "rpc_heartbeat": "sent by the robot's heartbeat while it is open; connect(heartbeat=...)"
}
#: what the manual has and the wire has not, and where it is here
ELSEWHERE = {
    "DucoCobot": aioduco.connect,
    "open": aioduco.Robot.open,
    "close": aioduco.Robot.aclose,
    "get_version": aioduco.__version__,
}
#: streams of set-points, which are no functions of the wire
STREAMS = {"stream"}
#: says that a function, or what is said of it, is not in manual 3.8
BEYOND = re.compile(r"[Nn]ot in (the )?manual|only on the wire|on the wire alone|manual 4\.3")


@cache
def reachable() -> dict[str, Callable[..., Any]]:
    """Each public function of a section of the robot, and of the robot itself, by name."""
    found: dict[str, Callable[..., Any]] = {name: getattr(NOBODY, name) for name in ON_THE_ROBOT}
    for attribute in dir(NOBODY):
        section = None if attribute.startswith("_") else getattr(NOBODY, attribute)
        if not isinstance(section, Section):
            continue
        assert attribute in aioduco.Robot.__annotations__
        assert f"\n    {attribute}: " in str(inspect.getdoc(aioduco.Robot)), (
            f"{attribute} is undocumented"
        )
        if attribute == "blocking":
            continue  # the same functions again; `test_blocking` has their tests
        for name, method in inspect.getmembers(section, callable):
            if not name.startswith("_") and name not in STREAMS:
                assert name not in found, f"{name} is in two sections"
                found[name] = method
    return found


WIRE = sorted(set(idl.functions()) - set(EXCEPTIONS))


def test_every_function_of_the_wire_is_reachable() -> None:
    assert len(idl.functions()) == 226
    assert set(idl.functions()) - set(reachable()) == set(EXCEPTIONS)
    assert not set(EXCEPTIONS) & set(reachable())


def test_every_function_of_the_manual_is_reachable() -> None:
    functions = {one["name"]: one["wire"] for one in DATA["functions"]}
    assert len(functions) == 188
    for name, wire in functions.items():
        if wire is None:
            assert ELSEWHERE[name]
        else:
            assert wire in reachable() or wire in EXCEPTIONS, name


@for_each("name", WIRE)
def test_it_is_documented(name: str) -> None:
    method = reachable()[name]
    text = inspect.getdoc(method)
    assert text
    first = text.partition("\n")[0]
    assert first.rstrip(".") != first or "\n\n" in text, "the first line is a sentence, or a title"
    if (function := MANUAL.get(name)) is None:
        assert BEYOND.search(text), "where does it come from?"
    else:
        assert f"anual section {function['section']}" in text
        assert re.search("[\u4e00-\u9fff]", text), "the manual's own term helps a search"
        if function["name"] != name:
            assert function["name"] in text, "the manual's spelling helps a search"
    parameters = inspect.signature(method).parameters
    if len(parameters) > 1:
        for parameter in parameters:
            assert re.search(rf"^    \*?{parameter}: ", text, re.MULTILINE), parameter
    if "\n" in text and inspect.signature(method).return_annotation not in {"None", None}:
        assert "Returns:" in text or len(parameters) <= 1


@for_each("name", WIRE)
def test_there_is_no_block_and_nothing_beyond_the_first_is_positional_by_chance(name: str) -> None:
    parameters = inspect.signature(reachable()[name]).parameters
    assert "block" not in parameters
    for parameter, one in parameters.items():
        if one.default is not one.empty:
            alone = len(parameters) <= 2
            assert one.kind is one.KEYWORD_ONLY or alone, f"{parameter} has a default"
