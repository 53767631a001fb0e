"""The services of an arm, in one table for every shell: names, types, and what each calls.

Where the driver of Universal Robots has a service, it has its name here, under
`dashboard_client`, `io_and_status_controller` and so on; `~` stands for the node's name.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterator

    from aioduco.integrations.ros.arm_services import ArmServices, ServiceReply


class ServiceEntry(NamedTuple):
    """A service.

    Attributes:
        name: its name; from the node's name if it begins with `~`, otherwise after the prefix.
        kind: its type: "Trigger" of std_srvs, or one of aioduco_msgs.
        call: answers a request.
    """

    name: str
    kind: str
    call: Callable[[ArmServices, Any], Awaitable[ServiceReply]]


#: those without arguments: name, and the function's
_WITHOUT = {
    "~bring_up": "bring_up",
    "~recover": "recover",
    "~pause": "pause",
    "~resume": "resume",
    "~disable": "disable",
    "dashboard_client/power_on": "power_on",
    "dashboard_client/power_off": "power_off",
    "dashboard_client/brake_release": "enable",
    "dashboard_client/unlock_protective_stop": "recover",
    "dashboard_client/play": "play",
    "dashboard_client/pause": "pause",
    "dashboard_client/stop": "stop",
    "dashboard_client/get_loaded_program": "loaded_program",
    "dashboard_client/program_state": "program_state",
    "dashboard_client/get_robot_mode": "robot_mode",
    "dashboard_client/get_safety_mode": "safety_mode",
    "io_and_status_controller/zero_ftsensor": "zero_sensor",
    "force_mode_controller/stop_force_mode": "stop_force_mode",
}
#: those with a text
_WITH_TEXT = {
    "dashboard_client/load_program": "load_program",
    "dashboard_client/popup": "popup",
    "dashboard_client/add_to_log": "add_to_log",
}


#: those with other fields: name, type, the function's, and its arguments: fields of the request
_WITH_FIELDS = (
    ("~set_digital_output", "SetOutput", "set_digital_output", "number value"),
    ("~set_tool_output", "SetOutput", "set_tool_output", "number value"),
    ("~set_analog_output", "SetAnalogOutput", "set_analog_output", "number value current"),
    ("io_and_status_controller/set_io", "SetIO", "set_io", "fun pin state"),
    ("~set_speed", "SetSpeed", "set_speed", "percent"),
    (
        "io_and_status_controller/set_speed_slider",
        *("SetSpeedFraction", "set_speed_fraction", "speed_slider_fraction"),
    ),
    ("~set_tool", "SetTool", "set_tool", "name offset mass centre"),
    ("~set_load", "SetLoad", "set_load", "mass centre"),
    ("io_and_status_controller/set_payload", "SetLoad", "set_load", "mass centre"),
    (
        "force_mode_controller/start_force_mode",
        *("StartForceMode", "start_force_mode", "selection wrench damping speed_limits frame"),
    ),
    ("~movej", "MoveJ", "movej", "joints v a"),
    ("~movel", "MoveL", "movel", "pose v a tool wobj"),
)


def service_table() -> Iterator[ServiceEntry]:
    """All services but `~stop`, which each shell serves on a thread of its own."""
    for name, function in _WITHOUT.items():
        yield ServiceEntry(name, "Trigger", _call(function))
    for name, function in _WITH_TEXT.items():
        yield ServiceEntry(name, "SetText", _call(function, "text"))
    for name, kind, function, fields in _WITH_FIELDS:
        yield ServiceEntry(name, kind, _call(function, *fields.split()))


def _call(function: str, *fields: str) -> Callable[[ArmServices, Any], Awaitable[ServiceReply]]:
    """What calls a function with fields of a request; arrays of ROS become lists."""

    def call(arm: ArmServices, asked: Any) -> Awaitable[ServiceReply]:
        given = (getattr(asked, field) for field in fields)
        plain = (each if isinstance(each, str | int | float) else list(each) for each in given)
        reply: Awaitable[ServiceReply] = getattr(arm, function)(*plain)
        return reply

    return call
