"""A lane in every order of calls, faults, cancellations and lost connections."""

from __future__ import annotations

import random
from concurrent.futures import Future
from contextlib import ExitStack
from functools import partial

from anyio.from_thread import start_blocking_portal
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from quick import examples

from aioduco._wire.idempotence import CallKind, call_kind
from aioduco._wire.lane import WireLane
from aioduco.testing import (
    ApplicationError,
    Cut,
    Delay,
    DropReply,
    DropRequest,
    Ending,
    Fault,
    FaultProxy,
    Garbage,
    HalfOpen,
    HoldReply,
    Place,
    RecordingServer,
    Throttle,
    WrongKind,
    WrongMethod,
    WrongSeqid,
    eventually,
    no_leaks,
)

from .calls import ANSWERS, METHODS, CallRecords, make
from .menu import MENU

#: s; long enough that a call that is not held back is never late, even on a busy machine
AMPLE = 5.0
#: s; for calls that a fault holds back for ever
SHORT = 0.03


def waits(fault: Fault | None) -> bool:
    """Whether the fault lets the caller wait until its deadline."""
    return isinstance(fault, DropRequest | DropReply | HoldReply)


def outcomes(fault: Fault | None, method: str) -> set[str]:
    """What may come of a call on a lane that is otherwise at rest."""
    command = call_kind(method) is not CallKind.READ
    failed = "unknown" if command else "lost"
    match fault:
        case WrongMethod(name) if name == method:
            return {"answered"}
        case None | Delay() | Throttle() | Cut(Place.AFTER_REPLY):
            return {"answered"}
        case ApplicationError():
            return {"error"}
        case Garbage() | WrongSeqid() | WrongMethod() | WrongKind() | Cut(Place.IN_REPLY):
            return {failed}
        case Cut() | HalfOpen():
            # a call that only reads is made once more, if the connection had served before
            return {"unknown"} if command else {"lost", "answered"}
        case _ if waits(fault):
            return {failed}
        case _:
            return {"answered", failed}


class LaneMachine(RuleBasedStateMachine):
    """One lane, its server, and the proxy between them."""

    def __init__(self) -> None:
        super().__init__()
        self.stack = ExitStack()
        self.stack.enter_context(no_leaks())
        self.portal = self.stack.enter_context(start_blocking_portal())
        self.server = self.stack.enter_context(RecordingServer(ANSWERS))
        self.proxy = self.stack.enter_context(FaultProxy(self.server.host, self.server.port))
        self.records = CallRecords(random.Random(0))
        self.pending: list[Future[None]] = []
        #: whether the next call may meet a connection that is about to fail
        self.doubtful = False
        self.refusing = False

    @initialize(size=st.integers(1, 3))
    def open(self, size: int) -> None:
        self.lane = WireLane("call", self.proxy.host, self.proxy.port, size=size)
        self.portal.call(self.lane.open)

    def teardown(self) -> None:
        with self.stack:
            for future in self.pending:
                future.cancel()
            if hasattr(self, "lane"):
                self.portal.call(self.lane.aclose)
                # One that the proxy has yet to accept is not cut: without a fault it ends alone.
                self.proxy.clear()
                self.proxy.cut()
                eventually(lambda: self.proxy.statistics().open == self.server.connections == 0)
            self.records.check(self.server)

    # Calls

    @precondition(lambda self: not self.pending and not self.refusing)
    @rule(method=st.sampled_from(METHODS), fault=st.none() | st.sampled_from(MENU))
    def call(self, method: str, fault: Fault | None) -> None:
        """A call alone: what comes of it is known from the fault."""
        if fault is not None:
            self.proxy.on(method, fault)
        before = self.records.outcomes
        follow = partial(self.records.follow, make(method), self.lane.call)
        self.portal.call(partial(follow, SHORT if waits(fault) else AMPLE))
        (outcome,) = (self.records.outcomes - before).elements()
        if not self.doubtful:
            assert outcome in outcomes(fault, method), (fault, outcome)
        self.proxy.clear()
        self.doubtful = fault is not None

    @rule(method=st.sampled_from(METHODS))
    def call_plainly_until_answered(self, method: str) -> None:
        """Whatever was, a lane that is left in peace works again after one call per connection."""
        if self.refusing or self.pending:
            return
        outcome = ""
        for _ in range(self.lane.statistics().connections + 1):
            before = self.records.outcomes
            self.portal.call(partial(self.records.follow, make(method), self.lane.call, AMPLE))
            (outcome,) = (self.records.outcomes - before).elements()
            if outcome == "answered":
                break
        assert outcome == "answered"
        self.doubtful = False

    @precondition(lambda self: len(self.pending) < 4)
    @rule(
        method=st.sampled_from(METHODS),
        fault=st.sampled_from([HalfOpen(), DropRequest(), HoldReply(), Delay(request=60.0)]),
    )
    def begin(self, method: str, fault: Fault) -> None:
        """A call that will not be answered, left under way."""
        self.proxy.on(method, fault)
        calls = self.lane.statistics().calls
        follow = partial(self.records.follow, make(method), self.lane.call, AMPLE)
        self.pending.append(self.portal.start_task_soon(follow))
        eventually(lambda: self.lane.statistics().calls > calls)
        self.doubtful = True

    @precondition(lambda self: self.pending)
    @rule(data=st.data())
    def cancel(self, data: st.DataObject) -> None:
        """A call that is cancelled leaves nothing behind."""
        future = self.pending.pop(data.draw(st.integers(0, len(self.pending) - 1)))
        future.cancel()
        self.doubtful = True
        if not self.pending:
            eventually(self.idle)
            if not self.refusing:
                self.proxy.clear()  # of a fault whose call was cancelled before it was sent

    def idle(self) -> bool:
        figures = self.lane.statistics()
        return figures.busy == figures.waiting == 0

    # What happens to connections

    @rule(how=st.sampled_from(Ending))
    def cut(self, how: Ending) -> None:
        self.proxy.cut(how)
        self.doubtful = True

    @precondition(lambda self: not self.refusing)
    @rule()
    def refuse(self) -> None:
        self.proxy.refuse()
        self.refusing = True

    @precondition(lambda self: self.refusing)
    @rule(method=st.sampled_from(METHODS))
    def call_in_vain(self, method: str) -> None:
        """With nobody listening, a call fails soon, or has a connection that is left."""
        self.portal.call(partial(self.records.follow, make(method), self.lane.call, SHORT))

    @precondition(lambda self: self.refusing)
    @rule()
    def accept(self) -> None:
        self.proxy.clear()
        self.refusing = False

    @invariant()
    def no_more_connections_than_allowed(self) -> None:
        if hasattr(self, "lane"):
            figures = self.lane.statistics()
            assert figures.connections <= 3
            assert figures.stuck == 0
            assert figures.busy <= figures.connections

    @invariant()
    def nothing_wrong_so_far(self) -> None:
        assert self.records.wrong == []


TestLane = LaneMachine.TestCase
TestLane.settings = settings(
    max_examples=examples(40),
    stateful_step_count=20,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)
