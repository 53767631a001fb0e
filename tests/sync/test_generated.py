"""The generated modules are complete, up to date, and equal to the awaited interface."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import sys
from functools import cache
from pathlib import Path
from typing import TypeGuard

import pytest

import aioduco
import aioduco.sync
from aioduco.api.streams.servo import OffsetStream as AioOffsetStream
from aioduco.api.streams.track import TrackStream as AioTrackStream
from aioduco.streaming.stream import Stream as AioStream
from aioduco.sync import MotionFunction

ROOT = Path(__file__).parents[2]

MODULES = ("_generated.py", "_generated_objects.py")
#: what has another name, or no use, in a program that waits
RENAMED = {"aclose": "close"}
#: what returns something to tie to a block, and does not wait
TIED = {"path"}


def public(thing: object) -> set[str]:
    return {name for name in dir(thing) if not name.startswith("_")}


def documented(node: ast.AST) -> TypeGuard[ast.ClassDef | ast.FunctionDef]:
    return isinstance(node, ast.ClassDef | ast.FunctionDef)


def sections(robot: object) -> list[str]:
    """The names of the sections: what lies in `api`, or makes streams alone."""
    return [
        name
        for name in sorted(public(robot))
        if type(getattr(robot, name)).__module__.startswith(("aioduco.api", "aioduco.streaming"))
    ]


@pytest.mark.slow
def test_it_is_up_to_date_and_the_check_finds_a_difference(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "idl"))
    monkeypatch.setattr(sys, "argv", ["generate_sync.py", "--check"])
    generator = importlib.import_module("generate_sync")
    monkeypatch.setattr(generator, "texts", cache(generator.texts))
    assert generator.main() == 0, capsys.readouterr().out
    monkeypatch.setattr(generator, "PACKAGE", tmp_path)
    for name, text in generator.texts().items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert generator.main() == 0
    changed = tmp_path / "sync" / "_generated.py"
    changed.write_text(changed.read_text("utf-8").replace("._made.power_on(", "._made.power_off("))
    assert generator.main() == 1
    assert "self._made.power_off(" in capsys.readouterr().out


def test_everything_public_is_there() -> None:
    awaited = aioduco.connect("nowhere")
    waiting = aioduco.sync.connect("nowhere")
    assert {RENAMED.get(name, name) for name in public(awaited)} <= public(waiting)
    assert {"motion", "servo", "speed"} <= set(sections(awaited))
    for section in sections(awaited):
        assert public(getattr(awaited, section)) == public(getattr(waiting, section)), section


def test_signatures_are_the_same() -> None:
    awaited = aioduco.connect("nowhere")
    waiting = aioduco.sync.connect("nowhere")
    functions = 0
    for section in sections(awaited):
        ours, theirs = getattr(waiting, section), getattr(awaited, section)
        for name in public(theirs):
            function = getattr(theirs, name)
            if not callable(function):
                assert getattr(ours, name) == function  # a property
                continue
            parameters = inspect.signature(function).parameters
            got = inspect.signature(getattr(ours, name)).parameters
            assert list(got) == list(parameters), name
            assert [p.kind for p in got.values()] == [p.kind for p in parameters.values()], name
            assert [p.default for p in got.values()] == [p.default for p in parameters.values()]
            functions += 1
            if "Stream" in str(inspect.signature(function).return_annotation):
                assert inspect.signature(getattr(ours, name)).return_annotation.endswith("Stream")
                continue
            moves = isinstance(getattr(ours, name), MotionFunction)
            if name in TIED:
                assert not moves
                continue
            waits = inspect.iscoroutinefunction(inspect.unwrap(function))
            assert moves is not waits, name
    assert functions > 100


def test_streams_have_what_the_awaited_ones_have() -> None:
    for ours, theirs in (
        (aioduco.sync.Stream, AioStream),
        (aioduco.sync.OffsetStream, AioOffsetStream),
        (aioduco.sync.TrackStream, AioTrackStream),
    ):
        assert public(ours) == public(theirs)
        for name in public(theirs):
            function = getattr(theirs, name)
            if callable(function):
                awaited, waiting = (
                    inspect.signature(function),
                    inspect.signature(getattr(ours, name)),
                )
                assert list(waiting.parameters) == list(awaited.parameters), name
                assert [p.default for p in waiting.parameters.values()] == [
                    p.default for p in awaited.parameters.values()
                ]


def test_connect_takes_what_the_awaited_one_takes() -> None:
    awaited = inspect.signature(aioduco.connect).parameters
    waiting = inspect.signature(aioduco.sync.connect).parameters
    assert list(waiting)[: len(awaited)] == list(awaited)
    assert [waiting[name].default for name in awaited] == [p.default for p in awaited.values()]
    assert set(waiting) - set(awaited) == {"hold_limit", "program_limit"}


def test_nothing_is_said_that_only_an_awaiting_program_does() -> None:
    leaks = re.compile(r"\bawait|\basync |cancell(ed|ing|ation)|\bcoroutine|WrongLoop")
    for module in MODULES:
        text = (ROOT / "aioduco/sync" / module).read_text(encoding="utf-8")
        docs = [
            ast.get_docstring(node) or "" for node in ast.walk(ast.parse(text)) if documented(node)
        ]
        assert len(docs) > 40
        assert [doc for doc in docs if leaks.search(doc)] == []
    for name in aioduco.sync.__all__:
        assert getattr(importlib.import_module("aioduco.sync"), name).__doc__
