"""The frame that controllers send without a request on TCP port 2001: 1468 bytes.

A table below has the place of each field. Source: two parsers in a public application for a
GCR5-910 (robot_dc, duco_2001_monitoring_extended.py and robot_data.py); the vendor does not
document the port. If one of the parsers reads a field differently, its description says so.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from typing import Any, Final

from aioduco.errors import ProtocolError

__all__ = ["FRAME_SIZE", "PORT", "RATE", "StatusFrame"]

PORT: Final = 2001
#: approximate number of frames per second
RATE: Final = 10.0
#: length of a frame [bytes]
FRAME_SIZE: Final = 1468

Numbers = tuple[float, ...]
Whole = tuple[int, ...]

_BIGGEST = 3.4028234663852886e38  # largest finite float of four bytes


#: by field, its offset [bytes] and its format in the notation of the struct module, little-endian
_OFFSETS: Final = {
    "joint_position": (0, "7f"),
    "joint_velocity": (28, "7f"),
    "joint_acceleration": (56, "7f"),
    "joint_torque": (84, "7f"),
    "joint_position_expected": (112, "7f"),
    "joint_velocity_expected": (140, "7f"),
    "joint_acceleration_expected": (168, "7f"),
    "joint_torque_expected": (196, "7f"),
    "joint_temperature": (224, "7f"),
    "joint_current": (252, "7f"),
    "driver_error": (280, "7I"),
    "driver_state": (308, "7I"),
    "tcp_position": (368, "6f"),
    "tcp_velocity": (392, "6f"),
    "tcp_acceleration": (416, "6f"),
    "tcp_force": (440, "6f"),
    "tcp_position_expected": (464, "6f"),
    "tcp_velocity_expected": (488, "6f"),
    "tcp_acceleration_expected": (512, "6f"),
    "tcp_force_expected": (536, "6f"),
    "base_force": (560, "6f"),
    "base_force_expected": (584, "6f"),
    "tool": (608, "6f"),
    "work_object": (632, "6f"),
    "blended_speed": (656, "f"),
    "global_speed": (660, "B"),
    "jog_speed": (661, "B"),
    "function_digital_in": (720, "8B"),
    "function_digital_out": (728, "8B"),
    "digital_in": (736, "16B"),
    "digital_out": (752, "16B"),
    "analog_in": (768, "8f"),
    "analog_out": (800, "8f"),
    "float_register_in": (832, "32f"),
    "float_register_out": (960, "32f"),
    "function_bool_in": (1088, "16B"),
    "function_bool_out": (1104, "16B"),
    "bool_register_in": (1120, "64B"),
    "bool_register_out": (1184, "64B"),
    "word_register_in": (1248, "32H"),
    "word_register_out": (1312, "32H"),
    "simulated": (1407, "B"),
    "tool_digital_in": (1408, "8B"),
    "tool_digital_out": (1416, "8B"),
    "tool_analog_in": (1424, "2f"),
    "tool_analog_out": (1432, "2f"),
    "tool_buttons": (1440, "2B"),
    "mode": (1448, "B"),
    "robot": (1449, "B"),
    "program": (1450, "B"),
    "safety": (1451, "B"),
    "collision": (1452, "B"),
    "collision_axis": (1453, "B"),
    "error": (1456, "I"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusFrame:
    """The state of a controller at one instant, as sent by its status port.

    A received frame has every number. Lists of joints have seven numbers; an arm without an
    external axis uses six of them. Lists of signals have one number, 0 or 1, for each signal.

    Attributes:
        joint_position, joint_velocity, joint_acceleration: actual values of the joints [rad, s].
        joint_torque: actual torques [N m].
        joint_position_expected, joint_velocity_expected, joint_acceleration_expected: set-points
            of the drives [rad, s].
        joint_torque_expected: torques for these set-points [N m].
        joint_temperature: temperatures [°C].
        joint_current: thousandths of the rated currents.
        driver_error, driver_state: errors and states of the drives.
        tcp_position, tcp_velocity, tcp_acceleration: actual values of the tool's tip [m, rad, s].
        tcp_force: force and torque at the tip; the parsers doubt their units [N, N m].
        tcp_position_expected, tcp_velocity_expected, tcp_acceleration_expected: set-points of the
            tip [m, rad, s].
        tcp_force_expected: expected force and torque at the tip [N, N m].
        base_force, base_force_expected: force and torque at the base [N, N m].
        tool, work_object: the active frames [m, rad].
        blended_speed: speed of the path [m/s or rad/s].
        global_speed, jog_speed: speeds [%].
        function_digital_in, function_digital_out: 8 signals each.
        digital_in, digital_out: 16 signals each.
        analog_in, analog_out: 8 channels each.
        float_register_in, float_register_out: 32 each.
        function_bool_in, function_bool_out: 16 function registers each.
        bool_register_in, bool_register_out: 64 each.
        word_register_in, word_register_out: 32 words each; one parser reads 64 bytes.
        simulated: 1 if the controller simulates its arm.
        tool_digital_in, tool_digital_out: 8 signals each; one parser reads two numbers of four
            bytes in the second.
        tool_analog_in, tool_analog_out: 2 channels each.
        tool_buttons: buttons S and T.
        mode: operation mode, see `OperationMode`.
        robot, program, safety: see `RobotState`, `ProgramState`, `SafetyState`.
        collision: 1 while a collision is signalled.
        collision_axis: joint of the collision, 1 to 6, or 0.
        error: error code of the robot.
    """

    joint_position: Numbers = ()
    joint_velocity: Numbers = ()
    joint_acceleration: Numbers = ()
    joint_torque: Numbers = ()
    joint_position_expected: Numbers = ()
    joint_velocity_expected: Numbers = ()
    joint_acceleration_expected: Numbers = ()
    joint_torque_expected: Numbers = ()
    joint_temperature: Numbers = ()
    joint_current: Numbers = ()
    driver_error: Whole = ()
    driver_state: Whole = ()
    tcp_position: Numbers = ()
    tcp_velocity: Numbers = ()
    tcp_acceleration: Numbers = ()
    tcp_force: Numbers = ()
    tcp_position_expected: Numbers = ()
    tcp_velocity_expected: Numbers = ()
    tcp_acceleration_expected: Numbers = ()
    tcp_force_expected: Numbers = ()
    base_force: Numbers = ()
    base_force_expected: Numbers = ()
    tool: Numbers = ()
    work_object: Numbers = ()
    blended_speed: float = 0.0
    global_speed: int = 0
    jog_speed: int = 0
    function_digital_in: Whole = ()
    function_digital_out: Whole = ()
    digital_in: Whole = ()
    digital_out: Whole = ()
    analog_in: Numbers = ()
    analog_out: Numbers = ()
    float_register_in: Numbers = ()
    float_register_out: Numbers = ()
    function_bool_in: Whole = ()
    function_bool_out: Whole = ()
    bool_register_in: Whole = ()
    bool_register_out: Whole = ()
    word_register_in: Whole = ()
    word_register_out: Whole = ()
    simulated: int = 0
    tool_digital_in: Whole = ()
    tool_digital_out: Whole = ()
    tool_analog_in: Numbers = ()
    tool_analog_out: Numbers = ()
    tool_buttons: Whole = ()
    mode: int = 0
    robot: int = 0
    program: int = 0
    safety: int = 0
    collision: int = 0
    collision_axis: int = 0
    error: int = 0

    @classmethod
    def decode(cls, data: bytes) -> StatusFrame:
        """Decode a frame.

        Args:
            data: its 1468 bytes.

        Returns:
            The frame.

        Raises:
            ProtocolError: `data` has another length.
        """
        if len(data) != FRAME_SIZE:
            raise ProtocolError(f"a status frame has {FRAME_SIZE} bytes, not {len(data)}")
        values: dict[str, Any] = {}
        for name, offset, one, count in _LAYOUT:
            found = one.unpack_from(data, offset)
            values[name] = found if count else found[0]
        return cls(**values)

    def encode(self) -> bytes:
        """Return the 1468 bytes of the frame; lists that are too short are filled with zeros."""
        frame = bytearray(FRAME_SIZE)
        for name, offset, one, count in _LAYOUT:
            given = getattr(self, name)
            values = list(given)[:count] if count else [given]
            values += [0] * (max(count, 1) - len(values))
            if one.format[-1] == "f":
                values = [_single(value) for value in values]
            one.pack_into(frame, offset, *values)
        return bytes(frame)


def _single(value: float) -> float:
    """Convert a value to the range of a float of four bytes; larger ones become infinite."""
    return value if abs(value) <= _BIGGEST or math.isnan(value) else math.copysign(math.inf, value)


#: for each field: name, offset, format, and number of elements, 0 for a single number
_LAYOUT: Final = tuple(
    (name, offset, struct.Struct(f"<{form}"), int(form[:-1] or 0))
    for name, (offset, form) in _OFFSETS.items()
)
