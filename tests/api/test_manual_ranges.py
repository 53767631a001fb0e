"""Each range of the manual at both its ends and just beyond, through the functions themselves."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from for_each import for_each

from aioduco import ParameterError
from aioduco.models.rules import LONGEST_ARM
from api.cases import MANUAL, Case, cases, refusal

#: which elements of a vector a range is of
WHERE = {
    "linear": range(3),
    "angular": range(3, 6),
    "rotation": range(3, 6),
    "value": range(6),
    "mass": range(1),
}
#: the manual prints ranges of amounts here, the value has a sign
AMOUNTS = {("speedj", "joints_list"), ("speedl", "pose_list")}


def ranged() -> list[tuple[Case, str, dict[str, Any]]]:
    return [
        (case, ours, parameter)
        for case in cases()
        if case.name in MANUAL
        for ours in case.parameters
        for parameter in MANUAL[case.name]["parameters"]
        if parameter["name"] == case.manual_name(ours) and "ranges" in parameter
    ]


def changed(case: Case, name: str, index: int, value: float) -> Any:
    """The sample argument with one number in it changed."""
    sample = case.args[name]
    if isinstance(sample, (int, float)):
        return int(value) if isinstance(sample, int) and math.isfinite(value) else value
    if np.ndim(sample) == 2:
        return [[*list(sample[0])[:index], value, *list(sample[0])[index + 1 :]], *sample[1:]]
    return [*list(sample)[:index], value, *list(sample)[index + 1 :]]


@for_each("case, name, parameter", ranged())
def test_a_range(case: Case, name: str, parameter: dict[str, Any]) -> None:
    whole = isinstance(case.args[name], int)
    for printed in parameter["ranges"]:
        same = [one for one in parameter["ranges"] if one["of"] == printed["of"]]
        high = min(math.inf if one["high"] is None else one["high"] for one in same)
        low, low_open = printed["low"], printed["low_open"]
        if (case.name, parameter["name"]) in AMOUNTS:
            low, low_open = -high, False
        step = 1 if whole else 1e-6 * max(1.0, abs(low))
        # what reads like millimetres is refused beyond the manual's ranges
        large = LONGEST_ARM if parameter["name"] in {"r", "rad"} else 1e6
        inside = [low + step if low_open else low, min(high, large)]
        outside = [low if low_open else low - step, math.nan, math.inf]
        if high < math.inf:
            outside.append(high + (1 if whole else 1e-6 * high))
        for index in WHERE[printed["of"]]:
            for value in inside:
                assert refusal(case, **{name: changed(case, name, index, value)}) is None, value
            for value in outside:
                error = refusal(case, **{name: changed(case, name, index, value)})
                assert isinstance(error, ParameterError), value


def test_every_range_of_these_functions_is_here() -> None:
    functions = {case.name for case in cases()}
    printed = {
        (name, parameter["name"])
        for name, function in MANUAL.items()
        if name in functions
        for parameter in function["parameters"]
        if "ranges" in parameter
    }
    assert {(case.name, parameter["name"]) for case, _, parameter in ranged()} == printed
    assert len(printed) >= 64
