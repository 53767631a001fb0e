"""An arm in simulated time that does exactly what it is told, with errors set by a test."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from aioduco._wire.rpc import Op
from aioduco.kinematics import arm as arm_of
from aioduco.models.enums import ProgramState, RobotState, SafetyState
from aioduco.models.pose import Pose
from aioduco.sim.twin.data import TwinCommand, TwinSample
from aioduco.sim.twin.predictor import Timeline
from aioduco.sim.twin.rehearsal import _Run

ARM = arm_of("gcr5_910")
READY = (0.0, 0.0, 1.57, 0.0, -1.57, 0.0)
NOWHERE = Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
#: time between two samples [s]
STEP = 0.008
#: torques at the joints [N m] for the joints, their speeds and the time
Torques = "Callable[[np.ndarray, np.ndarray, float], np.ndarray]"


def movej2(*q: float, v: float = 1.0) -> tuple[str, tuple[Any, ...]]:
    """A motion to six joints [rad]."""
    return "movej2", (list(q), v, 2.0, 0.0, False, Op(), False)


class PerfectArm:
    """Follows commands at once; what it reports may be changed by its attributes.

    Attributes:
        torques: gives the observed external torques; zero at first.
        late: time by which it gets commands later [s].
        geometry: lengths by which it computes its pose.
        changes: further values of its samples.
    """

    def __init__(self) -> None:
        self._run = _Run(ARM, np.array(READY), 0.0)
        self.time = 0.0
        self.torques: Callable[..., np.ndarray] = lambda _q, _qd, _t: np.zeros(6)
        self.late = 0.0
        self.geometry = ARM
        self.changes: dict[str, Any] = {}
        self._underway: list[tuple[float, str, tuple[Any, ...]]] = []

    def send(self, function: str, arguments: tuple[Any, ...]) -> TwinCommand:
        """Give it a command; return it as the program's twin hears of it."""
        self._underway.append((self.time + self.late, function, arguments))
        return TwinCommand(self.time, function, arguments, True)

    def another(self, function: str, arguments: tuple[Any, ...]) -> None:
        """Give it a command of another program."""
        self._underway.append((self.time, function, arguments))

    @property
    def stands(self) -> bool:
        return not self._underway and not self._run.controller.busy

    def sample(self) -> TwinSample:
        """Run for one interval of samples."""
        self.time = round(self.time + STEP, 6)
        for at, function, arguments in [each for each in self._underway if each[0] <= self.time]:
            self._underway.remove((at, function, arguments))
            assert self._run.call(function, arguments), self._run.reason
        self._run.advance(self.time)
        sensed = self._run.sensed
        q, qd = sensed.q, sensed.qd
        sample = TwinSample(
            self.time,
            tuple(q.tolist()),
            tuple(qd.tolist()),
            tuple(q.tolist()),
            tuple(qd.tolist()),
            tuple(Pose.from_matrix(self.geometry.fkine(q))),
            tuple(self.torques(q, qd, self.time).tolist()),
            None,
            int(RobotState.ENABLE),
            int(ProgramState.STOPPED if self.stands else ProgramState.RUNNING),
            int(SafetyState.RUN),
            0,
        )
        return sample._replace(**self.changes)


def work(perfect: PerfectArm, *motions: tuple[str, tuple[Any, ...]]) -> Iterator[Any]:
    """Yield samples and commands of a program with these motions, in the order of a twin."""
    line = Timeline()
    for motion in (None, *motions):
        if motion is not None:
            line.put(perfect.send(*motion))
        for _ in range(12):
            line.put(perfect.sample())
        while not perfect.stands:
            line.put(perfect.sample())
        yield from line.due()
    yield from line.rest()
