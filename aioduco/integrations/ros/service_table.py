"""The services of an arm, in one table for every shell: names, types, and what each calls.

Where the driver of Universal Robots has a service, it has its name here, under
`dashboard_client`, `io_and_status_controller` and so on; `~` stands for the node's name.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterator

    from aioduco.integrations.ros.arm_services import ArmServices, ServiceReply

__all__ = ["ServiceEntry", "service_table"]


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


def service_table() -> Iterator[ServiceEntry]:
    """All services but `~stop`, which each shell serves on a thread of its own."""
    for name, function in _WITHOUT.items():
        yield ServiceEntry(name, "Trigger", _plain(function))
    for name, function in _WITH_TEXT.items():
        yield ServiceEntry(name, "SetText", _of_text(function))
    yield from _WITH_FIELDS


def _plain(function: str) -> Callable[[ArmServices, Any], Awaitable[ServiceReply]]:
    return lambda arm, _: getattr(arm, function)()


def _of_text(function: str) -> Callable[[ArmServices, Any], Awaitable[ServiceReply]]:
    return lambda arm, asked: getattr(arm, function)(asked.text)


_WITH_FIELDS = (
    ServiceEntry(
        "~set_digital_output",
        "SetOutput",
        lambda arm, asked: arm.set_digital_output(asked.number, asked.value),
    ),
    ServiceEntry(
        "~set_tool_output",
        "SetOutput",
        lambda arm, asked: arm.set_tool_output(asked.number, asked.value),
    ),
    ServiceEntry(
        "~set_analog_output",
        "SetAnalogOutput",
        lambda arm, asked: arm.set_analog_output(asked.number, asked.value, current=asked.current),
    ),
    ServiceEntry(
        "io_and_status_controller/set_io",
        "SetIO",
        lambda arm, asked: arm.set_io(asked.fun, asked.pin, asked.state),
    ),
    ServiceEntry("~set_speed", "SetSpeed", lambda arm, asked: arm.set_speed(asked.percent)),
    ServiceEntry(
        "io_and_status_controller/set_speed_slider",
        "SetSpeedFraction",
        lambda arm, asked: arm.set_speed(100.0 * asked.speed_slider_fraction),
    ),
    ServiceEntry(
        "~set_tool",
        "SetTool",
        lambda arm, asked: arm.set_tool(
            asked.name, list(asked.offset), asked.mass, list(asked.centre)
        ),
    ),
    ServiceEntry(
        "~set_load",
        "SetLoad",
        lambda arm, asked: arm.set_load(asked.mass, list(asked.centre)),
    ),
    ServiceEntry(
        "io_and_status_controller/set_payload",
        "SetLoad",
        lambda arm, asked: arm.set_load(asked.mass, list(asked.centre)),
    ),
    ServiceEntry(
        "force_mode_controller/start_force_mode",
        "StartForceMode",
        lambda arm, asked: arm.start_force_mode(
            list(asked.selection),
            list(asked.wrench),
            list(asked.damping),
            list(asked.speed_limits),
            asked.frame,
        ),
    ),
    ServiceEntry(
        "~movej", "MoveJ", lambda arm, asked: arm.movej(list(asked.joints), asked.v, asked.a)
    ),
    ServiceEntry(
        "~movel",
        "MoveL",
        lambda arm, asked: arm.movel(list(asked.pose), asked.v, asked.a, asked.tool, asked.wobj),
    ),
)
