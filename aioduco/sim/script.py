"""Programs of a simulated controller: calls of the wire, one after the other.

How the vendor's programs are stored and written is not public. Here a program is a list of calls,
each the name of a function of the wire and its arguments, as a JSON file has them too:

    [["movej2", [0, 0, 1.57, 0, -1.57, 0], 1.0, 2.0], ["sleep", 0.5], ["stop"]]

or a generator function that yields such calls, and gets their answers:

    def pick():
        while not (yield "get_standard_digital_in", 3):
            yield "sleep", 0.1
        yield "set_standard_digital_out", 1, True

It runs in the controller's cycle, so it must not wait by itself.

Arguments at the end that are left out are zero, `block` is true, and a struct may be a mapping.
"sleep" is no function of the wire: it waits so many seconds of simulated time.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Generator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from aioduco._wire import idl
from aioduco.models.enums import TaskState
from aioduco.sim.execution import ProgramError
from aioduco.sim.refusal import Pending, Refusal

if TYPE_CHECKING:
    from aioduco.sim.tasks import TaskTable

__all__ = ["Call", "Script", "Steps", "checked", "read"]

#: a function of the wire and its arguments
Call: TypeAlias = Sequence[Any]
#: a program
Script: TypeAlias = Sequence[Call] | Callable[[], Generator[Call, Any, object]]

_SLEEP = "sleep"
#: motions whose r or rad is a blend radius
_BLENDING = frozenset(
    {
        *("movej", "movej2", "movej_pose", "movej_pose2", "movel", "movec", "move_circle"),
        *("tcp_move", "tcp_move_2p", "wobj_move", "wobj_move_2p", "spline", "spline_op"),
        *("movej2_eaxis", "movej2_pose_eaxis", "movel_eaxis", "movec_eaxis"),
    }
)
_WENT_WELL = (TaskState.FINISHED, TaskState.INTERRUPT)


def read(folder: str | Path) -> dict[str, list[Call]]:
    """Read the programs of a folder: its files "<name>.json".

    Raises:
        ValueError: A file is no program, or leads out of the folder.
        OSError: The folder or a file cannot be read.
    """
    root = Path(folder).resolve(strict=True)
    found: dict[str, list[Call]] = {}
    for file in sorted(root.glob("*.json")):
        if file.resolve(strict=True).parent != root:
            raise ValueError(f"{file} leads out of {root}")
        try:
            calls = json.loads(file.read_text(encoding="utf-8"))
        except ValueError as exc:
            raise ValueError(f"{file} is no JSON: {exc}") from None
        checked(str(file), calls)
        found[file.stem] = calls
    return found


def checked(name: str, script: Script) -> Script:
    """Check what can be checked before a program runs.

    Raises:
        ValueError: A call is none of the wire.
    """
    if callable(script):
        return script
    if not isinstance(script, (list, tuple)):
        # It may come from a file: its content is wrong, not its type.
        raise ValueError(f"{name} must be a list of calls, or a generator function")  # noqa: TRY004
    for number, call in enumerate(script, 1):
        try:
            _prepared(call)
        except ProgramError as exc:
            raise ValueError(f"{name}, call {number}: {exc}") from None
    return script


class Steps:
    """One run of a program, made of its calls.

    A call waits until the task that it makes has ended, and the program cannot go on when it ended
    badly. A motion with a blend radius is not waited for while motions follow: the next one has to
    be known for the two to blend. How far ahead it is read is set as the manual has it.

    Args:
        name: of the program, for messages.
        script: the program.
        make: makes a call of the wire; raises Pending where a client would wait.
        tasks: what the tasks of the calls are asked for.
        ahead: what set_blend_ahead has set: from which part of a motion on the next one is read
            [%]; and if that is 0, how many are.
        progress: how much of its way the running motion has made, 0 to 1.
    """

    def __init__(
        self,
        name: str,
        script: Script,
        make: Callable[[str, tuple[Any, ...]], Any],
        tasks: TaskTable,
        *,
        ahead: Callable[[], tuple[int, int]] = lambda: (0, 1),
        progress: Callable[[], float] = lambda: 0.0,
    ) -> None:
        self._name = name
        self._calls: Generator[Call, Any, object] = (
            script() if callable(script) else (call for call in script)
        )
        self._make = make
        self._tasks = tasks
        self._read_ahead = ahead
        self._progress = progress
        self._answer: Any = None
        self._next: tuple[str, tuple[Any, ...], bool] | None = None
        self._ahead: list[tuple[str, int]] = []  # motions that may blend into the next
        self._waiting: tuple[str, int] | None = None
        self._sleep = 0.0
        self._over = False

    def go_on(self, passed: float) -> bool:
        """Go on by a cycle; see `Run`."""
        self._sleep -= passed
        # Half a cycle for the rounding of a sum of cycles.
        if self._sleep > 0.5 * passed:
            return False
        self._sleep = 0.0
        self._ahead = [motion for motion in self._ahead if not self._ended(*motion)]
        if self._waiting is not None:
            if not self._ended(*self._waiting):
                return False
            self._answer = int(self._tasks.state(self._waiting[1]))
            self._waiting = None
        if self._next is None and not self._over:
            if self._reads_enough():
                return False
            self._fetch()
        if self._next is None:
            return not self._ahead
        name, values, blends = self._next
        if self._ahead and name not in _BLENDING:
            return False
        self._next = None
        self._answer = self._call(name, values, blends=blends)
        return False

    def close(self) -> None:
        """End the generator, if it is one."""
        self._calls.close()

    def _reads_enough(self) -> bool:
        """Whether the program has been read far enough ahead of the running motion."""
        if not self._ahead:
            return False
        part, count = self._read_ahead()
        if part > 0:
            return len(self._ahead) > 1 or self._progress() < part / 100.0
        return len(self._ahead) > count

    def _fetch(self) -> None:
        try:
            self._next = _prepared(self._calls.send(self._answer))
        except StopIteration:
            self._over = True
        except ProgramError as exc:
            raise self._error(str(exc)) from None
        except Exception as exc:
            raise self._error(repr(exc)) from exc
        self._answer = None

    def _call(self, name: str, values: tuple[Any, ...], *, blends: bool) -> Any:
        if name == _SLEEP:
            self._sleep = values[0]
            return None
        try:
            answer = self._make(name, values)
        except Pending as exc:
            self._waiting = name, exc.id
            return None
        except Refusal as exc:
            raise self._error(str(exc)) from None
        except Exception as exc:
            raise self._error(f"{name}: {exc!r}") from exc
        if blends:
            self._ahead.append((name, answer))
            return int(TaskState.INTERRUPT)  # the end of a motion that blends
        return answer

    def _ended(self, name: str, id_: int) -> bool:
        state = self._tasks.state(id_)
        if not state.ended:
            return False
        if state not in _WENT_WELL:
            task = self._tasks.get(id_)
            why = "" if task is None else task.message
            raise self._error(f"{name} ended with {state.name}: {why}")
        return True

    def _error(self, message: str) -> ProgramError:
        return ProgramError(f"program {self._name!r}: {message}")


def _prepared(call: Call) -> tuple[str, tuple[Any, ...], bool]:
    """A call's name, its arguments as the wire's, and whether it blends into the next."""
    if isinstance(call, str) or not isinstance(call, Sequence) or not call:
        raise ProgramError(f"{call!r} is no call: it must be a name and arguments")
    name, *given = call
    if name == _SLEEP:
        if len(given) != 1 or not isinstance(given[0], (int, float)) or not 0 <= given[0] < 1e9:
            raise ProgramError("sleep takes a time in seconds")
        return name, tuple(given), False
    function = idl.functions().get(name) if isinstance(name, str) else None
    if function is None:
        raise ProgramError(f"there is no function {name!r}")
    if len(given) > len(function.parameters):
        raise ProgramError(f"{name} takes {len(function.parameters)} arguments, not {len(given)}")
    values: dict[str, Any] = {}
    blends = False
    specs = function.args.thrift_spec.values()
    for index, (_, parameter, spec, *_) in enumerate(specs):
        if index < len(given):
            values[parameter] = _typed(spec, given[index])
        else:
            values[parameter] = True if parameter == "block" else function.zeros[index]()
        if parameter in ("r", "rad") and name in _BLENDING:
            radius = values[parameter]
            blends = isinstance(radius, (int, float)) and radius > 0.0
    if blends:
        values["block"] = False
    return name, tuple(values.values()), blends


def _typed(spec: Any, value: Any) -> Any:
    """A value with each mapping that stands for a struct replaced by the struct.

    A struct's field spec is its class, a list's a pair whose second is that of its elements.
    """
    if isinstance(spec, type) and isinstance(value, Mapping):
        fields = {entry[1]: entry[2] for entry in vars(spec)["thrift_spec"].values()}
        unknown = sorted(set(value) - set(fields))
        if unknown:
            raise ProgramError(f"{spec.__name__} has no {unknown[0]!r}")
        return spec(**{name: _typed(fields[name], each) for name, each in value.items()})
    if isinstance(spec, tuple) and isinstance(value, list):
        return [_typed(spec[1], each) for each in value]
    return value
