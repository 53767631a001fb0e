"""Controllers of older generations: functions that they lack, fields that they do not know."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from api.cases import Case, cases
from for_each import for_each

import aioduco
from aioduco import Joints
from aioduco._wire.connection import Connection
from aioduco._wire.endpoint import Endpoint
from client.bench import HOME
from client.older import NAMES, OLDER, WIRE, Field, OlderController

CASES = {case.name: case for case in cases()}


@pytest.fixture(scope="module", params=NAMES)
def older(request: pytest.FixtureRequest, tmp_path_factory: Any) -> Iterator[OlderController]:
    with OlderController(request.param, tmp_path_factory.mktemp("older")) as controller:
        yield controller


def theirs(value: Any, structs: Any) -> Any:
    """An answer as this generation gives it: structs without the fields that it lacks."""
    if isinstance(value, list):
        return [theirs(one, structs) for one in value]
    if hasattr(value, "thrift_spec"):
        kind = getattr(structs, type(value).__name__)
        names = [entry[1] for entry in kind.thrift_spec.values()]
        return kind(**{name: theirs(getattr(value, name), structs) for name in names})
    return value


def known(value: Any, structs: Any) -> Any:
    """What this generation makes of a value: plain, without the fields that it lacks."""
    if isinstance(value, (list, tuple)):
        return [known(one, structs) for one in value]
    if hasattr(value, "thrift_spec"):
        spec = getattr(structs, type(value).__name__).thrift_spec.values()
        return {entry[1]: known(getattr(value, entry[1]), structs) for entry in spec}
    return value


@pytest.mark.cases(1)
@for_each("name", CASES)
def test_each_function_is_answered_or_missing(name: str, older: OlderController) -> None:
    case: Case = CASES[name]
    older.answers[name] = theirs(case.answer, older.structs)
    older.received.clear()
    connection = Connection(Endpoint(older.host, older.port))
    connection.open()
    try:
        if name not in older.layout.parameters:
            with pytest.raises(aioduco.UnknownFunction, match="did nothing"):
                connection.call(name, case.wire, 5.0)
            assert not older.received
            return
        answer = connection.call(name, case.wire, 5.0)
        ((method, args),) = older.received
    finally:
        connection.close()
    assert method == name
    places = [Field(*each) for each in WIRE["methods"][name]["args"]]
    sent = dict(zip(places, case.wire, strict=True))
    for field, arrived in zip(older.layout.parameters[name], args, strict=True):
        # what has another type there is passed over, so that it is never taken for something else
        expected = known(sent[field], older.structs) if field in sent else None
        assert known(arrived, older.structs) == expected
    assert isinstance(answer, type(case.answer))
    assert known(answer, older.structs) == known(case.answer, older.structs)


def test_what_they_lack_is_what_the_data_says(older: OlderController) -> None:
    lacks = set(WIRE["methods"]) - set(older.layout.parameters)
    assert lacks
    assert lacks in [set(OLDER[generation]["lacks"]) for generation in NAMES]


async def test_a_robot(older: OlderController) -> None:
    ids = iter(range(1000, 2000))
    for name in ("movej2", "stop"):
        older.answers[name] = lambda *_: next(ids)
    older.answers |= {
        "get_robot_version": "V2.6.1",
        "get_noneblock_taskstate": 4,
        "get_actual_joints_position": HOME,
        "robotmoving": False,
    }
    tells = "get_robot_version" in older.layout.parameters
    said = r"controller, version V2\.6\.1, has" if tells else "controller has"
    async with aioduco.connect(older.host, older.port) as robot:
        assert robot.version.controller.numbers == ((2, 6, 1) if tells else ())
        op = aioduco.Op.at_start(aioduco.output(3), time=0.5)
        assert await robot.motion.movej2(Joints(*HOME), 1.0, 1.0, op=op) is aioduco.Outcome.FINISHED
        with pytest.raises(aioduco.UnknownFunction, match=said) as raised:
            await robot.kinematics.get_calib_DH()
        assert raised.value.version == ("V2.6.1" if tells else "")
        with pytest.raises(aioduco.UnknownFunction, match=said):
            await robot.motion.wobj_move([0.0] * 6, 0.1, 0.1)
        assert not robot.tasks
        # the connection lives on
        assert await robot.state.robotmoving() is False


async def test_inputs_and_outputs(older: OlderController) -> None:
    """The oldest has other lists under the numbers of today's."""
    status = older.structs.IOStatus(
        analogCurrentOutputs=[4.0],
        analogVoltageOutputs=[5.0],
        digitalInputs=[True, False] * 8,
        digitalOutputs=[False, True] * 8,
        toolIOIn=[True, False],
        toolIOOut=[False, True],
        toolButton=[True, True],
    )
    older.answers["getRobotIOStatus"] = status
    async with aioduco.connect(older.host, older.port) as robot:
        read = await robot.state.getRobotIOStatus()
    assert read.analog_voltage_outputs == (5.0,)
    assert read.digital_inputs == (True, False) * 8
    assert read.digital_outputs == (False, True) * 8
    assert read.tool_inputs == (True, False)
    assert read.tool_outputs == (False, True)
    assert read.tool_buttons == (True, True)
    assert read.analog_voltage_inputs == read.bool_inputs == ()
