"""Allowed values of each parameter: the manual's ranges, by name, in one place.

A rule checks one argument and returns its value on the wire:

    v_wire = ranges.JOINT_SPEED("v", v)

Numbers are the manual's (version 3.8); each rule names its section. If the manual prints no range,
or an unusual one, the comment explains which range is checked instead, and why.
"""

from __future__ import annotations

import sys
import warnings
from math import inf, nextafter, pi
from typing import TYPE_CHECKING

from aioduco.errors import ParameterError, UnitWarning
from aioduco.models import jog, realtime
from aioduco.models.rules import (
    FARTHEST,
    LONGEST,
    LONGEST_ARM,
    Choice,
    Duration,
    FileName,
    Flag,
    Flags,
    Integer,
    Integers,
    JointsRule,
    Number,
    OrCurrent,
    OrForever,
    Points,
    PoseRule,
    Signed,
    Text,
    Texts,
    Vector,
    is_whole,
    ordered,
)

if TYPE_CHECKING:
    from aioduco.models.rules import FlagsLike, Real, VectorLike, Whole

# -- shared ------------------------------------------------------------------------------------

FLAG = Flag(source="1.3.2")
#: name of a tool, a work object or a track: the manual gives the 32 bytes for tools, in 1.3.7
NAME = Text(min_bytes=1, max_bytes=32, one_line=True, source="1.3.7")
#: name of a tool or a work object; empty for the active one
FRAME = Text(max_bytes=32, one_line=True, source="1.3.7")
#: free text: log messages, values of string variables
TEXT = Text(source="1.3.8")
TEXTS = Texts(TEXT, source="this package")
#: name of a program, a project's path, a system variable or a Modbus signal: the manual gives no
#: length; only an empty name is refused
LONG_NAME = Text(min_bytes=1, one_line=True, source="1.3.4")
PATH = Text(one_line=True, source="1.3.4")
#: name of a point, an undertaking, a limit, a thing: for the program and the people at it
OWN_NAME = Text(min_bytes=1, one_line=True, source="this package")
OWN_NAME_OR_NONE = Text(one_line=True, source="this package")
FINITE = Number(source="double on the wire")
FINITES = Vector(FINITE, source="list<double> on the wire")
INT_32 = Integer(-(2**31), 2**31 - 1, source="i32 on the wire")
TASK_ID = Integer(0, 2**31 - 1, source="1.3.8")

#: time limit for an answer, in this program
TIMEOUT = Number(0.0, LONGEST, "s", open_low=True, source="this package")
#: time to wait, in this program; 0 not to wait
WAIT = Number(0.0, LONGEST, "s", source="this package")
#: a number above 0, as of a length, a speed or a mass, of which nothing else is known
ABOVE = Number(0.0, open_low=True, source="this package")
#: an empty one would be every address of the computer
LISTEN_HOST = Text(min_bytes=1, max_bytes=253, source="this package")
LISTEN_HOST.expected = 'an address of this computer, such as "127.0.0.1"'
FILE = FileName(source="this package")
FOLDER = FileName(folder=True, source="this package")
#: the same, or 0
FROM_0 = Number(0.0, source="this package")
#: TCP port of a server
PORT = Integer(1, 65535, source="this package")
#: port to listen on; 0 for a free one
LISTEN_PORT = Integer(0, 65535, source="this package")
#: samples of the state per second
STATE_RATE = Number(0.0, 1000.0, "Hz", open_low=True, source="this package")

# -- 1.3.1 connection --------------------------------------------------------------------------

#: the manual gives no range; according to public applications 200 to 60000 ms are valid
HEARTBEAT = Duration(0.2, 60.0, source="1.3.1")

# -- 1.3.5 motion ------------------------------------------------------------------------------

