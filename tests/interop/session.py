"""Brings the simulated arm to where each call of the table begins."""

from __future__ import annotations

from typing import Any

from aioduco.testing import eventually

from .clients import Client, Lost

HOME = [0.0, 0.0, 1.5708, 0.0, -1.5708, 0.0]
FINISHED, AUTO = 4, 1
READY, UNPOWERED = [6, 0, 5, 1], [4, 0, 4, 1]
_UNDER_WAY = (0, 1, 2)
#: how long a motion of the table may take, by the wall clock [s]
_PATIENCE = 30.0
_BLOCK = {"block": True}
_WAY_HOME = {"joints_list": HOME, "v": 3.0, "a": 20.0, "block": True}


class Session:
    """A client at a controller.

    Args:
        client: calls the functions.
    """

    def __init__(self, client: Client) -> None:
        self.client = client

    def call(self, name: str, args: dict[str, Any] | None = None) -> Any:
        """Call a function as the present client does."""
        return self.client.call("RPCRobot", name, args or {})

    def state(self) -> Any:
        """The robot's states; waits for a controller that is starting again."""
        answers: list[Any] = []

        def answered() -> bool:
            answers.append(self.call("get_robot_state"))
            return not isinstance(answers[-1], Lost)

        eventually(answered, _PATIENCE)
        return answers[-1]

    def end(self, id_: int) -> Any:
        """The state in which a task ends; "lost" if the connection does first.

        A task without an end is stopped, and its state before that told.
        """
        states: list[Any] = []

        def ended() -> bool:
            states.append(self.call("get_noneblock_taskstate", {"id": id_}))
            return isinstance(states[-1], Lost) or states[-1] not in _UNDER_WAY

        try:
            eventually(ended, _PATIENCE)
        except AssertionError:
            self.call("stop", _BLOCK)
        return "lost" if isinstance(states[-1], Lost) else states[-1]

    def enabled(self) -> None:
        """An enabled arm at home, in automatic mode, with nothing under way."""
        if self.state() != READY:
            self._do("stop", _BLOCK)
            self._do("switch_mode", {"mode": AUTO})
            for name in ("power_off", "power_on", "enable"):
                self._do(name, _BLOCK)
        if far(self.call("get_actual_joints_position"), HOME) > 1e-3:
            self._do("movej2", _WAY_HOME)

    def unpowered(self) -> None:
        """An arm without power, in automatic mode."""
        if self.state() != UNPOWERED:
            self._do("switch_mode", {"mode": AUTO})
            self._do("power_off", _BLOCK)

    def _do(self, name: str, args: dict[str, Any]) -> None:
        answer = self.call(name, args)
        assert answer == FINISHED, (name, answer, self.call("get_last_error"))


def far(a: list[float], b: list[float]) -> float:
    """The greatest difference of two joint vectors [rad]."""
    return max(abs(x - y) for x, y in zip(a, b, strict=True))
