"""The table of calls: for each function of the wire a good call, and what is answered to bad ones.

`calls.json` has for each function

- `args`: a call that a controller with an enabled arm can do;
- `answer`: what it answers: a number, a kind of answer (see `KINDS`), or "id 4" for the id of a
  task that ends in state 4;
- `off`: the same without power; left out where it makes no difference;
- `short`: the same without what wrappers leave out (`layouts.left_out`); the id of a task in place
  of its end, if that is `block`;
- `bad`: by argument, the answer to values that make no sense, one for all or by kind of nonsense
  (see `nonsense`); an argument that is not there takes any value, and the answer is the usual one;
- `older`, `oldest`, `first`: what older clients are answered;
- `older_args`: what they send otherwise;
- `setup`, `after`: calls before each one, and after the last.

Functions that are not simulated are under `refused`, with what the text of the refusal says.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from aioduco._wire import idl

from . import layouts
from .clients import Lost, Refused

TABLE: dict[str, Any] = json.loads(Path(__file__).with_name("calls.json").read_text("utf-8"))
FUNCTIONS: dict[str, dict[str, Any]] = TABLE["functions"]
REFUSED: dict[str, str] = TABLE["refused"]

_FIRST_ID = 1000
#: six zero bytes of an answer are no proof of anything, so numbers are finite besides
KINDS: dict[str, Callable[[Any], bool]] = {
    "void": lambda a: a is None,
    "int": lambda a: type(a) is int,
    "bool": lambda a: type(a) is bool,
    "number": lambda a: type(a) is float and math.isfinite(a),
    "text": lambda a: isinstance(a, str),
    "texts": lambda a: _list(a, str),
    "bytes": lambda a: _list(a, int) and all(-128 <= one < 128 for one in a),
    "six": lambda a: _list(a, float) and len(a) == 6 and all(map(math.isfinite, a)),
    "four": lambda a: _list(a, float) and len(a) == 4 and all(map(math.isfinite, a)),
    "numbers": lambda a: _list(a, float) and all(map(math.isfinite, a)),
    "rows": lambda a: _list(a, list) and all(KINDS["numbers"](one) for one in a),
    "names": lambda a: isinstance(a, dict) and all(isinstance(v, int) for v in a.values()),
    "struct": lambda a: isinstance(a, dict) and bool(a),
    "structs": lambda a: _list(a, dict),
    "refused": lambda a: isinstance(a, Refused),
    "lost": lambda a: isinstance(a, Lost),
}


def _list(answer: Any, of: type) -> bool:
    return isinstance(answer, list) and all(isinstance(one, of) for one in answer)


def fits(expected: Any, answer: Any) -> bool:
    """Whether an answer is the one, or of the kind, that the table gives."""
    if isinstance(expected, str) and expected in KINDS:
        return bool(KINDS[expected](answer))
    return type(answer) is type(expected) and bool(answer == expected)


def _spec(name: str) -> dict[str, str]:
    fields = idl.functions()[name].args.thrift_spec.values()
    return {field[1]: layouts.type_of(field) for field in fields}


def nonsense(argument: str, of: str, good: Any) -> Iterator[tuple[str, Any]]:
    """Values of a type that make no sense as an argument, by kind."""
    least = {"i8": 7, "i16": 15, "i32": 31, "i64": 63}
    if of in least:
        bits = least[of]
        yield from (("least", -(2**bits)), ("most", 2**bits - 1))
    elif of == "double":
        yield from (("nan", math.nan), ("inf", math.inf), ("-inf", -math.inf))
        yield from (("huge", 1e300), ("-huge", -1e300))
    elif of == "string":
        yield from (("unknown", f"no such {argument}"), ("long", "x" * 300))
        yield "odd", f"\x07/../急停 {argument}\n"
    elif of == "list<double>":
        yield from (("none", []), ("short", good[:-1] or [0.0] * 5), ("long", [*good, *[0.1] * 7]))
        filled = good or [0.0] * 6
        yield from (("nan", [*filled[:-1], math.nan]), ("inf", [-math.inf, *filled[1:]]))
        yield "huge", [1e300] * len(filled)
    elif of in {"list<i8>", "list<i16>", "list<i32>"}:
        bits = least[of[5:-1]]
        yield from (("none", []), ("long", [1] * 40), ("least", [-(2**bits)] * max(1, len(good))))
    elif of == "list<bool>":
        yield from (("none", []), ("short", good[:-1]), ("long", [*good, True]))
    elif of == "list<list<double>>":
        yield from (("none", []), ("empty", [[]]), ("short", [*good, [0.1] * 3]))
        yield from (("nan", [[math.nan] * 6]), ("many", good * 1200))
    elif of == "list<robot.PointOp>":
        yield from (("none", []), ("empty", [{}]), ("short", [*good, {"pos": [0.1] * 3, "op": {}}]))
        yield from (("nan", [{"pos": [math.nan] * 6, "op": {}}]), ("many", good * 1200))
    elif of == "list<robot.RealTimeControlData>":
        yield from (("none", []), ("empty", [{}]), ("many", good * 1200))
        yield "nan", [{"joint_pos_cmd": [math.nan] * 6, "status": True}]
    elif of == "list<robot.Op>":
        yield from (("none", []), ("long", [{}] * 20))
    elif of == "robot.Op":
        yield "kind", {"time_or_dist_1": 9, "trig_io_1": 1}
        yield "output", {"time_or_dist_1": 1, "trig_io_1": 99}
        yield "event", {"time_or_dist_1": 1, "trig_event_1": "no such event"}
        yield "nan", {"time_or_dist_1": 1, "trig_io_1": 1, "trig_time_1": math.nan}
    elif of.startswith("robot."):
        yield "empty", {}
        for field, value in good.items():
            if isinstance(value, float):
                yield f"{field} nan", good | {field: math.nan}
            elif type(value) is int:
                yield f"{field} least", good | {field: -(2**31)}
    elif of != "bool":
        raise ValueError(f"no nonsense is known of {of}")


def bad_calls(name: str) -> Iterator[tuple[str, dict[str, Any], Any]]:
    """Calls of a function with one argument that makes no sense: (what, arguments, answer)."""
    row = FUNCTIONS[name]
    known, usual = row.get("bad", {}), row.get("answer")
    for argument, of in _spec(name).items():
        for kind, value in nonsense(argument, of, row["args"][argument]):
            answer = known.get(argument, usual)
            if isinstance(answer, dict):
                answer = answer.get(kind, answer.get("else", usual))
            yield f"{argument}: {kind}", row["args"] | {argument: value}, answer


def short_call(name: str) -> tuple[dict[str, Any], Any]:
    """The call without what wrappers leave out, and its answer."""
    out = layouts.left_out(name)
    row = FUNCTIONS[name]
    args = {argument: value for argument, value in row["args"].items() if argument not in out}
    usual = row.get("answer")
    if "block" in out and type(usual) is int:
        usual = f"id {usual}"  # it does not block
    return args, row.get("short", usual)


def older_call(service: str, name: str) -> tuple[dict[str, Any], Any]:
    """The call of an older client, and its answer."""
    row = FUNCTIONS[name]
    given: dict[str, Any] = row["args"]
    sent = [field for _, _, field in layouts.layouts()[service][name]]
    expected = row.get(service.lower(), row.get("answer", "refused"))
    return {field: row.get("older_args", {}).get(field, given[field]) for field in sent}, expected


def is_id(name: str, answer: Any) -> bool:
    """Whether an answer is the id of a task."""
    return type(answer) is int and answer >= _FIRST_ID and FUNCTIONS[name].get("answer") != "int"