JOINTS = JointsRule(source="1.3.5")
#: reference joints that choose the branch of the inverse kinematics; None for the present ones.
#: The manual prints no range; the range of the joints applies, which detects values in degrees
JOINTS_NEAR = OrCurrent(JOINTS)
#: the manual prints ±2π for the angles of the motions' targets; here it applies to all poses, and
#: detects values in degrees
POSE = PoseRule(source="1.3.5")
#: tool and work object of cal_ikine and cal_fkine
POSE_OR_CURRENT = OrCurrent(PoseRule(source="1.3.7"))
#: speed of the leading joint
JOINT_SPEED = Number(0.01 * pi / 180, 1.25 * pi, "rad/s", source="1.3.5")
JOINT_ACCELERATION = Number(0.01 * pi / 180, unit="rad/s²", source="1.3.5")
LINE_SPEED = Number(0.01, 5.0, "m/s", source="1.3.5")
LINE_ACCELERATION = Number(0.01, unit="m/s²", source="1.3.5")
#: spline_op, the Cartesian track and speedl's acceleration have a smaller lower bound than the
#: other motions
FINE_SPEED = Number(0.00001, 5.0, "m/s", source="1.3.5")
FINE_ACCELERATION = Number(0.00001, unit="m/s²", source="1.3.5")
#: 0 for no blending; the manual prints no maximum, but no radius is larger than an arm
BLEND_RADIUS = Number(0.0, unit="m", plausible=LONGEST_ARM, source="1.3.5")
#: speed and acceleration of movej and movej_pose, which the manual does not describe
PERCENT = Number(0.0, 100.0, "%", open_low=True, source="public applications")
#: their blend radius, from 0 to below 50
BLEND_PERCENT = Number(0.0, nextafter(50.0, 0.0), "%", source="comments of the vendor's class")
ARC_MODE = Choice(
    {
        0: "orientation goes over to the end's",
        1: "orientation stays as at the start",
        2: "orientation stays fixed to the arc's tangent",
    },
    source="1.3.5",
)
CIRCLE_MODE = Choice(
    {1: ARC_MODE.choices[1], 2: ARC_MODE.choices[2]},
    source="1.3.5",
)
SPIRAL_MODE = Choice({0: "by parameters", 1: "by its end point"}, source="1.3.5")
SPIRAL_TURNS = Number(source="1.3.5")
SPIRAL_LENGTH = Number(unit="m", plausible=LONGEST_ARM, source="1.3.5")
SPIRAL_RADIUS = Number(0.0, unit="m", plausible=LONGEST_ARM, source="1.3.5")

# the builders check these too, so they are defined beside the builders
JOINT_VELOCITIES = realtime.JOINT_VELOCITIES
TWIST = realtime.TWIST
JOG_DIRECTION = jog.JOG_DIRECTION
JOG_SPEED = jog.JOG_SPEED
FRAME_TYPE = jog.FRAME_TYPE
#: speedj and speedl: None to run until speed_stop (-1 on the wire)
RUN_TIME = OrForever(Duration(0.001, source="1.3.5"))
#: time without a call after which the controller ends such a motion of a stream; a longer one, such
#: as milliseconds, would stop nothing
DEAD_MAN = Number(0.0, 10.0, "s", open_low=True, source="this package")
#: from one end of a joint to the other [rad], and across what the longest arm reaches [m]
WHOLE_TURN, WHOLE_WAY = 4 * pi, 2 * LONGEST_ARM

#: spline, spline_op: the manual prints only the 50; the curve begins at the arm's position
SPLINE_POINTS = Points(POSE, 1, 50, source="1.3.5")
SPLINE_COUNT = Integer(1, 50, "points", source="1.3.5")

#: servo_tcp and servol: joint speed and acceleration in manual 3.8, Cartesian with
#: [0.00001, 5] m/s in 4.3; the range of 3.8 lies within both
SERVO_SPEED = Number(0.01 * pi / 180, 1.25 * pi, "rad/s or m/s", source="1.3.5")
SERVO_ACCELERATION = Number(0.01 * pi / 180, unit="rad/s² or m/s²", source="1.3.5")
#: the manual gives only the default (200); a negative gain moves the arm away from the target
SERVO_KP = Number(0.0, source="1.3.5")
#: the manual gives only the default (25)
SERVO_KD = Number(0.0, source="1.3.5")
#: 1 to 100 in the manual, 1 to 10 in the vendor's code, where 10 is the default
SERVO_SMOOTH_VELOCITY = Number(1.0, 100.0, source="1.3.5")
SERVO_SMOOTH_ACCELERATION = Number(0.0, 1.0, source="1.3.5")

