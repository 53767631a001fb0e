"""Render a monitor's state in a terminal, from the state and the terminal's size alone."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING, Any, Final

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from aioduco.cli.output import one_line
from aioduco.models.enums import RobotState, SafetyState

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.cli.monitor.view_state import EventLine, MonitorState
    from aioduco.models.state import RobotStatus
    from aioduco.supervision.state_feed import Snapshot


_STYLES: Final = {"info": "", "good": "green", "warning": "yellow", "alarm": "bold red"}
#: columns from which a line holds all, and from which there are more columns of numbers
_WHOLE: Final = 100
_WIDE: Final = 150
#: lines below which the motion and the controller's errors are left out
_SHORT: Final = 8
#: lines from which the last minute is drawn
_TALL: Final = 36
#: number of columns besides the bars, and with more columns of numbers
_COLUMNS, _MORE_COLUMNS = 70, 88
_LEAST_BAR: Final = 8
_EVENT_INDENT: Final = " " * 10
_BLOCKS: Final = " ▁▂▃▄▅▆▇█"
#: what the charts show: its name and unit, and the least value that fills them
_CHARTS: Final = (("tool", "mm/s", 1.0), ("force", "N", 1.0), ("behind", "°", 0.1))
#: part of a joint's range, at each end, that counts as near the limit
_NEAR: Final = 0.05
_POSE: Final = ("x", "y", "z", "rx", "ry", "rz")
_NO: Final = "–"
_ONE_LINE: Final[dict[str, Any]] = {"no_wrap": True, "overflow": "ellipsis"}
#: lines of the table of joints and pose
_ARM_LINES: Final = 7


def screen(state: MonitorState, width: int, height: int) -> RenderableType:
    """The whole screen, for a terminal of `width` columns and `height` lines.

    What does not fit is left out, the alarm and how the last stop ended last of all.
    """
    lines: list[RenderableType] = [_head(state, width), _states(state, width)]
    if height >= _SHORT:
        lines.append(_doing(state))
        if state.errors:
            lines.append(Text(f"errors: {one_line('; '.join(state.errors))}", "red", **_ONE_LINE))
    alarm = Text(f" {state.alarm} ", "bold white on red", **_ONE_LINE)
    lines.append(alarm if state.alarm else Text(""))
    room = height - len(lines) - 2  # the notice and the keys
    if state.sample is not None:
        signals = _signals(state.sample, width)
        needed = _ARM_LINES + 1 + len(signals)
        if room >= needed + 2:  # with a blank line and an event
            lines += [arm_table(state, state.sample, width), Text(""), *signals]
            room -= needed
    if height >= _TALL:
        drawn = _last_minute(state, width)
        lines += drawn
        room -= len(drawn)
    if room >= 2:
        lines += [Text(""), *_events(state, room - 1, width)]
    lines += [_notice(state), _keys()]
    return Group(*lines)


def _head(state: MonitorState, width: int) -> Text:
    rate = f"{state.measured_rate:.1f} of {state.rate:g} Hz"
    title = f"{state.robot}  {state.arm}".rstrip()
    if state.answer_time is not None:
        answered = f", answered in {state.answer_time * 1e3:.0f} ms"
        if len(title) + len(rate) + len(answered) + 3 <= width:
            rate += answered
    gap = max(2, width - len(title) - len(rate) - 1)
    return Text.assemble(
        (title, "bold"), " " * gap, (rate, "red" if state.silent else "dim"), no_wrap=True
    )


def _states(state: MonitorState, width: int) -> Text:
    if state.sample is None:
        return Text("no sample yet", style="yellow")
    states = state.sample.states
    ready = states.robot is RobotState.ENABLE
    safe = states.safety in {SafetyState.RUN, SafetyState.REDUCE}
    gap = "   " if width >= _WHOLE else "  "
    return Text.assemble(
        "robot ",
        (states.robot.name, "green" if ready else "yellow"),
        f"{gap}program ",
        (states.program.name, "bold"),
        f"{gap}safety ",
        (states.safety.name, "green" if safe else "bold red"),
        f"{gap}mode ",
        (states.mode.name, "bold"),
        style="dim" if state.silent else "",
        no_wrap=True,
    )


def _doing(state: MonitorState) -> Text:
    speed = "" if state.speed is None else f", speed {state.speed:g} %"
    return Text(f"{state.doing}{speed}", **_ONE_LINE)


def arm_table(state: MonitorState, sample: Snapshot, width: int) -> Table:
    """Joints and tool of a sample, in a terminal of `width` columns."""
    status, forces = sample.status, sample.read_forces
    wide = width >= _WIDE
    length = max(width - (_MORE_COLUMNS if wide else _COLUMNS), _LEAST_BAR)
    table = Table(box=None, padding=(0, 1), header_style="dim")
    table.add_column("")
    table.add_column(f"{_limit(state.lower)} … {_limit(state.upper)}", no_wrap=True)
    more = ("told", "behind", "°C") if wide else ()
    for heading in ("angle", "°/s", "N·m", *more, "", "tool", "force"):
        table.add_column(heading, justify="right", no_wrap=True)
    outside = [math.nan] * 6 if forces is None else forces.external_torques.tolist()
    tool = [math.nan] * 6 if forces is None else forces.tool.tolist()
    for row, (angle, speed, torque, part, force) in enumerate(
        zip(status.joints, status.joint_speeds.tolist(), outside, status.pose, tool, strict=True)
    ):
        turns = row >= 3
        shown = (
            f"{_number(math.degrees(part) if turns else part * 1e3, 1)} {' °' if turns else 'mm'}"
        )
        table.add_row(
            f"J{row + 1}",
            bar(angle, state.lower[row], state.upper[row], length),
            f"{_number(math.degrees(angle), 2)}°",
            _number(math.degrees(speed), 1),
            _number(torque, 1),
            *(_further(status, row) if wide else ()),
            _POSE[row],
            shown,
            f"{_number(force, 2)} {'N·m' if turns else 'N  '}",
            style="dim" if state.silent else "",
        )
    return table


def _further(status: RobotStatus, row: int) -> tuple[str, str, str]:
    """What a wide screen also shows of a joint: commanded, how far it is behind, temperature."""
    told = math.degrees(status.expected_joints[row])
    behind = told - math.degrees(status.joints[row])
    heat = status.joint_temperatures[row]
    return f"{_number(told, 2)}°", f"{_number(behind, 2)}°", _number(heat, 0)


def _last_minute(state: MonitorState, width: int) -> list[Text]:
    """The last minute of the tool's speed and force, and of how far the joints are behind."""
    lines = []
    for (name, unit, least), values in zip(_CHARTS, zip(*state.history, strict=True), strict=False):
        known = [value for value in values if not math.isnan(value)]
        if not known:
            continue
        upper, lower = chart(values, width - 22, state.history_length, least)
        most = f"to {_number(max(known), 1)} {unit}"
        lines += [Text(""), Text.assemble((f"{name:<6} {most:>13}  ", "dim"), (upper, "cyan"))]
        lines.append(Text.assemble((f"{'last minute':>20}  ", "dim"), (lower, "cyan")))
    return lines


