"""A simulator in a process of its own, which ends with the process that started it."""

from __future__ import annotations

import pickle
import threading
from typing import TYPE_CHECKING, Any, Self

from aioduco._process.closing import Startable
from aioduco._process.linked_process import LinkedProcess
from aioduco._process.spawn import MUJOCO_PACKAGES, Unstartable
from aioduco.errors import Described, ParameterError
from aioduco.models.controller_clock import ScaledClock
from aioduco.models.host_port import host_port

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray


_SENDABLE = (
    "what another process can have: numbers, texts, lists and values of this package; programs as "
    "lists of calls or in a folder. A Simulator in this process, without spawn, takes functions"
)


def packed(options: Mapping[str, Any]) -> dict[str, bytes]:
    """Pickle arguments of `Simulator` one by one.

    Raises:
        ParameterError: one of them cannot be sent to another process.
    """
    data = {}
    for name, value in options.items():
        try:
            data[name] = pickle.dumps(value)
        except Exception as error:
            raise ParameterError(name, value, _SENDABLE) from error
    return data


def unpacked(data: Mapping[str, bytes]) -> dict[str, Any]:
    """Undo `packed`.

    Raises:
        ParameterError: one of them is of a class, or a function, that this process cannot import.
    """
    options = {}
    for name, value in data.items():
        try:
            options[name] = pickle.loads(value)
        except (AttributeError, ImportError) as error:
            own = Described(f"something that only your program has ({error})")
            raise ParameterError(name, own, _SENDABLE) from error
    return options


#: time-outs: until the process has sent its addresses, and until it has exited on request [s]
_START, _END = 60.0, 20.0


class SimulatorProcess(Startable):
    """A simulator in a process of its own.

    The process ends when its channel to this one closes. The system closes that when this process
    ends, a kill included.

    Args:
        options: arguments of `Simulator`.

    Raises:
        ParameterError: one of them cannot be sent to another process, as a function cannot.

    Attributes:
        host: address on which the simulator listens.
        port: its TCP port.
        status_port: TCP port of status frames; None if there is none.
        force_port: UDP port of the force stream; None if there is none.
        process: the process, for tests that kill it.
    """

    process: subprocess.Popen[bytes]

    def __init__(self, options: dict[str, Any]) -> None:
        self._options = options
        self._packed = packed(options)
        self._linked: LinkedProcess | None = None
        self._asking = threading.Lock()
        self.host: str = ""
        self.port: int = 0
        self.status_port: int | None = None
        self.force_port: int | None = None

    def __repr__(self) -> str:
        state = "not running" if self._linked is None else f"on {host_port(self.host, self.port)}"
        return f"<{type(self).__name__} {state}>"

    @property
    def pid(self) -> int:
        """Id of the process."""
        return self.process.pid

    @property
    def clock(self) -> ScaledClock:
        """Its time for `aioduco.connect(clock=...)`, computed from its speed; it cannot be held.

        Raises:
            ValueError: It runs as fast as possible, so its actual speed is unknown here.
        """
        return ScaledClock(float(self._options.get("speed", 1.0)))

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions of all moving parts, as `Simulator.positions`: the joints first [rad, m].

        Raises:
            RuntimeError: The simulator is not running.
        """
        if self._linked is None:
            raise RuntimeError("this simulator is not running")
        try:
            with self._asking:
                found: NDArray[np.float64] = self._linked.ask("positions")
        except (EOFError, OSError) as error:
            raise RuntimeError("the simulator's process has ended") from error
        return found

    def start(self) -> Self:
        """Start the process and wait until it listens.

        Raises:
            ValueError: An argument is wrong, as `Simulator` says; or it is of a class, or a
                function, that only this program has.
            OSError: It cannot listen on the address.
            RuntimeError: It could not be started, it ended before it listened, or it timed out. Or
                it is running already.
        """
        if self._linked is not None:
            raise RuntimeError("this simulator is running already")
        try:
            linked = LinkedProcess("aioduco.sim.spawned", packages=MUJOCO_PACKAGES, patience=_END)
        except Unstartable as error:
            raise RuntimeError(f"the simulator's process was not started: {error}") from error
        self._linked, self.process = linked, linked.popen
        try:
            linked.channel.send(self._packed)
            ready = linked.channel.receive(_START)
        except TimeoutError:
            self.close()
            raise RuntimeError(f"the simulator's process said nothing for {_START} s") from None
        except (EOFError, OSError) as error:
            self.close()
            raise RuntimeError(
                f"the simulator's process ended with status {self.process.returncode} before it "
                f"listened: {linked.stderr_tail}"
            ) from error
        except BaseException:
            self.close()
            raise
        if isinstance(ready, ValueError | OSError):
            self.close()
            raise ready
        self.host, self.port = ready["host"], ready["port"]
        self.status_port = ready["status_port"]
        self.force_port = ready["force_port"]
        return self

    def close(self) -> None:
        """End the process, and wait until it has exited."""
        linked, self._linked = self._linked, None
        if linked is not None:
            linked.close()
