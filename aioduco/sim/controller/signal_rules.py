"""Rules by which inputs follow outputs, like a cylinder's sensor: a pure state machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from aioduco.errors import ParameterError
from aioduco.models.ranges import FLAG, WAIT
from aioduco.models.rules import is_whole, stored

if TYPE_CHECKING:
    from aioduco.sim.cabinet.grippers import ValveGripper
    from aioduco.sim.cabinet.signals import Bank, Outputs, Signals


_TOOL = "tool"


@dataclass(frozen=True, slots=True)
class SignalRule:
    """An input that follows an output.

    Attributes:
        output: number of a general output, 1 to 16; "tool 1" and "tool 2" are those of the tool.
        input: number of a general input, likewise.
        after: delay with which it follows [s].
        inverted: whether it is on while the output is off.

    Raises:
        ParameterError: There is no such signal, or the time is negative.
    """

    output: int | str
    input: int | str
    after: float = 0.0
    inverted: bool = False

    def __post_init__(self) -> None:
        for name, signal in (("output", self.output), ("input", self.input)):
            tool, num = place(signal)
            if not is_whole(num) or not 1 <= num <= (2 if tool else 16):
                raise ParameterError(name, signal, '1 to 16, or "tool 1" or "tool 2"')
            if not isinstance(signal, str):
                object.__setattr__(self, name, int(num))
        stored(self, after=WAIT)
        FLAG("inverted", self.inverted)


def place(signal: int | str) -> tuple[bool, int]:
    """Whether a signal is one of the tool, and its number; 0 for a text that names no signal."""
    if not isinstance(signal, str):
        return False, signal
    kind, _, num = signal.strip().rpartition(" ")
    known = kind.strip() in ("", _TOOL) and num.isdecimal()
    return kind.strip() == _TOOL, int(num) if known else 0


class SignalRules:
    """Carries out rules in each cycle; from the first cycle on, an input has its rule's state.

    Attributes:
        gripper: a gripper on a valve that is wired to the signals; rules override it.
    """

    def __init__(self) -> None:
        self.gripper: ValveGripper | None = None
        self._last: dict[SignalRule, bool | None] = {}
        self._ruled: set[int] = set()  # numbers of general inputs that have a rule
        self._due: list[tuple[float, SignalRule, bool]] = []

    @property
    def busy(self) -> bool:
        """Whether an input is going to change."""
        return bool(self._due) or None in self._last.values()

    def add(self, rule: SignalRule) -> None:
        """Add a rule, which replaces a rule for the same input."""
        target = place(rule.input)
        self._last = {one: on for one, on in self._last.items() if place(one.input) != target}
        self._due = [due for due in self._due if place(due[1].input) != target]
        self._last[rule] = None
        tool, num = target
        if not tool:
            self._ruled.add(num)

    def restart(self) -> None:
        """Begin anew, with the rules that there are, for a controller that was just made."""
        self._last = dict.fromkeys(self._last)
        self._due.clear()

    def tick(self, time: float, signals: Signals) -> None:
        """Run one cycle.

        Args:
            time: simulated time [s].
            signals: signals whose outputs are watched and whose inputs are set.
        """
        if not self._last and self.gripper is None:
            return
        if self.gripper is not None:
            for num, on in self.gripper.tick(time, signals).items():
                if num not in self._ruled:
                    signals.standard_in[num] = on
        for rule, before in self._last.items():
            tool, num = place(rule.output)
            outputs: Outputs | Bank[bool] = signals.tool_out if tool else signals.standard_out
            on = outputs[num] if tool else signals.standard_out.level(num, time)
            if on is not before:
                self._last[rule] = on
                after = 0.0 if before is None else rule.after
                self._due.append((time + after, rule, on is not rule.inverted))
        # A tolerance of a nanosecond for the rounding of a sum of cycles.
        now = [due for due in self._due if due[0] <= time + 1e-9]
        if not now:
            return
        self._due = [due for due in self._due if due[0] > time + 1e-9]
        for _, rule, on in now:
            tool, num = place(rule.input)
            (signals.tool_in if tool else signals.standard_in)[num] = on
