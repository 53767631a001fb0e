"""Buses, inputs and outputs, registers, variables: manual sections 1.3.6 and 1.3.7."""

from __future__ import annotations

from typing import Any

import numpy as np

from aioduco import OutputMode
from aioduco.api.bus import CanFrame
from api.cases import Case


def call(section: str, name: str, args: dict[str, Any], *wire: Any, **rest: Any) -> Case:
    return Case(section, name, args, wire, **rest)


def frozen(*values: Any) -> Any:
    """A read-only array."""
    array = np.array(values)
    array.flags.writeable = False
    return array


#: as bytes, and as the signed numbers of the wire
DATA, SIGNED = b"\x01\x7f\x80\xff", [1, 127, -128, -1]
HEAD, HEAD_SIGNED = bytearray(b"\xff\x01"), [-1, 1]
TAIL, TAIL_SIGNED = [13, 200], [13, -56]
READ: dict[str, Any] = {"answer": SIGNED, "result": DATA}
WRITE: dict[str, Any] = {"answer": True}


def port(prefix: str) -> list[Case]:
    """The functions of one RS-485 port."""
    ends = {"head": HEAD, "tail": TAIL}
    return [
        call("bus", f"{prefix}read_raw_data_485", {"len": 8}, 8, **READ),
        call(
            *("bus", f"{prefix}read_raw_data_485_h", {"head": HEAD, "len": 10}),
            *(HEAD_SIGNED, 10),
            **READ,
        ),
        call("bus", f"{prefix}read_raw_data_485_ht", ends, HEAD_SIGNED, TAIL_SIGNED, **READ),
        call("bus", f"{prefix}write_raw_data_485", {"data": DATA}, SIGNED, **WRITE),
        call(
            *("bus", f"{prefix}write_raw_data_485_h", {"data": DATA, "head": HEAD}),
            *(SIGNED, HEAD_SIGNED),
            **WRITE,
        ),
        call(
            *("bus", f"{prefix}write_raw_data_485_ht", {"data": DATA, **ends}),
            *(SIGNED, HEAD_SIGNED, TAIL_SIGNED),
            **WRITE,
        ),
        call("bus", f"{prefix}read_data_485", {}, **READ),
        call("bus", f"{prefix}write_data_485", {"data": DATA}, SIGNED, **WRITE),
    ]


BUSES = [
    call("bus", "set_baudrate_485", {"value": 115200}, 115200, True),
    *port(""),
    *port("tool_"),
    call("bus", "set_baudrate_can", {"value": 500000}, 500000, True),
    call("bus", "read_raw_data_can", {}, answer=[-1, *SIGNED], result=CanFrame(255, DATA)),
    call("bus", "write_raw_data_can", {"id": 0x123, "data": DATA}, 0x123, SIGNED, **WRITE),
    call("bus", "read_data_can", {}, **READ),
    call("bus", "write_data_can", {"id": 0x123, "data": DATA}, 0x123, SIGNED, **WRITE),
]
SIGNALS = [
    call("io", "get_config_digital_in", {"num": 3}, 3, answer=True, result=True),
    call(
        *("io", "set_digital_output_mode"),
        {"num": 16, "type": OutputMode.PULSES, "freq": 10, "duty_cycle": 20},
        *(16, 1, 10, 20),
    ),
    call("io", "set_standard_analog_voltage_out", {"num": 4, "value": 2.5}, 4, 2.5, True),
    call("io", "set_standard_analog_current_out", {"num": 4, "value": 12.5}, 4, 12.5, True),
    call("io", "set_analog_output_mode", {"num": 2, "mode": 1}, 2, 1, True),
    *(
        call("io", f"get_{name}_in", {"num": 2}, 2, answer=3.5, result=3.5)
        for name in (
            *("standard_analog_voltage", "standard_analog_current", "tool_analog_voltage"),
        )
    ),
]
VALUES: list[tuple[str, Any, Any]] = [
    ("bool", True, True),
    ("double", 1.5, 1.5),
    ("str", "blue", "blue"),
    ("list", [1.0, 2.5], frozen(1.0, 2.5)),
]
REGISTERS = [
    call("registers", "write_bool_reg", {"num": 64, "value": True}, 64, True),
    call("registers", "write_word_reg", {"num": 32, "value": 65535}, 32, 65535),
    call("registers", "write_float_reg", {"num": 32, "value": -1.5}, 32, -1.5),
    call("registers", "read_bool_reg", {"num": 64}, 64, answer=True, result=True),
    call("registers", "read_word_reg", {"num": 32}, 32, answer=1200, result=1200),
    call("registers", "read_float_reg", {"num": 32}, 32, answer=2.5, result=2.5),
    call("registers", "get_function_reg_in", {"num": 16}, 16, answer=True, result=True),
    call("registers", "get_function_reg_out", {"num": 16}, 16, answer=True, result=True),
    *(
        call(
            *("registers", f"set_system_value_{kind}", {"name": "cell.x", "value": value}),
            *("cell.x", value),
            answer=0,
        )
        for kind, value, _ in VALUES
    ),
    *(
        call(
            *("registers", f"get_system_value_{kind}", {"name": "cell.x"}, "cell.x"),
            answer=value,
            result=result,
        )
        for kind, value, result in VALUES
    ),
    call(
        *("registers", "get_system_value_lists", {"name": "cell.x"}, "cell.x"),
        answer=[[1.0, 2.0], [3.0]],
        result=(frozen(1.0, 2.0), frozen(3.0)),
    ),
]
CASES = [*BUSES, *SIGNALS, *REGISTERS]
