"""A wrong argument of a stream is refused when the stream is made, whatever the argument."""

from __future__ import annotations

import inspect
import math
from typing import Any

import pytest
from for_each import for_each

import aioduco
from aioduco import ParameterError, RealtimeMode
from aioduco._wire import idl
from aioduco.streaming.shared.block import Block
from aioduco.streaming.shared.words import Reason, StatusWord

NOBODY = aioduco.connect("192.0.2.1")
#: what each function that makes a stream needs at least
NEEDED: dict[tuple[str, str], dict[str, Any]] = {
    ("motion", "path"): {},
    ("servo", "joints"): {"v": 1.0, "a": 1.0},
    ("servo", "pose"): {"v": 1.0, "a": 1.0},
    ("servo", "linear"): {"v": 1.0, "a": 1.0},
    ("servo", "tcp_offset"): {"v": 1.0, "a": 1.0},
    ("speed", "joints"): {"a": 1.0},
    ("speed", "linear"): {"a": 1.0},
    ("track", "stream"): {"space": "joints", "speed": 1.0, "acc": 1.0},
    ("realtime", "stream"): {"mode": RealtimeMode.JOINT_POSITION, "v": 1.0, "a": 1.0},
}
#: no parameter takes any of these
NEVER: tuple[Any, ...] = (math.nan, math.inf, -math.inf, -1.0, 1j, {}, [1.0] * 7, [[1.0]])
NUMBERS: tuple[Any, ...] = ("1", True, b"1", [math.nan] * 6, [True] * 6)
#: texts and flags take what is no number
TEXTS = {"tool", "wobj"}
FLAGS = {"latest", "operations"}


def made_here() -> list[tuple[str, str]]:
    """Each public function of a section that is not on the wire and makes something at once."""
    public = {name: part for name, part in vars(NOBODY).items() if not name.startswith("_")}
    found = []
    for section, part in public.items():
        for name, function in inspect.getmembers(part, inspect.ismethod):
            wire = name in idl.functions()
            awaited = inspect.iscoroutinefunction(inspect.unwrap(function))
            if not name.startswith("_") and not wire and not awaited:
                found.append((section, name))
    return found


def test_every_stream_is_here() -> None:
    assert set(made_here()) == set(NEEDED)


def parameters(section: str, name: str) -> list[str]:
    """Those that are written out in the signature."""
    signature = inspect.signature(getattr(getattr(NOBODY, section), name))
    return [each.name for each in signature.parameters.values() if each.kind != each.VAR_KEYWORD]


#: keywords that several have, from `ServoOptions` and `FeedingOptions`
FED = ["source_rate", "latest", "upsample", "hold", "ahead"]
PARAMETERS = [
    *[(*function, parameter) for function in NEEDED for parameter in parameters(*function)],
    *[("servo", name, each) for name in ("joints", "pose") for each in [*FED, "rate"]],
    *[("realtime", "stream", each) for each in FED],
]


@for_each("section, name, parameter", PARAMETERS)
def test_a_wrong_argument_is_refused(section: str, name: str, parameter: str) -> None:
    make = getattr(getattr(NOBODY, section), name)
    needed = NEEDED[section, name]
    make(**needed)
    others: tuple[Any, ...] = NUMBERS
    if parameter in TEXTS:
        others = (1, True, b"1", "x" * 33)
    elif parameter in FLAGS:
        others = (1, 0, "True", None)
    for value in (*NEVER, *others):
        with pytest.raises(ParameterError) as raised:
            make(**needed | {parameter: value})
        assert raised.value.parameter.partition("[")[0] == parameter
        assert str(raised.value).endswith("nothing was sent")


@pytest.mark.parametrize("shared", [False, True])
def test_a_block_is_released_while_another_thread_has_a_view_of_it(shared: bool) -> None:
    """As the watchdog of a slow event loop has the variables of the line that it tells."""
    block = Block.make(NOBODY.servo.joints(v=1.0, a=5.0)._session._config, shared=shared)
    kept = block.status[:1]
    block.close()
    assert kept[0] == 0


def test_what_a_stopping_controller_refuses_ends_by_the_stop() -> None:
    """A set-point may be on its way when the robot is stopped."""
    reasons = []
    for before in (Reason.REFUSED, Reason.NONE):
        session = NOBODY.servo.joints(v=1.0, a=5.0)._session
        session.block = Block.make(session._config, shared=False)
        session.block.status[StatusWord.REASON] = before
        session.halt()
        session.block.status[StatusWord.REASON] = Reason.REFUSED
        reasons.append(session.reason)
        session.block.close()
    assert reasons == [Reason.REFUSED, Reason.STOPPED]
