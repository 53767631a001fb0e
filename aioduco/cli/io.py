"""`aioduco io`: inputs and outputs of the cabinet and of the tool."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Annotated

import typer

from aioduco.cli.addresses import CellFile, HostOption, Port, robot_at
from aioduco.cli.described import DescribedCommand
from aioduco.cli.exit_codes import ended_by_errors
from aioduco.cli.options import WITH_NUMBERS, Yes
from aioduco.cli.output import print_json, say
from aioduco.cli.questions import ask
from aioduco.cli.sessions import observing_session

if TYPE_CHECKING:
    from collections.abc import Sequence


io: typer.Typer = typer.Typer(
    name="io", no_args_is_help=True, help="Read inputs and outputs, and set outputs."
)

#: the signals of a sample, as `io read` names them
_DIGITAL = {
    "inputs": "digital_inputs",
    "outputs": "digital_outputs",
    "tool_inputs": "tool_inputs",
    "tool_outputs": "tool_outputs",
    "tool_buttons": "tool_buttons",
}
_ANALOG = {
    "voltages_in": ("analog_voltage_inputs", "V"),
    "voltages_out": ("analog_voltage_outputs", "V"),
    "currents_in": ("analog_current_inputs", "mA"),
    "currents_out": ("analog_current_outputs", "mA"),
}


class Level(enum.StrEnum):
    """Whether a signal is high."""

    ON = "on"
    OFF = "off"


class OutputQuantity(enum.StrEnum):
    """Quantity of an analogue output."""

    VOLTAGE = "voltage"
    CURRENT = "current"


@io.command(cls=DescribedCommand)
def read(
    host: HostOption = None,
    port: Port = None,
    cell: CellFile = None,
    json: bool = False,
) -> None:
    """Read all inputs and outputs. In JSON, number 1 comes first.

    aioduco io read --host left

    aioduco io read --json | jq '.inputs[2]'

    Exit codes: 0 read; 1 no controller; 2 wrong options.

    Args:
        json: Print them as JSON.
    """
    with observing_session(robot_at(host, port, cell)) as robot:
        found = robot.state.getRobotIOStatus()
    digital = {name: getattr(found, field) for name, field in _DIGITAL.items()}
    analog = {name: getattr(found, field) for name, (field, _) in _ANALOG.items()}
    if json:
        print_json(digital | analog)
        return
    for name, signals in digital.items():
        say(f"{name.replace('_', ' '):13} {_on(signals)}")
    for name, values in analog.items():
        unit = _ANALOG[name][1]
        say(f"{name.replace('_', ' '):13} {'  '.join(f'{v:.2f}' for v in values)} {unit}")


@io.command("set", cls=DescribedCommand, context_settings=WITH_NUMBERS)
def set_output(
    number: Annotated[int, typer.Argument(min=1, max=16)],
    level: Level,
    tool: bool = False,
    host: HostOption = None,
    port: Port = None,
    cell: CellFile = None,
    yes: Yes = False,
) -> None:
    """Switch a digital output. It asks first: a gripper may open.

    aioduco io set 3 on

    aioduco io set 1 off --tool --host left --yes

    Exit codes: 0 set; 1 not set, or no controller; 2 wrong options; 3 not confirmed.

    Args:
        number: Number of the output.
        level: on or off.
        tool: Use an output at the tool, 1 or 2.
    """
    from aioduco.models import ranges  # noqa: PLC0415 - for commands with a robot alone

    with ended_by_errors():
        (ranges.TOOL_IO if tool else ranges.STANDARD_IO)("number", number)
    address, high = robot_at(host, port, cell), level is Level.ON
    which = f"{'tool output' if tool else 'output'} {number}"
    ask(f"{which} at {address} goes {level.value}.", "Switch it?", yes=yes)
    with observing_session(address) as robot:
        section = robot.io
        (section.set_tool_digital_out if tool else section.set_standard_digital_out)(number, high)
    say(f"{which} is {level.value}")


@io.command("set-analog", context_settings=WITH_NUMBERS, cls=DescribedCommand)
def set_analog(
    quantity: OutputQuantity,
    number: Annotated[int, typer.Argument(min=1, max=4)],
    value: float,
    host: HostOption = None,
    port: Port = None,
    cell: CellFile = None,
    yes: Yes = False,
) -> None:
    """Set an analogue output of the cabinet. It asks first.

    aioduco io set-analog voltage 1 2.5

    Exit codes: as of `aioduco io set`.

    Args:
        quantity: voltage [V] or current [mA].
        number: Number of the channel.
        value: 0 to 10 V, or 4 to 20 mA.
    """
    from aioduco.models import ranges  # noqa: PLC0415 - for commands with a robot alone

    voltage = quantity is OutputQuantity.VOLTAGE
    with ended_by_errors():
        (ranges.VOLTAGE if voltage else ranges.CURRENT)("value", value)
    address = robot_at(host, port, cell)
    text = f"{quantity.value} output {number} at {address} goes to {value:g} "
    ask(text + ("V." if voltage else "mA."), "Set it?", yes=yes)
    with observing_session(address) as robot:
        if voltage:
            robot.io.set_standard_analog_voltage_out(number, value)
        else:
            robot.io.set_standard_analog_current_out(number, value)
    say(f"{quantity.value} output {number} is set")


def _on(signals: Sequence[bool]) -> str:
    """Numbers of the signals that are on."""
    return " ".join(str(number) for number, is_on in enumerate(signals, 1) if is_on) or "none on"
