"""Kinds of rules: each checks one argument and turns it into what goes on the wire.

A rule is called with the parameter's name and the value. It returns the wire's value, or raises
`ParameterError` with the allowed range and its unit. The common case (a float, a list or a tuple
of floats, an array) takes a short path; whatever else is given goes the long way round.

Limits are part of a rule's face (`low`, `high`, `unit`, `length`, …), so that documents and tests
can read them. A bound that the manual prints as infinite is the largest finite float: NaN and
infinities never pass.
"""

from __future__ import annotations

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
    Vector,
    VectorLike,
    WholesLike,
)
from aioduco.models.rules.scalars import (
    Choice,
    Duration,
    Flag,
    Integer,
    Number,
    OrForever,
    Real,
    Rule,
    Text,
    Whole,
)

__all__ = [
    "BytesLike",
    "Choice",
    "Duration",
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
    "Vector",
    "VectorLike",
    "Whole",
    "WholesLike",
]
