"""Which functions may be sent twice: every function of the wire by name."""

from __future__ import annotations

from itertools import product
from pathlib import Path

from for_each import for_each

from aioduco._wire import idl
from aioduco._wire.failures import may_send_again
from aioduco._wire.idempotence import CallKind, call_kind
from aioduco._wire.lifecycle import Progress

_FILE = Path(__file__).parents[1] / "data" / "reads.txt"
READS = {
    name
    for line in _FILE.read_text("utf-8").splitlines()
    if not line.startswith("#")
    for name in line.split()
}


def test_every_function_has_the_kind_that_was_thought_about() -> None:
    kinds = {name: call_kind(name) for name in idl.functions()}
    assert len(kinds) == 226
    assert {name for name, its in kinds.items() if its is CallKind.READ} == READS
    assert {name for name, its in kinds.items() if its is CallKind.STOP} == {"stop"}


@for_each(
    "progress, name", product(Progress, ["movej2", "get_tcp_pose", "stop", "read_raw_data_485"])
)
def test_a_call_is_sent_again_only_if_the_first_did_nothing_more(
    name: str, progress: Progress
) -> None:
    again = may_send_again(idl.functions()[name], progress)
    if progress is Progress.NOTHING_SENT:
        assert again
    elif progress is Progress.ANSWERING:
        assert again is (name == "stop")
    else:
        assert again is (name in ("get_tcp_pose", "stop"))
