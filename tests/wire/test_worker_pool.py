"""The pool's decisions, through every order of calls, ends, refusals and losses."""

from __future__ import annotations

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from quick import examples

from aioduco._wire.worker_pool import WorkerPool


class Worker:
    def __init__(self) -> None:
        self.call: Call | None = None
        self.claimed = False

    def claim(self, _call: object) -> bool:
        free = not self.claimed
        self.claimed = True
        return free


class Call:
    def __init__(self, number: int) -> None:
        self.number = number
        self.settled = False


class PoolMachine(RuleBasedStateMachine):
    """The pool beside a list of what it should do."""

    @initialize(size=st.integers(1, 4))
    def make(self, size: int) -> None:
        self.made: list[Worker] = []
        self.pool: WorkerPool[Worker, Call] = WorkerPool(size, self._make)
        self.queue: list[Call] = []
        self.calls = 0
        self.begun: list[int] = []
        self.stolen: list[Worker] = []
        #: whether a worker was freed since the pool last assigned
        self.unnoticed = False

    def _make(self) -> Worker:
        worker = Worker()
        self.made.append(worker)
        return worker

    def _begin(self, worker: Worker, call: Call) -> None:
        assert worker.claimed
        assert worker.call is None
        assert not call.settled
        worker.call = call
        self.begun.append(call.number)

    def _assign(self) -> None:
        self.unnoticed = False
        for worker, call in self.pool.assign():
            self._drop_refused()
            assert self.queue.pop(0) is call
            self._begin(worker, call)
        self._drop_refused()

    def _drop_refused(self) -> None:
        while self.queue and self.queue[0].settled:
            self.queue.pop(0)

    def _busy(self) -> list[Worker]:
        return [worker for worker in self.pool.workers if worker.call is not None]

    @rule()
    def call(self) -> None:
        call = Call(self.calls)
        self.calls += 1
        worker = self.pool.take(call)
        if worker is None:
            self.queue.append(call)
            self._assign()
        else:
            assert not [other for other in self.queue if not other.settled]
            self._begin(worker, call)

    @precondition(lambda self: self._busy())
    @rule(data=st.data())
    def end(self, data: st.DataObject) -> None:
        worker = data.draw(st.sampled_from(self._busy()))
        worker.call = None
        worker.claimed = False
        self._assign()

    @precondition(lambda self: self._busy())
    @rule()
    def end_unnoticed(self) -> None:
        """A thread is done, and its notice is still on the way to the loop."""
        worker = self._busy()[0]
        worker.call = None
        worker.claimed = False
        self.unnoticed = True

    @precondition(lambda self: self.unnoticed)
    @rule()
    def notice(self) -> None:
        self._assign()

    @precondition(lambda self: self.queue)
    @rule(data=st.data())
    def refuse(self, data: st.DataObject) -> None:
        """A caller is cancelled and the pool finds out by itself."""
        data.draw(st.sampled_from(self.queue)).settled = True

    @precondition(lambda self: self.queue)
    @rule(data=st.data())
    def forget(self, data: st.DataObject) -> None:
        """A caller is cancelled and says so."""
        call = data.draw(st.sampled_from(self.queue))
        self.queue.remove(call)
        assert self.pool.forget(call)
        assert not self.pool.forget(call)

    @precondition(lambda self: self._busy())
    @rule(data=st.data())
    def discard(self, data: st.DataObject) -> None:
        """A worker hangs, and another takes its place."""
        worker = data.draw(st.sampled_from(self._busy()))
        assert self.pool.discard(worker)
        assert not self.pool.discard(worker)
        self._assign()

    @precondition(lambda self: any(not worker.claimed for worker in self.pool.workers))
    @rule()
    def steal(self) -> None:
        """A signal handler takes a worker past the pool."""
        worker = next(worker for worker in self.pool.workers if worker.claim(self))
        self.stolen.append(worker)

    @precondition(lambda self: self.stolen)
    @rule()
    def give_back(self) -> None:
        self.stolen.pop().claimed = False
        self._assign()

    @rule()
    def drain(self) -> None:
        assert self.pool.drain() == self.queue
        self.queue.clear()

    @invariant()
    def never_more_than_its_size(self) -> None:
        assert len(self.pool.workers) <= self.pool.size

    @invariant()
    def nobody_waits_beside_a_free_worker(self) -> None:
        if not self.unnoticed and any(not call.settled for call in self.queue):
            assert len(self.pool.workers) == self.pool.size
            assert all(worker.claimed for worker in self.pool.workers)

    @invariant()
    def calls_begin_in_the_order_in_which_they_came(self) -> None:
        assert self.begun == sorted(self.begun)

    @invariant()
    def the_queue_is_what_it_should_be(self) -> None:
        assert self.pool.waiting == len(self.queue)


PoolMachine.TestCase.settings = settings(
    max_examples=examples(60), stateful_step_count=40, deadline=None
)
TestPool = PoolMachine.TestCase


def test_a_light_load_keeps_to_one_worker() -> None:
    pool: WorkerPool[Worker, Call] = WorkerPool(4, Worker)
    for number in range(10):
        worker = pool.take(Call(number))
        assert worker is not None
        worker.claimed = False
    assert len(pool.workers) == 1
