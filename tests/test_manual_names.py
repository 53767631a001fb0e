"""A name of the manual on the wrong object: the error says which object has it."""

from __future__ import annotations

import copy
import functools
import inspect
import json
import pickle
from pathlib import Path
from typing import Any

import pytest
from for_each import for_each

import aioduco
import aioduco.sync
from aioduco._wire import idl
from aioduco.errors import NamedElsewhere, NotCopyable
from aioduco.models import names

DATA = Path(__file__).parent / "data"
PRINTED: list[dict[str, Any]] = json.loads((DATA / "manual-3.8.json").read_text())["functions"]
ROBOTS = (aioduco.connect("nowhere"), aioduco.sync.connect("nowhere"))


def found(robot: object, where: str) -> object:
    """What a place such as `robot.motion.movel` is of a robot."""
    _, *way = where.split(".")
    return functools.reduce(getattr, way, robot)


@for_each("robot", ROBOTS)
def test_every_function_of_the_wire_has_a_place_and_is_there(robot: object) -> None:
    for name in idl.functions():
        where = names.place(name)
        assert (where is None) is (name in names.BY_ITSELF), name
        assert where is None or callable(found(robot, where)), name


def test_so_has_every_name_that_the_manual_prints() -> None:
    for entry in PRINTED:
        name, wire = entry["name"], entry["wire"]
        assert names.SPELLINGS.get(name, name) == (wire or name)
        known = names.place(name) is not None or name in names.BY_ITSELF
        assert known is (name not in names.CLIENT_SIDE), name


@pytest.mark.parametrize("robot", ROBOTS, ids=["awaited", "waiting"])
@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ("robot.movej2", "movej2 is robot.motion.movej2"),
        ("robot.movel", "movel is robot.motion.movel"),
        ("robot.motion.move1", "move1 is robot.motion.movel: the controller calls it movel"),
        (
            "robot.log.get_noneblock_taskstate",
            "get_noneblock_taskstate is robot.state.get_noneblock_taskstate",
        ),
        ("robot.servo.servoj", "servoj is robot.motion.servoj"),
        ("robot.speed.speedj", "speedj is robot.motion.speedj"),
        ("robot.realtime.trackEnqueue", "trackEnqueue is robot.track.trackEnqueue"),
        ("robot.motion.stop", "stop is robot.stop"),
        ("robot.rpc_heartbeat", "rpc_heartbeat is sent by itself while connected"),
        ("robot.get_version", "get_version is `aioduco.__version__`"),
    ],
)
def test_what_is_said(robot: object, asked: str, said: str) -> None:
    with pytest.raises(NamedElsewhere) as raised:
        found(robot, asked)
    assert str(raised.value) == said
    assert isinstance(raised.value, AttributeError)
    again = pickle.loads(pickle.dumps(raised.value))
    assert (type(again), str(again)) == (NamedElsewhere, said)


@for_each("robot", ROBOTS)
def test_an_object_is_otherwise_as_it_was(robot: Any) -> None:
    for one in (robot, robot.motion, robot.servo, robot.realtime):
        assert not hasattr(one, "movej3")
        assert not hasattr(one, "trackGetSomething")
        assert "get_robot_state" not in dir(one)
        assert dict(inspect.getmembers(one))
        for probe in ("_repr_html_", "_ipython_canary_method_should_not_exist_", "__array__"):
            assert not hasattr(one, probe)
        with pytest.raises(AttributeError, match="object has no attribute 'movej3'") as raised:
            _ = one.movej3
        assert type(raised.value) is AttributeError
        assert (raised.value.name, raised.value.obj) == ("movej3", one)
    assert not hasattr(robot, "movej2")
    with pytest.raises(NotCopyable, match="Servo cannot be copied"):
        copy.copy(robot.servo)


def test_what_a_property_raises_is_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(_: object) -> None:
        raise AttributeError("from within")

    monkeypatch.setattr(aioduco.Robot, "stop", property(failing), raising=True)
    with pytest.raises(AttributeError, match="from within"):
        _ = ROBOTS[0].stop


def test_type_checkers_know_that_it_is_not_there() -> None:
    """`mypy` says so of this line if it takes every name for one that is there."""
    with pytest.raises(NamedElsewhere):
        _ = ROBOTS[0].movej2  # type: ignore[attr-defined]  # what this is about


def test_what_closes_a_robot_that_was_opened_by_a_call_is_named() -> None:
    robot: Any = aioduco.connect("192.0.2.1")
    with pytest.raises(NamedElsewhere, match=r"`await robot\.aclose\(\)`$"):
        _ = robot.close
    assert callable(robot.aclose)


def test_a_wait_of_blocking_programs_is_named_in_those_with_async() -> None:
    robot: Any = aioduco.connect("192.0.2.1")
    for one in (robot, robot.motion):
        with pytest.raises(NamedElsewhere, match=r"asyncio\.sleep"):
            _ = one.sleep
