"""Any message of a page is a valid request or is refused, and other pages go on."""

from __future__ import annotations

import json

import pytest
from for_each import for_each
from hypothesis import example, given
from hypothesis import strategies as st

from aioduco.errors import ParameterError
from aioduco.integrations.panel.page_requests import LONGEST, PageStop, page_request

SIX = [0.1] * 6
JOG = {"kind": "jog", "axis": "x", "direction": 1, "percent": 10, "frame": "base"}
#: one message of each kind
MESSAGES: list[dict[str, object]] = [
    {"ask": "stop"},
    {"ask": "take", "token": "t"},
    {"ask": "give_back"},
    {"ask": "let_go"},
    {"ask": "beat", "seen": 3, "down": True},
    {"ask": "aim", "joints": SIX},
    {"ask": "do", "verb": "resume", "seen": 3},
    {"ask": "output", "num": 3, "on": False, "tool": True, "seen": 3},
    {"ask": "simulator", "line": "push 0 0 40"},
    {"ask": "measure", "step": "pose", "sensor": "force"},
    {"ask": "write", "what": "tip", "name": "pen"},
    {"ask": "press", "seen": 7, "motion": JOG},
    {"ask": "press", "seen": 7, "motion": {"kind": "line", "to": SIX, "percent": 1}},
]
KEYS = sorted({key for message in MESSAGES for key in message} | {*JOG, "to"})

values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.sampled_from(KEYS) | st.text(), inner),
    max_leaves=10,
)


@st.composite
def nearly_right(draw: st.DrawFn) -> bytes:
    """A message of which some values, or some bytes, are others."""
    message = dict(draw(st.sampled_from(MESSAGES)))
    message |= draw(st.dictionaries(st.sampled_from(KEYS), values, max_size=2))
    motion = message.get("motion")
    if isinstance(motion, dict):
        message["motion"] = motion | draw(st.dictionaries(st.sampled_from(KEYS), values))
    data = bytearray(json.dumps(message).encode())
    for at in draw(st.lists(st.integers(0, len(data) - 1), max_size=3)):
        data[at] = draw(st.integers(0, 255))
    return bytes(data)


@given(st.binary(max_size=200) | values.map(json.dumps) | nearly_right())
@example(b'{"ask": "press", "seen": 1, "motion": {"kind": "jog", "percent": 1%s}}' % (b"0" * 400))
@example(b'{"ask": "beat", "down": true, "seen": %s}' % (b"9" * 400))
@example(b"\xff")
def test_whatever_comes_is_a_request_or_is_refused(data: str | bytes) -> None:
    try:
        request = page_request(data)
    except ParameterError:
        return
    ask = json.loads(data)["ask"]
    assert (ask == "stop") == isinstance(request, PageStop)


@for_each("deep", [10, 300, 500, 700, 900, 940, 960, 980, 1000, LONGEST // 2 - 20])
def test_what_is_nested_however_deeply_is_refused(deep: int) -> None:
    with pytest.raises(ParameterError):
        page_request(f'{{"ask": {"[" * deep}{"]" * deep}}}')