def chart(values: Sequence[float], width: int, most: int, least: float = 0.0) -> tuple[str, str]:
    """Values as columns of two lines, the newest at the right.

    Args:
        values: values from 0, the oldest first; NaN where there is none.
        width: number of columns.
        most: number of values that fill all columns.
        least: value that fills both lines if all values are smaller, so that noise stays small.
    """
    columns = [math.nan] * width
    for place, value in enumerate(reversed(values)):
        column = width - 1 - place * width // most
        if column >= 0 and not math.isnan(value):
            columns[column] = value if math.isnan(columns[column]) else max(value, columns[column])
    top = max(least, *(value for value in columns if not math.isnan(value)), 0.0) or 1.0
    eighths = [0 if math.isnan(value) else max(1, round(16 * value / top)) for value in columns]
    return (
        "".join(_BLOCKS[max(0, eighth - 8)] for eighth in eighths),
        "".join(_BLOCKS[min(8, eighth)] for eighth in eighths),
    )


def bar(value: float, lower: float, upper: float, length: int) -> Text:
    """Position of a value between its limits, as a bar of `length` characters.

    Green; yellow near a limit, red beyond one. A stroke marks 0.
    """
    share = (value - lower) / (upper - lower)
    place = min(max(round(share * (length - 1)), 0), length - 1)
    zero = round(min(max(-lower / (upper - lower), 0.0), 1.0) * (length - 1))
    if not 0.0 <= share <= 1.0:
        style = "bold red"
    else:
        style = "yellow" if min(share, 1.0 - share) < _NEAR else "green"
    text = Text(no_wrap=True)
    for column in range(length):
        if column == place:
            text.append("█", style)
        elif min(zero, place) < column < max(zero, place):
            text.append("━", style)
        else:
            text.append("│" if column == zero else "·", "dim")
    return text


