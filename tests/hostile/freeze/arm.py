"""A simulated controller in a process of its own, which is never frozen, and a witness of its arm.

    python -m hostile.freeze.arm

It reads requests from its standard input and writes answers to its standard output, pickled. It
runs one simulator after another, as the imports take longer than a simulator does.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any, BinaryIO, Self

import numpy as np
from numpy.typing import NDArray

from aioduco.sim.snapshot import SimulationSnapshot

from .cells import CYCLE, HOME
from .clock import now

#: of each cycle, the time, the simulated time [s] and the joints [rad]. Shape (n, 8).
Seen = NDArray[np.float64]

#: how much faster than real time the arm is brought up
_HASTE = 200.0
_TESTS = Path(__file__).parents[2]


class Arm:
    """The process, and the simulator in it, as a run uses it."""

    def __init__(self) -> None:
        self._process = self._started()
        self._seen: Seen = np.empty((0, 8))

    def _started(self) -> subprocess.Popen[bytes]:
        path = os.pathsep.join(filter(None, [str(_TESTS), os.environ.get("PYTHONPATH")]))
        return subprocess.Popen(
            [sys.executable, "-m", "hostile.freeze.arm"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            # a Ctrl-C at the terminal is for the tests
            start_new_session=True,
            env={**os.environ, "PYTHONPATH": path, "MUJOCO_GL": "disable"},
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def begin(self) -> int:
        """Start another simulator, whose arm is brought up. Returns its port."""
        if self._process.poll() is not None:  # a run before has failed with it
            self.close()
            self._process = self._started()
        self._seen = np.empty((0, 8))
        port: int = self._ask("begin")
        return port

    @property
    def seen(self) -> Seen:
        """All that was seen of the arm since `begin`."""
        self._seen = np.concatenate([self._seen, self._ask("seen")])
        return self._seen

    def end(self) -> None:
        """End the simulator."""
        self._ask("end")

    def close(self) -> None:
        """End the process."""
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()
        try:
            self._process.wait(10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _ask(self, request: object) -> Any:
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None
        assert stdout is not None
        pickle.dump(request, stdin)
        stdin.flush()
        return pickle.load(stdout)


class _Witness:
    """Sees each cycle; on the simulation's thread."""

    def __init__(self) -> None:
        self._new: list[tuple[float, ...]] = []

    def see(self, snapshot: SimulationSnapshot, _contacts: object) -> None:
        self._new.append((now(), snapshot.time, *snapshot.positions[:6].tolist()))

    def take(self) -> Seen:
        count = len(self._new)
        new, self._new[:count] = self._new[:count], []
        return np.array(new).reshape(-1, 8)


def _serve(requests: BinaryIO, answers: BinaryIO) -> None:
    import aioduco.sync  # noqa: PLC0415 - not in the process that tests
    from aioduco.sim import Simulator  # noqa: PLC0415

    def answer(value: object) -> None:
        pickle.dump(value, answers)
        answers.flush()

    while pickle.load(requests) == "begin":
        with Simulator(cycle=CYCLE, speed=_HASTE, joints=HOME) as sim:
            with aioduco.sync.connect(sim.host, sim.port, heartbeat=None) as robot:
                robot.bring_up()
            sim.speed = 1.0
            witness = _Witness()
            sim.observe(witness.see)
            answer(sim.port)
            while pickle.load(requests) == "seen":
                answer(witness.take())
        answer(None)


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # what the package logs is not to be taken for an answer
    _answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    with contextlib.suppress(EOFError):
        _serve(sys.stdin.buffer, _answers)
