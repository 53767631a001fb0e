"""The simulator's side of a trial: it goes on past motions that cannot be carried out.

Every simulator that the program starts is tried, too, however it is started.
"""

from __future__ import annotations

import random
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from aioduco.sim.scene import MountingLike, SceneLike, mjcf_of
from aioduco.sim.simulator import Simulator
from aioduco.sim.trial import ControllerTrial
from aioduco.testing.preflight.going_on import MotionPlans

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.models.pose import JointsLike
    from aioduco.sim.controller.motion_queue import Plan
    from aioduco.sim.planner.segments import Segment
    from aioduco.testing.preflight.program_clock import ProgramClock
    from aioduco.testing.preflight.run_recorder import ProgramCall, RunRecorder
    from aioduco.testing.preflight.variation import Variation


class ProgramSimulator:
    """The simulator that the program runs on: its own, if it starts one, else the preflight's.

    Args:
        make: returns the preflight's simulator, started, when `attach` was called with it.
        attached: called with each simulator that is used.
    """

    def __init__(
        self, make: Callable[[], Simulator], attached: Callable[[Simulator], object]
    ) -> None:
        self._make = make
        self._attached = attached
        self._lock = threading.RLock()
        self.own: Simulator | None = None
        self.simulator: Simulator | None = None
        #: whether that one runs, and the addresses of all that were used
        self.runs: bool = False
        self.homes: set[tuple[str, int]] = set()

    def address(self) -> tuple[str, int]:
        """Host and port of the simulator, to which the program's connections lead."""
        with self._lock:
            if self.simulator is None:
                self.own = self._make()
            assert self.simulator is not None
            return self.simulator.host, self.simulator.port

    def attach(self, simulator: Simulator) -> None:
        """Use a simulator from now on."""
        with self._lock:
            self.simulator, self.runs = simulator, True
            self.homes.add((simulator.host, simulator.port))
            self._attached(simulator)

    def ports(self) -> set[int]:
        """The ports of the simulator that is used."""
        # Without the lock: a thread that holds it may be connecting.
        used = self.simulator
        return set() if used is None else {used.port, used.status_port or used.port}

    def close(self) -> None:
        """Close the preflight's simulator, if there is one."""
        if self.own is not None:
            self.own.close()


class TriedController(ControllerTrial):
    """Varies the simulator, and ties its tasks to the program's calls.

    Args:
        clock: the program's time.
        recorder: records the calls.
        simulator: the simulator that the program runs on.
        variation: what is varied.
        cycle: duration of one cycle of every simulator [s].

    Attributes:
        cell: the arguments of the simulator that was made last; None before.
    """

    def __init__(
        self,
        clock: ProgramClock,
        recorder: RunRecorder,
        simulator: ProgramSimulator,
        variation: Variation,
        cycle: float,
    ) -> None:
        self.cell: dict[str, Any] | None = None
        self._clock = clock
        self._recorder = recorder
        self._simulator = simulator
        self._variation = variation
        self._cycle = cycle
        self._random = random.Random(variation.seed)
        self._answered = 0
        self._plans = MotionPlans()
        #: on a connection's thread: the program's call that is answered, in `call`
        self._serving = threading.local()

    # -- simulators ----------------------------------------------------------------------------

    def made(
        self,
        arm: Arm,
        joints: JointsLike,
        *,
        scene: SceneLike | None,
        tool: SceneLike | None,
        gripper: str | None,
        mounting: MountingLike,
        pedestal: float,
    ) -> tuple[JointsLike, float, float]:
        """A simulator has the preflight's cycle, and the varied joints."""
        self.cell = {
            "model": arm.name, "gripper": gripper, "mounting": mounting, "pedestal": pedestal,
        }  # fmt: skip
        for key, things in (("scene", scene), ("tool", tool)):
            self.cell[key] = None if things is None else mjcf_of(things, free=key == "scene")
        if self._variation.start:
            joints = self._variation.started(joints, arm)
        return joints, self._cycle, 1.0

    def started(self, simulator: object) -> None:
        """The program runs on it, unless it runs on the preflight's."""
        assert isinstance(simulator, Simulator)
        if self._simulator.own is None:
            if self._simulator.runs:
                self._recorder.second_arm("starts a second simulator beside the first")
            self._simulator.attach(simulator)

    def closing(self, simulator: object) -> None:
        """The program's time and record end with it."""
        if self._simulator.simulator is simulator:
            self._simulator.runs = False
            self._recorder.finish()
            self._clock.detach()
            self._recorder.detach()

    # -- calls ---------------------------------------------------------------------------------

    def answer(self, name: str, answer: Callable[[], bytes]) -> bytes:
        """Answer a call, with the latency and the faults of the variation."""
        record = self._serving.call = self._recorder.match_call(name)
        try:
            if record is not None and self._variation.latency:
                with self.waiting():
                    self._clock.sleep(self._random.uniform(0.0, self._variation.latency))
            if record is not None and self._cuts():
                if self._random.random() < 0.5:
                    answer()
                raise ConnectionAbortedError(f"preflight cuts the connection at {name}")
            return answer()
        finally:
            self._serving.call = None

    def _cuts(self) -> bool:
        """Whether the connection is cut at this call."""
        self._answered += 1
        return self._answered in self._variation.faults

    @property
    def _call(self) -> ProgramCall | None:
        """The program's call that is answered on this thread."""
        return getattr(self._serving, "call", None)

    def task(self, number: int) -> None:
        """Tie the first task of a call to it: that of a mode, not that of its start."""
        if (call := self._call) is not None and call.task is None:
            self._recorder.task(call, number)

    @contextmanager
    def waiting(self) -> Iterator[None]:
        """Let the program's time go on."""
        if self._call is None:
            yield
            return
        self._clock.call_ends()
        try:
            yield
        finally:
            self._clock.call_begins()

    # -- motions -------------------------------------------------------------------------------

    def planned(self, name: str, arm: Arm, plan: Plan) -> Plan:
        """Plan another motion in place of one that cannot be planned."""
        call = self._call
        # external axes would have to be placed, too
        if call is None or call.where is None or call.of_vendor or name.endswith("_eaxis"):
            return plan

        def replaced(start: NDArray[Any]) -> Segment:
            return self._plans.plan(call, arm, plan, start)

        return replaced

    def passes_over(self) -> bool:
        """Whether the arm moves on a path that is not the program's."""
        return self._recorder.passing_over