def _signals(sample: Snapshot, width: int) -> list[Text]:
    io = sample.io
    lines = []
    for name, digital, tool, volts in (
        ("inputs  ", io.digital_inputs, io.tool_inputs, io.analog_voltage_inputs),
        ("outputs ", io.digital_outputs, io.tool_outputs, io.analog_voltage_outputs),
    ):
        line = Text.assemble(
            (name, "dim"), *_lamps(digital), ("   tool ", "dim"), *_lamps(tool), **_ONE_LINE
        )
        if width >= _WHOLE:
            line.append("   volts ", "dim").append(_values(volts))
        lines.append(line)
    if width < _WHOLE:
        volts_in, volts_out = map(_values, (io.analog_voltage_inputs, io.analog_voltage_outputs))
        lines.append(Text.assemble(("volts   ", "dim"), f"{volts_in} in   {volts_out} out"))
        lines[-1].no_wrap, lines[-1].overflow = True, "ellipsis"
    return lines


def _lamps(signals: Sequence[bool]) -> list[tuple[str, str]]:
    """A lamp for each signal, a gap after every fourth."""
    return [
        (("●" if is_on else "·") + (" " if number % 4 == 0 else ""), "green" if is_on else "dim")
        for number, is_on in enumerate(signals, 1)
    ]


def _values(values: Sequence[float]) -> str:
    return " ".join(_number(value, 1) for value in values)


def _events(state: MonitorState, room: int, width: int) -> list[Text]:
    """The newest events that fit, in lines that are not cut off; only a single one is shortened."""
    lines: list[Text] = []
    for event in reversed(state.events):
        wrapped = textwrap.wrap(
            one_line(event.text), max(20, width - len(_EVENT_INDENT)), max_lines=room
        )
        if lines and len(lines) + len(wrapped) > room:
            break
        style = _STYLES[event.severity]
        lines[:0] = [
            Text.assemble((_EVENT_INDENT if number else f"{event.at}  ", "dim"), (part, style))
            for number, part in enumerate(wrapped or [""])
        ]
    return lines


def _line(event: EventLine) -> Text:
    style = _STYLES[event.severity]
    return Text.assemble((f"{event.at}  ", "dim"), (one_line(event.text), style), **_ONE_LINE)


def _notice(state: MonitorState) -> Text:
    if state.busy:
        return Text(f"{state.busy} …", style="bold yellow")
    return Text("") if state.notice is None else _line(state.notice)


def _keys() -> Text:
    return Text.assemble(
        (" space ", "bold white on red"),
        " or ",
        ("s", "bold"),
        " stop   ",
        ("p", "bold"),
        " pause   ",
        ("r", "bold"),
        " resume   ",
        ("q", "bold"),
        " quit, which stops nothing",
        no_wrap=True,
    )


def _limit(limits: Sequence[float]) -> str:
    """The limit that all joints share, as text; "limit" if they differ."""
    return f"{math.degrees(limits[0]):.0f}°" if len(set(limits)) == 1 else "limit"


def _number(value: float, digits: int) -> str:
    if math.isnan(value):
        return _NO
    return f"{round(value, digits) + 0.0:.{digits}f}"  # no -0.0
