"""The frame that controllers send without a request on TCP port 2001: 1468 bytes.

Each field is declared with its place. Source: two parsers in a public application for a
GCR5-910 (robot_dc, duco_2001_monitoring_extended.py and robot_data.py); the vendor does not
document the port. If one of the parsers reads a field differently, its description says so.
"""

# ruff: noqa: RUF009 - `_at` makes a field of a dataclass

from __future__ import annotations

import math
import struct
from dataclasses import dataclass, field, fields
from typing import Any, Final

from aioduco.errors import ProtocolError

PORT: Final = 2001
#: approximate number of frames per second
RATE: Final = 10.0
#: length of a frame [bytes]
FRAME_SIZE: Final = 1468

Numbers = tuple[float, ...]
Whole = tuple[int, ...]

#: beyond it a number is no position of a joint, or of an external axis [rad, m]
_FARTHEST: Final = 1000.0
_BIGGEST = 3.4028234663852886e38  # largest finite float of four bytes


def _at(offset: int, form: str) -> Any:
    """A field at an offset [bytes], by its format in the notation of the struct module."""
    default = () if form[:-1] else 0.0 if form == "f" else 0
    return field(default=default, metadata={"place": (offset, form)})


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

    joint_position: Numbers = _at(0, "7f")
    joint_velocity: Numbers = _at(28, "7f")
    joint_acceleration: Numbers = _at(56, "7f")
    joint_torque: Numbers = _at(84, "7f")
    joint_position_expected: Numbers = _at(112, "7f")
    joint_velocity_expected: Numbers = _at(140, "7f")
    joint_acceleration_expected: Numbers = _at(168, "7f")
    joint_torque_expected: Numbers = _at(196, "7f")
    joint_temperature: Numbers = _at(224, "7f")
    joint_current: Numbers = _at(252, "7f")
    driver_error: Whole = _at(280, "7I")
    driver_state: Whole = _at(308, "7I")
    tcp_position: Numbers = _at(368, "6f")
    tcp_velocity: Numbers = _at(392, "6f")
    tcp_acceleration: Numbers = _at(416, "6f")
    tcp_force: Numbers = _at(440, "6f")
    tcp_position_expected: Numbers = _at(464, "6f")
    tcp_velocity_expected: Numbers = _at(488, "6f")
    tcp_acceleration_expected: Numbers = _at(512, "6f")
    tcp_force_expected: Numbers = _at(536, "6f")
    base_force: Numbers = _at(560, "6f")
    base_force_expected: Numbers = _at(584, "6f")
    tool: Numbers = _at(608, "6f")
    work_object: Numbers = _at(632, "6f")
    blended_speed: float = _at(656, "f")
    global_speed: int = _at(660, "B")
    jog_speed: int = _at(661, "B")
    function_digital_in: Whole = _at(720, "8B")
    function_digital_out: Whole = _at(728, "8B")
    digital_in: Whole = _at(736, "16B")
    digital_out: Whole = _at(752, "16B")
    analog_in: Numbers = _at(768, "8f")
    analog_out: Numbers = _at(800, "8f")
    float_register_in: Numbers = _at(832, "32f")
    float_register_out: Numbers = _at(960, "32f")
    function_bool_in: Whole = _at(1088, "16B")
    function_bool_out: Whole = _at(1104, "16B")
    bool_register_in: Whole = _at(1120, "64B")
    bool_register_out: Whole = _at(1184, "64B")
    word_register_in: Whole = _at(1248, "32H")
    word_register_out: Whole = _at(1312, "32H")
    simulated: int = _at(1407, "B")
    tool_digital_in: Whole = _at(1408, "8B")
    tool_digital_out: Whole = _at(1416, "8B")
    tool_analog_in: Numbers = _at(1424, "2f")
    tool_analog_out: Numbers = _at(1432, "2f")
    tool_buttons: Whole = _at(1440, "2B")
    mode: int = _at(1448, "B")
    robot: int = _at(1449, "B")
    program: int = _at(1450, "B")
    safety: int = _at(1451, "B")
    collision: int = _at(1452, "B")
    collision_axis: int = _at(1453, "B")
    error: int = _at(1456, "I")

    @classmethod
    def decode(cls, data: bytes) -> StatusFrame:
        """Decode a frame.

        Args:
            data: its 1468 bytes.

        Returns:
            The frame.

        Raises:
            ProtocolError: `data` has another length, or joint positions that are none, as when a
                controller sends another layout. Nothing else in a frame certainly tells that.
        """
        if len(data) != FRAME_SIZE:
            raise ProtocolError(f"a status frame has {FRAME_SIZE} bytes, not {len(data)}")
        values: dict[str, Any] = {}
        for name, offset, one, count in _LAYOUT:
            found = one.unpack_from(data, offset)
            values[name] = found if count else found[0]
        if not all(abs(each) < _FARTHEST for each in values["joint_position"]):
            raise ProtocolError(
                f"these bytes are no status frame, with joints at {values['joint_position']}: the "
                "controller may send another layout"
            )
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


#: for each field: name, offset, format (little-endian), and number of elements, 0 for one number
_LAYOUT: Final = tuple(
    (each.name, offset, struct.Struct(f"<{form}"), int(form[:-1] or 0))
    for each in fields(StatusFrame)
    for offset, form in (each.metadata["place"],)
)
