"""The rules that check an argument: what they take at their edges, and what they refuse."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import hypothesis.strategies as st
import pytest
from hypothesis.strategies import SearchStrategy

from aioduco.models import rules
from api.cases import Case, refusal

#: the longest list that is tried out at the edge of its length
LONGEST = 2000
#: how far beyond a bound a number is too far: nearer ones are rounding, and put back onto it
BEYOND = 1e-6


def rules_of(case: Case) -> dict[str, tuple[rules.Rule, ...]]:
    """The rules that a good call of a function asks, by parameter."""
    if case.name not in _found:
        _found[case.name] = _asked(case)
    return _found[case.name]


_found: dict[str, dict[str, tuple[rules.Rule, ...]]] = {}


def _asked(case: Case) -> dict[str, tuple[rules.Rule, ...]]:
    asked: dict[str, list[rules.Rule]] = {}
    exported = [kind for kind in vars(rules).values() if isinstance(kind, type)]
    kinds = {kind for each in exported for kind in each.mro()}  # a base may hold the check
    with pytest.MonkeyPatch.context() as patch:
        for kind in kinds:
            if issubclass(kind, rules.Rule) and "__call__" in vars(kind):
                patch.setattr(kind, "__call__", _noting(vars(kind)["__call__"], asked))
        assert refusal(case) is None
    return {name: tuple(asked.get(name, ())) for name in case.parameters}


def _noting(check: Any, asked: dict[str, list[rules.Rule]]) -> Any:
    def noting(rule: rules.Rule, name: str, value: Any) -> Any:
        if rule not in asked.setdefault(name, []):
            asked[name].append(rule)
        return check(rule, name, value)

    return noting


# -- what a rule takes at its edges ----------------------------------------------------------------


def edges(rule: Any, sample: Any) -> Iterator[Any]:
    """The values at the edges of a rule."""
    match rule:
        case rules.Number():
            yield from _ends(rule)
        case rules.Integer():
            yield from (rule.low, rule.high)
        case rules.Duration():
            yield from (rule.low, rule.high)
        case rules.OrForever():
            yield from (None, rule.rule.low, rule.rule.high)
        case rules.Choice():
            yield from rule.choices
        case rules.Flag():
            yield from (True, False)
        case rules.Text():
            yield "x" * rule.min_bytes
            if rule.max_bytes is not None:
                yield "x" * rule.max_bytes
        case rules.Vector():
            count = rule.length or len(sample)
            elements = rule.element if rule.length is not None else rule.element * count
            for end in (0, 1):
                yield [_ends(element)[end] for element in elements]
        case rules.OrCurrent():
            yield from (None, [], *edges(rule.rule, sample))
        case rules.Points():
            points = list(sample)
            for count in (rule.low, rule.high):
                if count <= LONGEST:
                    yield [points[0]] * count
            yield from ([point, *points[1:]] for point in edges(rule.element, points[0]))
        case rules.Integers():
            count = rule.length or len(sample)
            yield from ([end] * count for end in edges(rule.element, sample[0]))
        case rules.Flags():
            yield from ([end] * len(sample) for end in (True, False))
        case rules.Signed():
            count = max(rule.min_length, 1)
            yield from ([rule.low] * count, [rule.high] * count)
            yield [rule.high] * rule.min_length
        case _:
            raise TypeError(f"no edges are known here of {rule!r}")


def _ends(rule: rules.Number) -> tuple[float, float]:
    """The lowest and the highest value; large ones where the rule has no bound."""
    low = math.nextafter(rule.low, math.inf) if rule.open_low else rule.low
    return max(low, -1e9, -rule.plausible), min(rule.high, 1e9, rule.plausible)


# -- what it refuses -------------------------------------------------------------------------------

#: what no rule takes
NEVER: tuple[Any, ...] = (object(), 1j, {}, Ellipsis, lambda: None, "\ud800")
NOT_FINITE = st.sampled_from((math.nan, math.inf, -math.inf))
NO_NUMBER = st.one_of(st.none(), st.text(), st.booleans(), st.just([1.0]), st.sampled_from(NEVER))
NO_WHOLE = NO_NUMBER | NOT_FINITE | st.floats()
NO_LIST = st.one_of(st.text(), st.integers(), st.floats(), st.booleans(), st.sampled_from(NEVER))


def wrong(rule: Any, sample: Any) -> SearchStrategy[Any]:
    """Values that a rule refuses."""
    match rule:
        case rules.Number():
            return _outside(rule.low, rule.high, open_low=rule.open_low)
        case rules.Duration():
            return _outside(rule.low, rule.high)
        case rules.OrForever():
            return wrong(rule.rule, sample).filter(lambda value: value is not None)
        case rules.Integer():
            return (
                NO_WHOLE
                | st.integers(max_value=rule.low - 1)
                | st.integers(min_value=rule.high + 1)
            )
        case rules.Choice():
            return NO_WHOLE | st.integers().filter(lambda number: number not in rule.choices)
        case rules.Flag():
            return (
                NO_NUMBER.filter(lambda value: not isinstance(value, bool))
                | st.integers()
                | st.floats()
            )
        case rules.Text():
            values = st.one_of(
                st.none(),
                st.integers(),
                st.floats(),
                st.booleans(),
                st.binary(),
                st.sampled_from(NEVER),
            )
            if rule.max_bytes is not None:
                values |= st.text(min_size=rule.max_bytes + 1)
                values |= st.just("抓" * (rule.max_bytes // 3 + 1))
            if rule.one_line:
                values |= st.sampled_from(["a\nb", "a\0", "\x1b[2J", "a\u202eb", "\u2028"])
            return values | st.just("") if rule.min_bytes else values
        case rules.Vector():
            good = [float(value) for value in sample]
            if rule.length is None:
                return NO_LIST | st.none() | _spoilt(good, wrong(rule.element[0], good[0]))
            spoilt = [
                st.builds(_with, st.just(good), st.just(at), wrong(element, good[at]))
                for at, element in enumerate(rule.element)
            ]
            lengths = st.sampled_from([good[:-1], [*good, 0.0], [*good, *good], [good]])
            return st.one_of(NO_LIST, st.none(), st.just({*good}), lengths, *spoilt)
        case rules.OrCurrent():
            return wrong(rule.rule, sample).filter(lambda value: value is not None)
        case rules.Points():
            points = [list(point) for point in sample]
            counts = [count for count in (rule.low - 1, rule.high + 1) if 0 <= count <= LONGEST]
            wrongs = NO_LIST | st.none() | _spoilt(points, wrong(rule.element, points[0]))
            return (
                wrongs | st.sampled_from([points[:1] * count for count in counts])
                if counts
                else wrongs
            )
        case rules.Integers():
            good = [int(value) for value in sample]
            wrongs = NO_LIST | st.none() | _spoilt(good, wrong(rule.element, good[0]))
            return wrongs | st.just([*good, good[0]]) if rule.length is not None else wrongs
        case rules.Flags():
            good = list(sample)
            lengths = st.sampled_from([good[:-1], [*good, True]])
            return (
                NO_LIST
                | st.none()
                | lengths
                | _spoilt(good, st.integers() | st.floats() | st.none())
            )
        case rules.Signed():
            good = [rule.low] * max(rule.min_length, 1)
            wrongs = (
                NO_LIST
                | st.none()
                | _spoilt(good, wrong(rules.Integer(rule.low, rule.high, source=""), 0))
            )
            return wrongs | st.just(good[: rule.min_length - 1]) if rule.min_length else wrongs
        case _:
            raise TypeError(f"it is not known here what {rule!r} refuses")


def _outside(low: float, high: float, *, open_low: bool = False) -> SearchStrategy[Any]:
    """Numbers beyond bounds, and what is no number."""
    values = NO_NUMBER | NOT_FINITE
    if low > -math.inf:
        values |= st.floats(max_value=low - BEYOND * max(1.0, abs(low)))
    if high < math.inf:
        values |= st.floats(min_value=high + BEYOND * max(1.0, abs(high)))
    return values | st.just(low) if open_low else values


def _with(good: list[Any], at: int, bad: Any) -> list[Any]:
    """A good list with one bad element."""
    return [*good[:at], bad, *good[at + 1 :]]


def _spoilt(good: list[Any], bad: SearchStrategy[Any]) -> SearchStrategy[Any]:
    """Good lists with one bad element each."""
    return st.builds(_with, st.just(good), st.integers(0, len(good) - 1), bad)
