"""The states of a connection, through every order of events."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

from for_each import for_each

from aioduco._wire.lifecycle import ConnectionState, Lifecycle, Progress

NEW, IDLE, ACTIVE = ConnectionState.NEW, ConnectionState.IDLE, ConnectionState.ACTIVE
POISONED, CLOSED = ConnectionState.POISONED, ConnectionState.CLOSED

EVENTS: dict[str, Callable[[Lifecycle], bool]] = {
    "opened": Lifecycle.opened,
    "begin": Lifecycle.begin,
    "complete": Lifecycle.complete,
    "poison": lambda life: life.poison("a reason"),
    "close": Lifecycle.close,
}

#: every transition that there is; any other event is refused and changes nothing
TRANSITIONS = {
    (NEW, "opened"): IDLE,
    (IDLE, "begin"): ACTIVE,
    (ACTIVE, "complete"): IDLE,
    (NEW, "poison"): POISONED,
    (IDLE, "poison"): POISONED,
    (ACTIVE, "poison"): POISONED,
    (NEW, "close"): CLOSED,
    (IDLE, "close"): CLOSED,
    (ACTIVE, "close"): CLOSED,
    (POISONED, "close"): CLOSED,
}

REACHED = {
    NEW: (),
    IDLE: ("opened",),
    ACTIVE: ("opened", "begin"),
    POISONED: ("poison",),
    CLOSED: ("close",),
}


@for_each("state, event", product(ConnectionState, EVENTS))
def test_each_event_in_each_state(state: ConnectionState, event: str) -> None:
    life = Lifecycle()
    for step in REACHED[state]:
        assert EVENTS[step](life)
    assert life.state is state
    happened = EVENTS[event](life)
    assert happened is ((state, event) in TRANSITIONS)
    assert life.state is TRANSITIONS.get((state, event), state)


def test_the_first_reason_stays() -> None:
    life = Lifecycle()
    life.poison("the first")
    life.poison("the second")
    life.close()
    assert life.reason == "the first"
    other = Lifecycle()
    other.close()
    assert other.reason


def test_each_call_begins_with_nothing_sent() -> None:
    life = Lifecycle()
    life.opened()
    seen = []
    for step in (life.begin, life.sent, life.answering, life.complete, life.begin):
        step()
        seen.append(life.progress)
    nothing, sent, answering = Progress.NOTHING_SENT, Progress.SENT, Progress.ANSWERING
    assert seen == [nothing, sent, answering, answering, nothing]