TEACH_SPACE = Choice({0: "joints", 1: "Cartesian"}, source="1.3.5")
#: compliance of hand guiding; the manual gives the number of elements, not their range
TEACH_SCALE = Integers(Integer(0, 2**31 - 1, source="1.3.5"), length=6, source="1.3.5")
TEACH_DIRECTIONS = Flags(FLAG, length=6, source="1.3.5")
#: percent of the set speed, (0, 100] in the manual, whole on the wire
REPLAY_SPEED = Integer(1, 100, "%", source="1.3.5")
REPLAY_MODE = Choice({0: "in joint space", 1: "in Cartesian space"}, source="1.3.5")
BLEND_AHEAD = Integer(0, 100, "%", source="1.3.5")
BLEND_AHEAD_MOVES = Integer(1, 3, "moves", source="1.3.5")

# -- 1.3.6 CAN and RS-485 ----------------------------------------------------------------------

#: the manual lists no rates
BAUD_RATE = Integer(1, 2**31 - 1, "bit/s", source="1.3.6")
READ_LENGTH = Integer(1, 2**31 - 1, "bytes", source="1.3.6")
#: bytes 0 to 255, or the signed numbers of the wire
BYTES = Signed(8, "bytes", source="1.3.6")
#: a CAN frame may have no data, as CANopen's SYNC
CAN_DATA = Signed(8, "bytes", min_length=0, source="1.3.6")
#: the identifier of an extended CAN frame has 29 bits
CAN_ID = Integer(0, 2**29 - 1, source="1.3.6")

# -- 1.3.7 system functions and peripherals ----------------------------------------------------

STANDARD_IO = Integer(1, 16, source="1.3.7")
TOOL_IO = Integer(1, 2, source="1.3.7")
FUNCTION_IO = Integer(1, 8, source="1.3.7")
FUNCTION_REGISTER = Integer(1, 16, source="1.3.7")
#: not in the manual
CONFIG_IO = Integer(1, 2**15 - 1, source="i16 on the wire")
ANALOG_IO = Integer(1, 4, source="1.3.7")
TOOL_ANALOG_IO = Integer(1, 2, source="1.3.7")
OUTPUT_MODE = Choice({0: "level", 1: "pulses"}, source="1.3.7")
PULSE_FREQUENCY = Integer(1, 100, "Hz", source="1.3.7")
PULSE_DUTY = Integer(1, 100, "%", source="1.3.7")
VOLTAGE = Number(0.0, 10.0, "V", source="1.3.7")
CURRENT = Number(4.0, 20.0, "mA", source="1.3.7")
BOOL_REGISTER = Integer(1, 64, source="1.3.7")
WORD_REGISTER = Integer(1, 32, source="1.3.7")
FLOAT_REGISTER = Integer(1, 32, source="1.3.7")
#: the manual gives no range; a word has 16 bits, signed or unsigned
WORD = Integer(-(2**15), 2**16 - 1, source="1.3.7")

#: the manual gives no range; no tool is longer than an arm
TOOL_OFFSET = PoseRule(farthest=LONGEST_ARM, source="1.3.7")
#: of a centre of mass
_COORDINATE = Number(unit="m", plausible=LONGEST_ARM, source="1.3.7")
#: mass in kg, then its centre in m; the manual gives no range; a mass is not negative
PAYLOAD = Vector(Number(0.0, unit="kg", source="1.3.7"), *[_COORDINATE] * 3)
#: mass in kg up to 35, then its centre in m, in the tool's frame
LOAD = Vector(Number(0.0, 35.0, "kg", source="1.3.7"), *[_COORDINATE] * 3)
#: xx, xy, xz, yy, yz, zz
INERTIA = Vector(Number(unit="kg·m²", source="1.3.7"), length=6)
CHECK_POINTS = Points(POSE, 1, 2**31 - 1, source="1.3.7")
#: speed(), which applies to the whole robot
GLOBAL_SPEED = Number(1.0, 100.0, "%", source="1.3.7")
TEACH_SPEED = Integer(1, 100, "%", source="1.3.7")
TRACK_MODE = Choice({0: "by position", 1: "by time"}, source="1.3.7")
#: start_record_track: degrees (mode 0) or seconds (mode 1) on the wire; not in the manual
TRACK_INTERVAL = Number(0.0, open_low=True, source="vendor's generated client")
COLLISION_LEVEL = Integer(0, 5, source="1.3.7")
SWITCH_MODE = Choice({0: "manual", 1: "automatic"}, source="1.3.7")

