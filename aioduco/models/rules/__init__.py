"""Kinds of rules: each checks one argument and converts it to its value on the wire.

A rule is called with the parameter's name and the value. It returns the value on the wire, or
raises `ParameterError` with the allowed range and its unit. The common case (a float, a list or a
tuple of floats, an array) takes a fast path; all other values take a slower one.

Limits are public attributes of a rule (`low`, `high`, `unit`, `length`, …), so that documents and
tests can read them. A bound that the manual prints as infinite is the largest finite float: NaN and
infinities never pass.
"""

from __future__ import annotations

from aioduco.models.numpy_on_use import is_number
from aioduco.models.rules.lists import (
    BytesLike,
    Flags,
    FlagsLike,
    Integers,
    JointsRule,
    OrCurrent,
    Points,
    PoseRule,
    Signed,
    Texts,
    Vector,
    VectorLike,
    WholesLike,
)
from aioduco.models.rules.scalars import (
    Choice,
    Duration,
    FileName,
    Flag,
    Integer,
    Number,
    OrForever,
    Real,
    Rule,
    Text,
    Whole,
    condition_holds,
    is_whole,
    stored,
)

__all__ = [
    "BytesLike",
    "Choice",
    "Duration",
    "FileName",
    "Flag",
    "Flags",
    "FlagsLike",
    "Integer",
    "Integers",
    "JointsRule",
    "Number",
    "OrCurrent",
    "OrForever",
    "Points",
    "PoseRule",
    "Real",
    "Rule",
    "Signed",
    "Text",
    "Texts",
    "Vector",
    "VectorLike",
    "Whole",
    "WholesLike",
    "condition_holds",
    "is_number",
    "is_whole",
    "stored",
]
