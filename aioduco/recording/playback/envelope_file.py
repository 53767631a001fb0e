"""Limits of an arm in a TOML file: an operating envelope that is not part of a program.

    arm = "gcr5_910"

    [[limit]]
    kind = "plane"
    point = [0, 0, 0.02]
    normal = [0, 0, 1]
    name = "table"

    [[limit]]
    kind = "tool_speed"
    most = 0.5
    action = "slow"

The fields are the arguments of `Zone.box`, `Zone.sphere`, `Zone.plane`, `ToolSpeed`, `JointMargin`,
`SingularityMargin` and `ToolForce`, in their units: metres, radians, newtons.
"""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any, Final

from aioduco.envelope import (
    Envelope,
    EnvelopeLimit,
    JointMargin,
    SingularityMargin,
    ToolForce,
    ToolSpeed,
    Zone,
)
from aioduco.errors import ParameterError
from aioduco.models.similar import did_you_mean
from aioduco.models.toml_files import read_toml
from aioduco.models.words import one_of

if TYPE_CHECKING:
    import os
    from collections.abc import Callable


_KINDS: Final[dict[str, Callable[..., EnvelopeLimit]]] = {
    "box": Zone.box,
    "sphere": Zone.sphere,
    "plane": Zone.plane,
    "tool_speed": ToolSpeed,
    "joint_margin": JointMargin,
    "singularity_margin": SingularityMargin,
    "tool_force": ToolForce,
}


def read_envelope(path: str | os.PathLike[str], *, arm: str | None = None) -> Envelope:
    """Read an operating envelope from a TOML file.

    Args:
        path: the file.
        arm: name of the arm's model; None for the `arm` of the file.

    Returns:
        The envelope, for `robot.envelope`.

    Raises:
        ParameterError: the file cannot be read, or a field is wrong; the message names it.
    """
    try:
        found = read_toml(path)
    except OSError as exc:
        raise ParameterError("envelope", str(path), f"a file that can be read: {exc}") from exc
    except ValueError as exc:
        raise ParameterError("envelope", str(path), f"TOML: {exc}") from exc
    told = found.pop("arm", None)
    model = told if arm is None else arm
    blocks = found.pop("limit", [])
    if found:
        raise ParameterError("envelope", ", ".join(found), "`arm` and blocks of [[limit]] alone")
    if not isinstance(model, str):
        raise ParameterError("arm", model, "the name of a model, in the file or given")
    if arm is not None and told is not None and told != arm:
        raise ParameterError("arm", told, f"{arm!r}, or left out of the file")
    if not isinstance(blocks, list) or not blocks:
        raise ParameterError("limit", blocks, "one block of [[limit]] or more")
    return Envelope(
        model, *(limit_of(f"limit {number}", block) for number, block in enumerate(blocks, 1))
    )


def limit_of(where: str, block: Any) -> EnvelopeLimit:
    """The limit in a block of a file.

    Args:
        where: what the block is called in errors.
        block: the block, as read from TOML.

    Raises:
        ParameterError: a field is wrong; the message names it.
    """
    if not isinstance(block, dict):
        raise ParameterError(where, block, "a block of [[limit]]")
    fields = dict(block)
    kind = one_of(f"kind of {where}", fields.pop("kind", None), _KINDS)
    known = inspect.signature(_KINDS[kind]).parameters
    for name, value in fields.items():
        if name not in known:
            expected = f"one of the fields {', '.join(known)}{did_you_mean(name, known)}"
            raise ParameterError(f"{name} of {where}", value, expected)
    try:
        return _KINDS[kind](**fields)
    except TypeError as exc:  # a missing field
        raise ParameterError(f"{where}, {kind}", fields, f"what it takes: {exc}") from exc
    except ParameterError as exc:
        raise ParameterError(f"{exc.parameter} of {where}", exc.value, exc.expected) from exc