# -- 1.3.9 Modbus ------------------------------------------------------------------------------

#: 0 to 65535 for a register, 0 or 1 for a coil; this package cannot tell which a signal is
MODBUS_VALUE = Integer(0, 65535, source="1.3.9")
MODBUS_FREQUENCY = Integer(1, 100, "Hz", source="1.3.9")
#: the manual gives no range; a unit's number is one byte in Modbus
MODBUS_UNIT = Integer(0, 255, source="1.3.9")
#: words 0 to 65535, or the signed numbers of the wire
MODBUS_WORDS = Signed(16, "words", source="1.3.9")
MODBUS_COILS = Integers(Choice({0: "off", 1: "on"}, source="1.3.9"), source="1.3.9")

# -- 1.3.10 force control ----------------------------------------------------------------------

DIRECTIONS = Flags(FLAG, length=6, source="1.3.10")


def _six(linear: str, angular: str, low: float = -inf, high: float = inf) -> Vector:
    """Three numbers along x, y, z and three about them, in these units, all within two bounds."""
    along, about = (Number(low, high, unit, source="1.3.10") for unit in (linear, angular))
    return Vector(*[along] * 3, *[about] * 3)


#: force in x, y, z [N], torque about them [N·m]; signed
WRENCH = _six("N", "N·m", -1000.0, 1000.0)
#: dead band; the manual allows negative numbers, although it is compared with a magnitude
FORCE_DEAD_BAND = WRENCH
#: fc_guard_act: a magnitude, regardless of the direction; the manual gives no range
GUARD_WRENCH = _six("N", "N·m", 0.0)
#: fc_force_set_value, for which the manual gives no range
SENSOR_WRENCH = _six("N", "N·m")
#: the speed of the correction is the force error divided by the damping: with a negative one, the
#: error grows. 0 is accepted for directions that are off, see `damping`
DAMPING = _six("N/(m/s)", "N·m/(rad/s)", 0.0)
#: the manual allows negative numbers, although it is the maximum magnitude of a speed
FORCE_SPEED = _six("m/s", "rad/s", -5.0, 5.0)
FORCE_FRAME = Choice({0: "tool", 1: "work object"}, source="1.3.10")
FORCE_PROPERTY = Choice({0: "load and external force", 1: "external force"}, source="1.3.10")
WAIT_POSITION = Vector(
    *[Number(unit="m", plausible=FARTHEST, source="1.3.10")] * 3,
    *[Number(unit="rad", source="1.3.10")] * 3,
)
WAIT_VELOCITY = Vector(
    *[Number(-5.0, 5.0, "m/s", source="1.3.10")] * 3,
    *[Number(-2 * pi, 2 * pi, "rad/s", source="1.3.10")] * 3,
)
WAIT_WRENCH = WRENCH
#: widths around the middle values; the manual gives no range; a width is not negative
WAIT_POSITION_RANGE = _six("m", "rad", 0.0)
WAIT_VELOCITY_RANGE = _six("m/s", "rad/s", 0.0)
WAIT_WRENCH_RANGE = GUARD_WRENCH
WAIT_DURATION = Duration(source="1.3.10")
WAIT_TIMEOUT = Duration(source="1.3.10")
#: logic of position, velocity and force
WAIT_LOGIC = Integers(
    Choice({0: "off", 1: "and", 2: "or"}, source="1.3.10"), length=3, source="1.3.10"
)

# -- 1.3.12 track pool -------------------------------------------------------------------------

