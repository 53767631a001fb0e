"""The call records detect each kind of wrong outcome."""

from __future__ import annotations

import random
from types import SimpleNamespace
from typing import Any

import pytest
from for_each import for_each

from .calls import CallRecords, make


@for_each(
    "method, outcome, arrived, true",
    [
        ("write_word_reg", "answered", 1, True),
        ("write_word_reg", "answered", 0, False),
        ("write_word_reg", "answered", 2, False),
        ("write_word_reg", "not sent", 1, False),
        ("write_word_reg", "unknown", 2, False),
        ("cal_fkine", "answered", 2, True),
        ("cal_fkine", "answered", 3, False),
    ],
)
def test_a_call_that_did_not_arrive_as_often_as_it_may_is_found(
    method: str, outcome: str, arrived: int, true: bool
) -> None:
    records, call = CallRecords(random.Random(1)), make(method)
    records.note(call, outcome)
    server: Any = SimpleNamespace(received=lambda: [call] * arrived)
    if true:
        records.check(server)
        return
    with pytest.raises(AssertionError, match=rf"\({outcome}\) arrived {arrived} times"):
        records.check(server)


def test_the_answer_to_another_call_and_one_that_is_late_are_found() -> None:
    records, call, other = CallRecords(random.Random(1)), make("cal_fkine"), make("cal_fkine")
    records.follow_blocking(call, lambda *_: other.answer, timeout=60.0)
    assert records.outcomes == {"answered": 1}
    records.follow_blocking(other, lambda *_: other.answer, timeout=-1.0)
    with pytest.raises(AssertionError, match=r"(?s)was answered by .* s longer than it may"):
        records.check(SimpleNamespace(received=lambda: [call, other]))  # type: ignore[arg-type]  # no server
