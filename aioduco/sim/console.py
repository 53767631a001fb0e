"""Actions of a person at the machine, as lines of text: the commands of `aioduco sim-do`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from aioduco.models.enums import OperationMode
from aioduco.models.similar import did_you_mean

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.sim.simulator import Simulator


class _Command(NamedTuple):
    usage: str
    purpose: str
    run: Callable[[Simulator, list[str]], str | None]


class _Misuse(Exception):
    """The words after a command make no sense."""


class Console:
    """Carries out commands on a simulator.

    Args:
        simulator: a running one.
    """

    def __init__(self, simulator: Simulator) -> None:
        self._simulator = simulator

    def answer(self, line: str) -> str:
        """Carry out a line such as "input 3 on" and give the answer, which begins with "error" if
        the command failed.
        """
        name, *words = line.split() or ["help"]
        command = COMMANDS.get(name)
        if command is None:
            near = did_you_mean(name, COMMANDS)
            return f"error: there is no command {name!r}; there are {', '.join(COMMANDS)}{near}"
        try:
            said = command.run(self._simulator, words)
        except _Misuse as exc:
            return f"error: {exc}; usage: {command.usage}"
        except (ValueError, IndexError, RuntimeError) as exc:
            return f"error: {exc}"
        return said or "ok"


def _numbers(words: list[str], *counts: int) -> list[float]:
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        raise _Misuse(f"{' '.join(words)!r} are no numbers") from None
    if any(map(math.isnan, numbers)):
        raise _Misuse(f"{' '.join(words)!r} are no numbers")
    if len(numbers) not in counts:
        raise _Misuse(f"{len(numbers)} numbers")
    return numbers


def _whole(word: str) -> int:
    (number,) = _numbers([word], 1)
    if not number.is_integer():
        raise _Misuse(f"{word} is no whole number")
    return int(number)


def _signal(words: list[str]) -> tuple[int | str, list[str]]:
    """A signal such as "3" or "tool 1", and the words behind it."""
    if words[:1] == ["tool"] and len(words) > 1:
        return f"tool {words[1]}", words[2:]
    if not words or not words[0].isdecimal():
        raise _Misuse("which signal?")
    return int(words[0]), words[1:]


def _switch(words: list[str]) -> bool:
    states = {"on": True, "1": True, "off": False, "0": False}
    if len(words) != 1 or words[0] not in states:
        raise _Misuse("on or off?")
    return states[words[0]]


def _nothing(words: list[str]) -> None:
    if words:
        raise _Misuse(f"{' '.join(words)!r} is too much")


def _input(sim: Simulator, words: list[str]) -> None:
    signal, rest = _signal(words)
    on = _switch(rest)
    if isinstance(signal, int):
        sim.set_digital_input(signal, on)
    else:
        sim.set_tool_digital_input(_whole(signal.removeprefix("tool ")), on)


def _output(sim: Simulator, words: list[str]) -> str:
    signal, rest = _signal(words)
    _nothing(rest)
    if isinstance(signal, int):
        on = sim.get_digital_output(signal)
    else:
        on = sim.signals.tool_out[_whole(signal.removeprefix("tool "))]
    return "on" if on else "off"


def _voltage(sim: Simulator, words: list[str]) -> None:
    _, volts = _numbers(words, 2)
    sim.signals.voltage_in[_whole(words[0])] = volts


def _rule(sim: Simulator, words: list[str]) -> None:
    output, rest = _signal(words)
    target, rest = _signal(rest)
    inverted = rest[-1:] == ["inverted"]
    (after,) = _numbers(rest[:-1] if inverted else rest, 0, 1) or [0.0]
    sim.rule(output, target, after=after, inverted=inverted)


def _press(sim: Simulator, words: list[str]) -> None:
    _nothing(words)
    sim.emergency_stop()


def _release(sim: Simulator, words: list[str]) -> None:
    _nothing(words)
    sim.release_emergency_stop()


def _push(sim: Simulator, words: list[str]) -> None:
    numbers = _numbers(words, 0, 3, 6)
    sim.push(numbers + [0.0] * (6 - len(numbers)))


def _collide(sim: Simulator, words: list[str]) -> None:
    _numbers(words, 1)
    sim.collide(_whole(words[0]))


def _load(sim: Simulator, words: list[str]) -> None:
    mass, *centre = _numbers(words, 1, 4)
    sim.load(mass, centre or (0.0, 0.0, 0.0))


def _where(sim: Simulator, words: list[str]) -> str:
    if len(words) != 1:
        raise _Misuse("which part?")
    found = sim.where(words[0])
    numbers = " ".join(f"{number:.4f}" for number in found.pose)
    doing = "held" if found.held else "not held"
    return f"at {numbers} m, rad; {doing}; touches {', '.join(found.touches) or 'nothing'}"


def _parts(sim: Simulator, words: list[str]) -> str:
    _nothing(words)
    return " ".join(sim.parts) or "there is none"


def _drop_part(sim: Simulator, words: list[str]) -> None:
    sim.drop_part(*_numbers(words, 0, 1))


def _remove(sim: Simulator, words: list[str]) -> None:
    if len(words) != 1:
        raise _Misuse("which part?")
    sim.remove_part(words[0])


def _put(sim: Simulator, words: list[str]) -> None:
    if not words:
        raise _Misuse("which part?")
    numbers = _numbers(words[1:], 3, 6)
    sim.put_part(words[0], numbers + [0.0] * (6 - len(numbers)))


def _stick(sim: Simulator, words: list[str]) -> None:
    if len(words) not in (2, 3):
        raise _Misuse("which two parts?")
    sim.stick_parts(*words[:2], stuck=len(words) == 2 or _switch(words[2:]))


def _grip(sim: Simulator, words: list[str]) -> None:
    sim.set_grip(*_numbers(words, 1))


def _mass(sim: Simulator, words: list[str]) -> None:
    if not words:
        raise _Misuse("which part?")
    sim.set_part_mass(words[0], *_numbers(words[1:], 1))


def _wear(sim: Simulator, words: list[str]) -> None:
    sim.wear_tool(*_numbers(words, 1))


def _drag(sim: Simulator, words: list[str]) -> None:
    sim.drag(_numbers(words, 0, 6) or [0.0] * 6)


def _mode(sim: Simulator, words: list[str]) -> None:
    modes = {mode.name.lower(): mode for mode in OperationMode}
    if len(words) != 1 or words[0] not in modes:
        raise _Misuse(f"one of {', '.join(modes)}")
    sim.switch_mode(modes[words[0]])


def _drop(sim: Simulator, words: list[str]) -> str:
    _nothing(words)
    return f"{sim.drop_connections()} connections were cut"


def _speed(sim: Simulator, words: list[str]) -> None:
    (sim.speed,) = _numbers(words, 1)


def _state(sim: Simulator, words: list[str]) -> str:
    _nothing(words)
    view = sim.view
    states = (view.robot, view.program, view.safety, view.mode)
    return "\n".join(
        (
            f"time {sim.time:.3f} s",
            f"joints {' '.join(f'{angle:.4f}' for angle in sim.joints)} rad",
            f"moving {'yes' if sim.moving else 'no'}",
            "states " + " ".join(f"{state.name.lower()}" for state in states),
            *(f"error list: {text}" for text in view.errors),
        )
    )


def _help(_: Simulator, words: list[str]) -> str:
    _nothing(words)
    return "\n".join(f"{one.usage:<34}{one.purpose}" for one in COMMANDS.values())


COMMANDS: dict[str, _Command] = {
    one.usage.split()[0]: one
    for one in (
        _Command("input [tool] NUM on|off", "set a digital input", _input),
        _Command("output [tool] NUM", "tell whether a digital output is on", _output),
        _Command("voltage NUM VOLTS", "set an analog input of the cabinet", _voltage),
        _Command("rule OUT IN [SECONDS] [inverted]", "have an input follow an output", _rule),
        _Command("estop", "press the emergency stop", _press),
        _Command("release", "release the emergency stop", _release),
        _Command("push [FX FY FZ [TX TY TZ]]", "push at the flange; alone: end the push", _push),
        _Command("collide JOINT", "let a joint detect a collision", _collide),
        _Command("load KG [X Y Z]", "hang a load on the flange", _load),
        _Command("parts", "name the loose things of the scene", _parts),
        _Command("where PART", "tell where a part is, and what it touches", _where),
        _Command("drop-part [SECONDS]", "let the gripper lose what it holds", _drop_part),
        _Command("remove PART", "take a part away", _remove),
        _Command("put PART X Y Z [RX RY RZ]", "put a part there", _put),
        _Command("stick PART PART [off]", "have two parts stick together", _stick),
        _Command("grip SHARE", "grip worse, 0 to 1; 1: as usual", _grip),
        _Command("mass PART KG", "give a part another mass", _mass),
        _Command("wear METRES", "shorten the tool", _wear),
        _Command("drag [T1 T2 T3 T4 T5 T6]", "torques that drag at the joints; alone: none", _drag),
        _Command("mode manual|auto|remote", "turn the mode switch", _mode),
        _Command("drop", "cut every connection, as a pulled cable does", _drop),
        _Command("speed FACTOR", "go faster or slower than the wall clock", _speed),
        _Command("state", "tell where the arm is, its states and error list", _state),
        _Command("help", "tell these commands", _help),
    )
}
"""The commands of `Console`, by name."""