#: joints or poses, depending on the motion that follows; the pool holds 1000
_TRACK_POINT = Vector(FINITE, length=6, source="1.3.12")
TRACK_POINTS = Points(_TRACK_POINT, 1, 1000, source="1.3.12")
TRACK_JOINTS = Points(JOINTS, 1, 1000, source="1.3.12")
TRACK_POSES = Points(POSE, 1, 1000, source="1.3.12")
TRACK_COUNT = Integer(1, 1000, "points", source="1.3.12")
TRACK_JOINT_SPEED = Number(0.01 * pi / 180, 1.25 * pi, "rad/s", source="1.3.12")
TRACK_JOINT_ACCELERATION = Number(0.01 * pi / 180, 12.5 * pi, "rad/s²", source="1.3.12")
TRACK_SPEED = Number(0.00001, 5.0, "m/s", source="1.3.12")
TRACK_ACCELERATION = Number(0.00001, unit="m/s²", source="1.3.12")
#: not in the manual; the vendor's client sends 0.005
TRACK_RADIUS = Number(0.0, unit="m", plausible=LONGEST_ARM, source="vendor's generated client")

# -- 1.3.13 combined motion --------------------------------------------------------------------

WEAVE_TYPE = Choice(
    {1: "triangle", 2: "sine", 3: "circle", 4: "trapezoid", 5: "figure of eight"}, source="1.3.13"
)
WEAVE_PLANE = Choice(
    {
        0: "tool XOY",
        1: "tool XOZ",
        2: "tool YOZ",
        3: "work object XOY",
        4: "work object XOZ",
        5: "work object YOZ",
    },
    source="1.3.13",
)
#: the manual gives no range
WEAVE_FREQUENCY = Number(0.0, unit="Hz", open_low=True, source="1.3.13")
WEAVE_AMPLITUDE = Number(0.0, unit="m", plausible=LONGEST_ARM, source="1.3.13")
WEAVE_OFFSET = Number(unit="m", plausible=LONGEST_ARM, source="1.3.13")
#: dwell time at one side; milliseconds on the wire, according to manual 4.3
WEAVE_DWELL = Duration(source="1.3.13")

# -- 1.3.14 external axes ----------------------------------------------------------------------

#: up to three values in rad or m, depending on the scheme
EAXIS_POSITION = Vector(Number(unit="rad or m", source="1.3.14"), length=3)
#: the manual gives no range
EAXIS_SPEED = Number(0.0, unit="rad/s or m/s", open_low=True, source="1.3.14")
#: for movel and movec with external axes the manual's lower bound is 0, excluded
EAXIS_LINE_SPEED = Number(0.0, 5.0, "m/s", open_low=True, source="1.3.14")
EAXIS_LINE_ACCELERATION = Number(0.0, unit="m/s²", open_low=True, source="1.3.14")
#: the manual gives no range for the joints' speed with external axes: that of 1.3.5 applies
EAXIS_JOINT_SPEED = JOINT_SPEED
EAXIS_JOINT_ACCELERATION = JOINT_ACCELERATION
EAXIS_NUMBER = Integer(0, 2**31 - 1, source="i32 on the wire")

# -- 1.3.15 realtime ---------------------------------------------------------------------------

REALTIME_MODE = Choice(
    {mode.value: mode.name.lower().replace("_", " ") for mode in realtime.RealtimeMode},
    source="1.3.15",
)
#: the manual gives only the default (100)
REALTIME_BANDWIDTH = Number(0.0, unit="Hz", open_low=True, source="1.3.15")
#: the manual gives only the default (0.02); also seconds on the wire. The arm goes on without data
#: for this time: 20, which are milliseconds elsewhere, would be 20 s
REALTIME_LOST_TIME = Number(0.0, 10.0, "s", open_low=True, source="1.3.15")

# -- only on the wire --------------------------------------------------------------------------

AXIS_NUMBER = Integer(0, 2**31 - 1, source="i32 on the wire")
MATRIX = Points(FINITES, 0, 2**31 - 1, source="list<list<double>> on the wire")

# -- rules for two parameters together ---------------------------------------------------------


