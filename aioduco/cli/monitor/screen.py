"""Render a monitor's state in a terminal, from the state and the terminal's size alone."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from rich.console import Group
from rich.table import Table
from rich.text import Text

from aioduco.cli.output import one_line
from aioduco.models.enums import RobotState, SafetyState

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.console import RenderableType

    from aioduco.cli.monitor.view_state import EventLine, MonitorState
    from aioduco.supervision.state_feed import Snapshot

__all__ = ["bar", "screen"]

_STYLES: Final = {"info": "", "good": "green", "warning": "yellow", "alarm": "bold red"}
#: number of lines besides the events
_LINES: Final = 19
#: number of columns besides the bars
_COLUMNS: Final = 70
_LEAST_BAR, _MOST_BAR = 8, 48
#: part of a joint's range, at each end, that counts as near the limit
_NEAR: Final = 0.05
_POSE: Final = ("x", "y", "z", "rx", "ry", "rz")
_NO: Final = "–"


def screen(state: MonitorState, width: int, height: int) -> RenderableType:
    """The whole screen, for a terminal of `width` columns and `height` lines."""
    lines: list[RenderableType] = [_head(state, width), _states(state), _doing(state)]
    lines.append(Text(f" {state.alarm} ", style="bold white on red") if state.alarm else Text(""))
    if state.sample is not None:
        lines += [_arm(state, state.sample, width), Text(""), *_signals(state.sample)]
    room = max(1, height - _LINES)
    lines += [Text(""), *_events(state, room)]
    lines += [_notice(state), _keys()]
    return Group(*lines)


def _head(state: MonitorState, width: int) -> Text:
    rate = f"{state.measured_rate:.1f} of {state.rate:g} Hz"
    if state.answer_time is not None:
        rate += f", answered in {state.answer_time * 1e3:.0f} ms"
    title = f"{state.robot}  {state.arm}".rstrip()
    gap = max(2, width - len(title) - len(rate) - 1)
    return Text.assemble(
        (title, "bold"), " " * gap, (rate, "red" if state.silent else "dim"), no_wrap=True
    )


def _states(state: MonitorState) -> Text:
    if state.sample is None:
        return Text("no sample yet", style="yellow")
    states = state.sample.states
    ready = states.robot is RobotState.ENABLE
    safe = states.safety in {SafetyState.RUN, SafetyState.REDUCE}
    speed = _NO if state.speed is None else f"{state.speed:g} %"
    return Text.assemble(
        "robot ",
        (states.robot.name, "green" if ready else "yellow"),
        "   program ",
        (states.program.name, "bold"),
        "   safety ",
        (states.safety.name, "green" if safe else "bold red"),
        "   mode ",
        (states.mode.name, "bold"),
        f"   speed {speed}",
        style="dim" if state.silent else "",
        no_wrap=True,
    )


def _doing(state: MonitorState) -> Text:
    errors = f"   errors: {one_line('; '.join(state.errors))}" if state.errors else ""
    return Text.assemble(state.doing, (errors, "red"), no_wrap=True, overflow="ellipsis")


def _arm(state: MonitorState, sample: Snapshot, width: int) -> Table:
    status, forces = sample.status, sample.read_forces
    length = min(max(width - _COLUMNS, _LEAST_BAR), _MOST_BAR)
    table = Table(box=None, padding=(0, 1), header_style="dim")
    table.add_column("")
    table.add_column(f"{_limit(state.lower)} … {_limit(state.upper)}", no_wrap=True)
    for heading in ("angle", "°/s", "N·m", "", "tool", "force"):
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
            _POSE[row],
            shown,
            f"{_number(force, 2)} {'N·m' if turns else 'N  '}",
            style="dim" if state.silent else "",
        )
    return table


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


def _signals(sample: Snapshot) -> list[Text]:
    io = sample.io
    return [
        Text.assemble(
            ("inputs  ", "dim"),
            *_lamps(io.digital_inputs),
            ("   tool ", "dim"),
            *_lamps(io.tool_inputs),
            ("   volts ", "dim"),
            _values(io.analog_voltage_inputs),
            no_wrap=True,
        ),
        Text.assemble(
            ("outputs ", "dim"),
            *_lamps(io.digital_outputs),
            ("   tool ", "dim"),
            *_lamps(io.tool_outputs),
            ("   volts ", "dim"),
            _values(io.analog_voltage_outputs),
            no_wrap=True,
        ),
    ]


def _lamps(signals: Sequence[bool]) -> list[tuple[str, str]]:
    """A lamp for each signal, a gap after every fourth."""
    return [
        (("●" if is_on else "·") + (" " if number % 4 == 0 else ""), "green" if is_on else "dim")
        for number, is_on in enumerate(signals, 1)
    ]


def _values(values: Sequence[float]) -> str:
    return " ".join(_number(value, 1) for value in values)


def _events(state: MonitorState, room: int) -> list[Text]:
    return [_line(event) for event in state.events[-room:]]


def _line(event: EventLine) -> Text:
    style = _STYLES[event.severity]
    return Text.assemble(
        (f"{event.at}  ", "dim"), (one_line(event.text), style), no_wrap=True, overflow="ellipsis"
    )


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
