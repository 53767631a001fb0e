"""Every function of the wire, called by clients generated in Python and in C++.

Both are compared with one table: good calls, the shorter calls of older clients, calls of an arm
without power, and arguments that make no sense (see `table`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest

from aioduco._wire import idl
from aioduco.sim import Simulator
from aioduco.testing import eventually

from . import layouts, table
from .clients import Client, CppClient, Lost, PythonClient, Refused
from .conftest import Generated
from .session import Session

Start = Callable[[Simulator], Client]

#: the first test waits for a compiler
pytestmark = [pytest.mark.interop, pytest.mark.timeout(900)]

SIMULATED = [name for name in table.FUNCTIONS if name not in table.REFUSED]
#: ends what it is called on, so it has a test of its own
LAST = "shutdown"
EACH = [name for name in SIMULATED if name != LAST]
SHORT = [name for name in EACH if layouts.left_out(name)]
OLDER = [
    (service, name)
    for service in ("Older", "Oldest", "First")
    for name in layouts.layouts()[service]
]


@pytest.fixture(scope="module", params=["python", "cpp"])
def start(request: pytest.FixtureRequest, generated: Generated) -> Iterator[Start]:
    """Connect a client of one of the languages; it is closed at the end."""
    clients: list[Client] = []
    program: Path | None = None
    if request.param == "cpp":
        program = request.getfixturevalue("driver")

    def connect(sim: Simulator) -> Client:
        made = PythonClient(sim.host, sim.port)
        clients.append(made if program is None else CppClient(program, sim.host, sim.port))
        return clients[-1]

    yield connect
    for client in clients:
        client.close()


def simulator() -> Simulator:
    """A strict simulator on the fast clock that has what the table's calls name."""
    return Simulator(
        speed=math.inf,
        strict=True,
        values={"a_bool": False, "a_double": 0.0, "a_str": "", "a_list": [0.0], "a_lists": [[0.0]]},
        external_axes={"rail": [(-1.0, 1.0, 0.5, 2.0)]},
        programs={"wave": [["movej2", [0.05, 0.0, 1.57, 0.0, -1.57, 0.0], 1.0, 2.0]]},
    )


@pytest.fixture(scope="module")
def enabled(start: Start) -> Iterator[Session]:
    """A client at an arm that is enabled before each call."""
    with simulator() as sim:
        yield Session(start(sim))


@pytest.fixture(scope="module")
def unpowered(start: Start) -> Iterator[Session]:
    """A client at an arm that never has power, but where a call brings it."""
    with simulator() as sim:
        yield Session(start(sim))


def answer(session: Session, service: str, name: str, args: dict[str, Any]) -> Any:
    """Prepare what the table names, and call; of a task's id, say how the task ends."""
    done(session, table.FUNCTIONS[name].get("setup", ()))
    got = session.client.call(service, name, args)
    return f"id {session.end(got)}" if table.is_id(name, got) else got


def done(session: Session, calls: Iterable[tuple[str, dict[str, Any]]]) -> None:
    """Make some calls, each when what the one before began has ended."""
    for name, args in calls:
        got = session.call(name, args)
        if table.is_id(name, got):
            session.end(got)


def tidy(session: Session, name: str) -> None:
    """Take back what a call changed."""
    done(session, table.FUNCTIONS[name].get("after", ()))


def test_the_table_names_every_function() -> None:
    assert set(table.FUNCTIONS) == set(idl.functions())
    for name, function in idl.functions().items():
        assert set(table.FUNCTIONS[name].get("args", {})) == set(function.parameters), name
    assert set(table.REFUSED) <= set(table.FUNCTIONS)


@pytest.mark.parametrize("name", EACH)
def test_a_good_call(enabled: Session, name: str) -> None:
    row = table.FUNCTIONS[name]
    enabled.enabled()
    got = answer(enabled, "RPCRobot", name, row.get("args", {}))
    tidy(enabled, name)
    assert table.fits(row["answer"], got), (row["answer"], got, enabled.call("get_last_error"))


@pytest.mark.parametrize("name", EACH)
def test_a_call_without_power(unpowered: Session, name: str) -> None:
    row = table.FUNCTIONS[name]
    expected = row.get("off", row["answer"])
    unpowered.unpowered()
    got = answer(unpowered, "RPCRobot", name, row.get("args", {}))
    tidy(unpowered, name)
    assert table.fits(expected, got), (expected, got)


@pytest.mark.parametrize("name", SHORT)
def test_a_call_with_fields_left_out(enabled: Session, name: str) -> None:
    args, expected = table.short_call(name)
    enabled.enabled()
    got = answer(enabled, "Short", name, args)
    tidy(enabled, name)
    assert table.fits(expected, got), (expected, got)


@pytest.mark.parametrize(("service", "name"), OLDER)
def test_a_call_of_an_older_client(enabled: Session, service: str, name: str) -> None:
    """It gets a task's state or id, or the refusal of a function that is not simulated."""
    args, expected = table.older_call(service, name)
    enabled.enabled()
    got = answer(enabled, service, name, args)
    tidy(enabled, name)
    assert table.fits(expected, got), (expected, got)


@pytest.mark.parametrize("name", [name for name in EACH if table.FUNCTIONS[name].get("args")])
def test_calls_that_make_no_sense(enabled: Session, name: str) -> None:
    wrong = []
    for what, args, expected in table.bad_calls(name):
        enabled.enabled()
        got = answer(enabled, "RPCRobot", name, args)
        if not table.fits(expected, got):
            wrong.append((what, expected, got))
    tidy(enabled, name)
    assert not wrong


@pytest.mark.parametrize("name", table.REFUSED)
def test_what_is_not_simulated_is_refused_with_a_reason(enabled: Session, name: str) -> None:
    """A function that is simulated now has to leave the list, and to say what it answers."""
    enabled.state()
    calls = [table.FUNCTIONS[name].get("args", {}), *(a for _, a, _ in table.bad_calls(name))]
    for args in calls:
        got = enabled.call(name, args)
        assert isinstance(got, Refused), got
        assert got.text.startswith(f"{name} is not simulated")
        assert got.text.endswith(table.REFUSED[name])


def test_shutdown_answers_before_the_controller_is_gone(start: Start) -> None:
    with simulator() as sim:
        session = Session(start(sim))
        assert session.call(LAST, {"block": True}) == table.FUNCTIONS[LAST]["answer"]
        eventually(lambda: sim.halted)
        assert isinstance(session.call("get_robot_state"), Lost)
