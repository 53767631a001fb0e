"""A driver's settings from parameters, with the same names in every shell. No I/O."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

from aioduco.errors import DucoError, ParameterError
from aioduco.integrations.ros.arm_node import NodeSettings
from aioduco.integrations.ros.trajectory_goals import GoalRules

_RULES = {"path": "path_tolerance", "goal": "goal_tolerance", "goal_time": "goal_time_tolerance"}
_RULES |= {"start": "start_tolerance", "max_stamp_age": "stamp_tolerance"}
_DEFAULTS = NodeSettings(host="-")
_COMMANDS = ("command_rate", "command_timeout", "hold_commands")  # need a topic of joint commands


class NodeError(DucoError):
    """The node could not be started; nothing was sent."""


def parameter_defaults() -> dict[str, Any]:
    """All parameters by name, with their defaults, without `robot_ip`, an alias of `host`."""
    found: dict[str, Any] = {
        each.name: getattr(_DEFAULTS, each.name) for each in fields(NodeSettings)
    }
    del found["rules"]
    found["host"] = ""
    return found | {said: getattr(GoalRules(), name) for name, said in _RULES.items()}


def settings_of(parameters: dict[str, Any], *, joint_commands: bool = True) -> NodeSettings:
    """The driver's settings from its parameters.

    Args:
        parameters: values by name. `robot_ip`, the manual's name of the launch argument, is an
            alias of `host`, and counts if that is empty. Tolerances of goals are `path_tolerance`,
            `goal_tolerance`, `goal_time_tolerance`, `start_tolerance` and `stamp_tolerance`.
        joint_commands: whether the shell takes joint commands; without them, the parameters of
            joint commands are unknown.

    Raises:
        ParameterError: a parameter is missing, unknown, of a wrong type or out of range.
    """
    given = dict(parameters)
    alias = given.pop("robot_ip", "")
    given["host"] = given.get("host") or alias
    known = parameter_defaults()
    if not joint_commands:
        known = {name: default for name, default in known.items() if name not in _COMMANDS}
    for name, value in given.items():
        if name not in known:
            raise ParameterError(name, value, f"one of {', '.join([*known, 'robot_ip'])}")
    if not given.get("host"):
        raise ParameterError("host", given.get("host"), "the controller's address")
    made = {name: _as(name, value, known[name]) for name, value in given.items()}
    kept = {name: made.pop(said) for name, said in _RULES.items() if said in made}
    try:
        rules = replace(GoalRules(), **kept)
    except ParameterError as error:
        raise ParameterError(_RULES[error.parameter], error.value, error.expected) from None
    return NodeSettings(**made, rules=rules)


def _as(name: str, value: Any, default: Any) -> Any:
    """A parameter in the type of its default."""
    if isinstance(default, tuple) and isinstance(value, (list, tuple)):
        return tuple(str(each) for each in value)
    if isinstance(default, float) and type(value) in (int, float):
        return float(value)
    if type(value) is type(default):
        return value
    kind = "list of texts" if isinstance(default, tuple) else type(default).__name__
    raise ParameterError(name, value, f"a {kind}")
