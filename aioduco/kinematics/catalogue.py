"""The arms that DUCO builds, by model."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any

from aioduco.errors import ParameterError
from aioduco.kinematics.arm import Arm
from aioduco.kinematics.geometry import LENGTHS, Geometry
from aioduco.models.rules import FARTHEST, Number
from aioduco.models.words import one_of

if TYPE_CHECKING:
    from collections.abc import Iterable


_LENGTH = Number(unit="m", plausible=FARTHEST, source="this package")


@cache
def _data() -> dict[str, Any]:
    text = (resources.files("aioduco.kinematics") / "arms.json").read_text(encoding="utf-8")
    return dict(json.loads(text)["models"])


def models() -> tuple[str, ...]:
    """Return the names of all models that `arm` accepts."""
    return tuple(_data())


@cache
def _model(name: str) -> Arm:
    data = _data()[name]
    return Arm(
        name=name,
        geometry=Geometry(**{length: data[length] for length in LENGTHS}),
        velocity=tuple(data["velocity"]),
        effort=tuple(data["effort"]),
        acceleration=tuple(data["acceleration"]),
        masses=tuple(data["masses"]),
        centres=tuple(tuple(centre) for centre in data["centres"]),
    )


def arm_given(name: str, given: object) -> Arm:
    """The arm of an argument that is one, or the name of a model.

    Raises:
        ParameterError: it is neither, or there is no such model.
    """
    if isinstance(given, str):
        return arm(given)
    if not isinstance(given, Arm):
        raise ParameterError(name, given, "an Arm, or the name of a model")
    return given


def model_named(name: str) -> Arm | None:
    """The model with the name that a controller reports; None if it is not known."""
    fitting = [model for model in models() if same_arm(model, name)]
    return _model(fitting[0]) if fitting else None


def arm_named(told: Iterable[str]) -> str:
    """Name of an arm in recordings and files of waypoints, from the type that a robot reports."""
    return " ".join(filter(None, [*told][:3]))


def same_arm(one: str, other: str) -> bool:
    """Whether two names are of one arm, such as "GCR5 910" of a controller and "gcr5_910"."""
    return _bare(one) == _bare(other)


def _bare(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.lower())


def arm(model: str, **lengths: float) -> Arm:
    """Return an arm by its model, with your own lengths if you have measured better ones.

    Args:
        model: the model's name, such as "gcr5_910" or "GCR5-910".
        lengths: lengths that replace the model's: d1, d2, a2, a3, d5, d6 [m], such as
            `arm("gcr5_910", d2=0.1411)`.

    Raises:
        ParameterError: there is no such model or length, or a length is no number.
    """
    name = model.lower().replace("-", "_") if isinstance(model, str) else model
    one_of("model", name, _data())
    for length in lengths:
        one_of("length", length, LENGTHS)
    values: dict[str, Any] = {length: _LENGTH(length, given) for length, given in lengths.items()}
    base = _model(name)
    if not lengths:
        return base
    return replace(base, geometry=base.geometry._replace(**values))
