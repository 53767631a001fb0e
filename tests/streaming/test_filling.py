"""When the controller's queues are filled, and when they end: without clock and calls."""

from __future__ import annotations

from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco.streaming.shared.words import Reason, StreamState
from aioduco.streaming.worker.buffered import Depth, PoolAction, PoolStates

# -- the realtime queue ------------------------------------------------------------------------


@given(st.lists(st.integers(0, 200), min_size=1), st.integers(2, 150))
def test_a_queue_is_filled_to_its_depth_and_never_beyond(looks: list[int], depth: int) -> None:
    queue = Depth(depth, patience=1e9)
    for left in looks:
        wanted = queue.look(left, 0.0, 0.0)
        assert 0 <= wanted <= 100
        assert left + wanted <= max(left, depth)
        assert wanted == 100 or left + wanted >= depth
    assert queue.drained == looks.count(0)


def test_a_queue_from_which_nothing_is_taken_is_stuck_after_a_while() -> None:
    queue = Depth(40, patience=0.25)
    for now in (0.0, 0.1, 0.25):
        queue.look(40, now, now)
        assert not queue.stuck
    queue.look(40, 0.26, 0.26)
    assert queue.stuck


def test_a_queue_is_not_stuck_because_one_answer_took_long() -> None:
    queue = Depth(40, patience=0.25)
    queue.look(40, 0.0, 0.9)
    queue.look(40, 0.901, 1.8)
    assert not queue.stuck
    queue.look(40, 1.801, 1.802)
    assert queue.stuck


def test_a_queue_from_which_something_is_taken_now_and_then_is_not() -> None:
    queue = Depth(40, patience=0.25)
    for tick in range(100):
        queue.look(40 if tick % 2 else 39, 0.2 * tick, 0.2 * tick)
        assert not queue.stuck


def test_a_queue_ends_when_it_holds_nothing_but_rest() -> None:
    queue = Depth(10, patience=1.0)
    queue.rest(0)
    queue.rest(9)
    assert not queue.at_rest()
    queue.rest(1)
    assert queue.at_rest()
    assert not queue.at_rest(settling=1)


# -- the track pool ----------------------------------------------------------------------------


def following() -> PoolStates:
    pool = PoolStates(10, 50, hold=1.0)
    assert pool.may_begin(10, 256)
    pool.begin()
    return pool


@for_each(
    "waiting, capacity, closing, awaited, begins",
    [
        (9, 256, False, False, False),
        (10, 256, False, False, True),
        (5, 5, False, False, True),
        (1, 256, True, False, True),
        (1, 256, False, True, True),
        (0, 256, False, True, False),
    ],
)
def test_a_pool_begins_with_enough_points_or_all_of_them(
    waiting: int, capacity: int, closing: bool, awaited: bool, begins: bool
) -> None:
    pool = PoolStates(10, 50, hold=1.0)
    if closing:
        pool.close()
    assert pool.may_begin(waiting, capacity, awaited=awaited) is begins


def test_a_pool_closed_before_anything_came_ends() -> None:
    pool = PoolStates(10, 50, hold=1.0)
    pool.close()
    assert not pool.may_begin(0, 256)
    assert (pool.state, pool.reason) == (StreamState.ENDED, Reason.CLOSED)


def test_a_pool_is_filled_up_to_its_high_mark_when_below_its_low_one() -> None:
    pool = following()
    assert [pool.wanted(left) for left in (0, 9, 10, 50, 60)] == [50, 41, 0, 0, 0]


def test_a_pool_that_ran_dry_is_resumed_by_the_next_points() -> None:
    pool = following()
    assert pool.look(5, 0, 0.0) is PoolAction.FOLLOW
    assert pool.look(0, 0, 0.1) is PoolAction.WAIT
    assert pool.look(0, 0, 0.2) is PoolAction.WAIT
    assert (pool.state, pool.drained, pool.starved) == (StreamState.HOLDING, 1, 2)
    assert pool.look(0, 20, 0.3) is PoolAction.RESUME
    assert pool.state is StreamState.FOLLOWING
    assert pool.look(19, 0, 0.4) is PoolAction.FOLLOW
    assert pool.drained == 1


def test_a_pool_that_ran_dry_unseen_is_resumed() -> None:
    pool = following()
    assert pool.look(5, 0, 0.0) is PoolAction.FOLLOW
    assert pool.look(0, 20, 0.1) is PoolAction.RESUME  # it ran dry between two looks
    assert (pool.drained, pool.starved) == (1, 0)
    assert pool.look(18, 0, 0.2) is PoolAction.FOLLOW
    assert pool.look(2, 20, 0.3) is PoolAction.FOLLOW  # it runs dry before the points are in it
    assert pool.look(22, 0, 0.4) is PoolAction.RESUME
    assert pool.look(21, 0, 0.5) is PoolAction.FOLLOW


def test_a_pool_that_stays_dry_ends() -> None:
    pool = following()
    assert pool.look(0, 0, 5.0) is PoolAction.WAIT
    assert pool.look(0, 0, 6.0) is PoolAction.WAIT
    assert pool.look(0, 0, 6.1) is PoolAction.EMPTY
    assert (pool.state, pool.reason) == (StreamState.DECELERATING, Reason.STARVED)


def test_a_closed_pool_that_runs_dry_has_not_starved() -> None:
    pool = following()
    pool.close()
    assert pool.look(3, 0, 0.0) is PoolAction.FOLLOW
    assert pool.look(0, 0, 100.0) is PoolAction.FINISH
    assert (pool.drained, pool.starved) == (0, 0)


@given(st.lists(st.sampled_from(["close", "brake", "abort", "end", "look", "dry"])))
def test_there_is_no_way_back_from_the_end_and_the_first_reason_stays(steps: list[str]) -> None:
    pool = following()
    before, reason, now = pool.state, pool.reason, 0.0
    for step in steps:
        now += 0.5
        match step:
            case "close":
                pool.close()
            case "brake":
                pool.brake(Reason.STARVED)
            case "abort":
                pool.brake(Reason.ABORTED)
            case "end":
                pool.end(Reason.STOPPED)
            case "look" | "dry" if pool.state < StreamState.DECELERATING:
                pool.look(0 if step == "dry" else 5, 0, now)
        assert pool.state >= before or before is StreamState.HOLDING
        assert reason in (Reason.NONE, pool.reason)
        before, reason = pool.state, pool.reason