def pulse(freq: Whole, duty_cycle: Whole) -> tuple[int, int]:
    """Check frequency [Hz] and duty cycle [%] of pulses, which must last at least 1 ms (1.3.7).

    Raises:
        ParameterError: one is out of range, or the pulses are shorter; the controller would then
            turn them off.
    """
    hertz, percent = PULSE_FREQUENCY("freq", freq), PULSE_DUTY("duty_cycle", duty_cycle)
    if percent * 10 < hertz:  # percent / 100 / hertz < 0.001 s
        least = -(-hertz // 10)
        raise ParameterError(
            "duty_cycle", percent, f"at least {least} % at {hertz} Hz, so that pulses last 1 ms"
        )
    return hertz, percent


def percent_of_speed(name: str, value: Real) -> float:
    """Check a speed in percent; warn if it looks like rad/s: 1.0 would be 1 %.

    An int is percent, without a warning.

    Raises:
        ParameterError: it is out of range.
    """
    percent = PERCENT(name, value)
    if not is_whole(value) and percent <= JOINT_SPEED.high:
        warnings.warn(
            f"{name}={value!r} is {percent:g} % of the arm's speed here, not rad/s: movej2 and "
            f"movej_pose2 take rad/s. Percent as a whole number ({name}={max(1, round(percent))}) "
            "does not warn",
            UnitWarning,
            stacklevel=_callers_level(),
        )
    return percent


def _callers_level() -> int:
    """Number of stack frames from the function that warns up to the program's frame."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith("aioduco."):
        frame, level = frame.f_back, level + 1
    return level


def run_time(name: str, value: Real | None, *ways: tuple[float, float]) -> int:
    """Check the time of a motion at a velocity [s]; return milliseconds, -1 for None (1.3.5).

    The time is refused in which the arm would move further than an arm can: so are milliseconds,
    which the vendor's class takes.

    Args:
        name: the name of the parameter.
        value: the time; None for no end.
        ways: a speed, and the longest way at it [rad/s, rad; or m/s, m].

    Raises:
        ParameterError: it is out of range, or too long for the speeds.
    """
    milliseconds = RUN_TIME(name, value)
    longest = min((way / speed for speed, way in ways if speed > 0.0), default=inf)
    if milliseconds > 1000.0 * longest:
        raise ParameterError(
            name,
            value,
            f"at most {longest:.3g} s: no arm can move for longer at this velocity (seconds, not "
            "milliseconds), or None for no end",
        )
    return milliseconds


def weave_dwells(name: str, value: VectorLike) -> list[int]:
    """Check the dwell times of a weave on the left and right [s]; return milliseconds (1.3.13).

    Raises:
        ParameterError: `value` has not two numbers, or one is out of range.
    """
    expected = f"two numbers, each {WEAVE_DWELL.expected}"
    items = ordered(name, value, expected)
    if len(items) != 2:
        raise ParameterError(name, value, expected)
    return [WEAVE_DWELL(f"{name}[{number}]", item) for number, item in enumerate(items)]


def damping(direction: FlagsLike, damp: VectorLike) -> tuple[list[bool], list[float]]:
    """Check which directions yield to force, and their damping (1.3.10).

    Raises:
        ParameterError: one is out of range, or a direction that is on has zero damping: the speed
            is the force error divided by it.
    """
    on, by = DIRECTIONS("direction", direction), DAMPING("damp", damp)
    for index, (active, value) in enumerate(zip(on, by, strict=True)):
        if active and value == 0.0:
            raise ParameterError(
                f"damp[{index}]",
                value,
                "above 0 in a direction that is on: the speed is the force divided by it "
                f"({DAMPING.element[index].unit})",
            )
    return on, by


def wait_range(rule: Vector, value: VectorLike) -> list[float]:
    """Check the widths of a condition of force control by their rule (1.3.10).

    Raises:
        ParameterError: one is out of range, or all are 0: each takes its axis out of the condition,
            and nothing would be left that could hold, or time out.
    """
    widths = rule("range", value)
    if not any(widths):
        expected = f"{rule.expected}, at least one above 0: nothing else ends the motion"
        raise ParameterError("range", value, expected)
    return widths
