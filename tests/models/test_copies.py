"""Copies and pickles of each public error and value are complete; handles refuse both.

That each is made of numpy's numbers too is here, since to find all of them takes half a second.
"""

from __future__ import annotations

import copy
import dataclasses
import enum
import inspect
import itertools
import multiprocessing
import pickle
import sys
import threading
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

import made as making
import numpy as np
import pytest
from for_each import for_each
from made import made, same
from public_classes import public_classes

from aioduco import JointTrajectory, errors, recording
from aioduco._process.copying import Uncopied
from aioduco.compat._foreign import as_thrift
from aioduco.errors import DucoError, NotCopyable, ParameterError
from aioduco.planning import Scene
from aioduco.sim.refusal import SimulationFailed
from aioduco.sim.scene import Box

WAYS: dict[str, Callable[[Any], Any]] = {
    "pickle": lambda thing: pickle.loads(pickle.dumps(thing)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}


def classes(*, held: bool) -> list[type[Any]]:
    """The public classes whose objects hold something, or those of values and errors."""
    return [
        kind
        for kind in public_classes()
        if issubclass(kind, Uncopied) == held
        and not (inspect.isabstract(kind) or getattr(kind, "_is_protocol", False))
    ]


@pytest.mark.slow
def test_every_public_value_and_error_comes_back_the_same() -> None:
    wrong = []
    for kind in classes(held=False):
        if kind is recording.RecordedRun:  # the test of a recording makes one
            continue
        things = kind if issubclass(kind, enum.Enum) else [made(kind)]
        for thing, (way, copied) in itertools.product(things, WAYS.items()):
            name = f"{kind.__module__}.{kind.__name__} by {way}"
            try:
                back = copied(thing)
            except Exception as error:  # all of them in one message
                wrong.append(f"{name}: {error!r}")
                continue
            if not same(thing, back):
                wrong.append(f"{name}: {thing!r} became {back!r}")
    assert not wrong, "\n".join(wrong)


@for_each("way", WAYS)
def test_a_failed_simulation_comes_back_the_same(way: str) -> None:
    """A worker process of tests sends it home; it is no error of the public interface."""
    error = SimulationFailed(ValueError("no room"))
    back = WAYS[way](error)
    assert (type(back), str(back)) == (SimulationFailed, str(error))


@pytest.mark.slow
def test_every_public_value_takes_numbers_of_numpy(monkeypatch: pytest.MonkeyPatch) -> None:
    """None fails, and what is checked to be a number is kept as one of Python's."""
    monkeypatch.setitem(making._SIMPLE, float, np.float32(0.5))
    monkeypatch.setitem(making._SIMPLE, int, np.int64(3))
    wrong = []
    kind: type[Any]
    for kind in public_classes():
        if not dataclasses.is_dataclass(kind) or inspect.isabstract(kind):
            continue
        try:
            made(kind)
        except Exception as error:  # all of them in one message
            wrong.append(f"{kind}: {error!r}")
    assert not wrong, "\n".join(wrong)


@pytest.mark.slow
def test_no_value_and_no_error_is_held() -> None:
    plain = (BaseException, enum.Enum, tuple)
    wrong = [
        kind.__name__
        for kind in classes(held=True)
        if issubclass(kind, plain) or dataclasses.is_dataclass(kind)
    ]
    assert wrong == ["Cabinet"]  # it has a lock, and the ports of a running simulator


def test_what_is_held_says_why_it_is_not_copied() -> None:
    kinds = classes(held=True)
    names = {"ArmEnv", "MotionCommand", "Panel", "Robot", "Simulator", "Stream", "Task"}
    assert names <= {kind.__name__ for kind in kinds}
    kind: Any
    for kind in kinds:
        for way in WAYS.values():
            with pytest.raises(NotCopyable, match=f"^{kind.__name__} cannot be copied or pickled"):
                way(kind.__new__(kind))


def test_an_error_whose_value_cannot_be_pickled_comes_back_with_its_text() -> None:
    lock = threading.Lock()
    error = ParameterError("on_event", lock, "a function")
    assert copy.copy(error).value is lock
    assert copy.deepcopy(error).value is lock
    back = pickle.loads(pickle.dumps(error))
    assert type(back) is ParameterError
    assert str(back) == str(error)
    assert repr(back.value) == repr(lock)


def test_an_error_keeps_its_notes_and_what_a_program_adds() -> None:
    class Mine(errors.TaskFailed):
        def __init__(self) -> None:
            super().__init__("movej2", 3, "failed", ["one"])
            self.part = "lid"

    error = Mine()
    error.add_note("while the lid was closed")
    back = copy.deepcopy(error)
    assert same(error, back)
    assert back.__notes__ == ["while the lid was closed"]


def test_an_error_that_is_one_of_thrift_too_is_pickled_as_this_packages(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    module = types.ModuleType("thrift.transport.TTransport")
    module.TTransportException = type("TTransportException", (Exception,), {})  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, module.__name__, module)
    error = as_thrift(errors.CallTimeout("late"))
    back: Any = pickle.loads(pickle.dumps(error))
    assert vars(back) == {"message": "late", "type": 3}
    assert (type(back), str(back)) == (errors.CallTimeout, "late")


def _refused() -> float:
    return JointTrajectory([[400.0] * 6, [0.0] * 6], [0.0, 1.0]).duration


@pytest.mark.slow
def test_a_process_pool_raises_the_error_of_its_worker() -> None:
    with (
        multiprocessing.get_context("spawn").Pool(1) as pool,
        pytest.raises(ParameterError, match="400"),
    ):
        pool.apply_async(_refused).get(timeout=120.0)


def test_arrays_that_are_read_only_stay_so() -> None:
    trajectory = made(JointTrajectory)
    for way in WAYS.values():
        with pytest.raises(ValueError, match="read-only"):
            way(trajectory).positions[0, 0] = 1.0


@pytest.mark.parametrize("way", WAYS)
def test_a_copied_scene_changes_by_itself(way: str) -> None:
    scene = Scene("gcr5_910", [Box(at=(0.45, 0, 0.3), size=(0.1, 0.1, 0.5), name="box")])
    other = WAYS[way](scene)
    other.move("box", (0.5, 0.3, 0.2))
    other.allow("box", "link3")
    joints = [0.0, -0.26, 1.83, 0.0, -1.57, 0.0]
    assert scene.clearance(joints).distance != other.clearance(joints).distance
    assert scene.clearance(joints) == WAYS[way](scene).clearance(joints)


@pytest.mark.parametrize("way", WAYS)
def test_a_recorded_run_comes_back_whole(recorded: Path, way: str) -> None:
    run = recording.read(recorded)
    back = WAYS[way](run)
    assert (back.topics, back.metadata, back.duration) == (run.topics, run.metadata, run.duration)
    for topic in run.topics:
        one, other = run.arrays(topic), back.arrays(topic)
        assert list(one) == list(other)
        for name in one:
            np.testing.assert_array_equal(one[name], other[name])


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    from mcap.writer import Writer  # noqa: PLC0415

    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("", "test")
        schema = writer.register_schema("Numbers", "jsonschema", b"{}")
        channel = writer.register_channel("/numbers", "json", schema)
        for number in range(5):
            writer.add_message(channel, 10**18 + number, b'{"v": %d}' % number, 10**18, number)
        writer.finish()  # type: ignore[no-untyped-call]
    return path


def test_every_error_is_portable() -> None:
    kinds = [getattr(errors, name) for name in errors.__all__ if name != "UnitWarning"]
    assert all(issubclass(kind, DucoError) for kind in kinds)
