"""The promises, with an unpatched `connect`: each program runs in a process of its own.

The other tests give programs more patience than users have, so that a busy machine does not end
what they test. Here the defaults hold. A busy machine may make a program miss one of them, and the
program is then told by a typed error; whatever it was told, the arm must stand and stay. So the
arm's positions alone decide, not how soon anything happened.
"""

from __future__ import annotations

import bisect
import signal
import subprocess
import sys
import textwrap
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from adversity.arm import ready

from aioduco.sim import Simulator
from aioduco.testing import eventually

#: a program: `told` says that it was told something, or that a call has returned
PROGRAM = """
import asyncio, os, sys, time
import aioduco
HOME, FAR = [0.0, 0.0, 1.57, 0.0, -1.57, 0.0], [2.5, 0.0, 1.57, 0.0, -1.57, 0.0]
def told(what):
    print("told", what, flush=True)
def begun():
    print("begun", flush=True)
async def main():
    async with aioduco.connect({host!r}, {port}, guard={guard!r}) as robot:
{body}
try:
    asyncio.run(main())
except aioduco.DucoError as exc:
    told(type(exc).__name__)
"""
STREAM = """
async with robot.servo.joints(v=1.0, a=3.0) as stream:
    begun()
    for tick in range(10_000):
        await stream.send([0.003 * tick, *HOME[1:]])
"""
MOTION = """
move = await robot.motion.movej2(FAR, v=0.2, a=1.0).start()
begun()
"""
#: what the program does with a motion, or a stream; then the test does what `DEEDS` says
BODIES = {
    "stop": MOTION + "await asyncio.sleep(0.3)\nawait robot.stop()\ntold('stop')\n"
    "await asyncio.sleep(2.0)\n",
    "stop_now": MOTION + "await asyncio.to_thread(robot.stop_now)\ntold('stop_now')\n"
    "await asyncio.sleep(2.0)\n",
    "cancel": MOTION + "try:\n    async with asyncio.timeout(0.3):\n        await move\n"
    "except TimeoutError:\n    told('cancelled')\nawait asyncio.sleep(2.0)\n",
    "leave": MOTION + "await asyncio.sleep(0.3)\n",
    "raise": MOTION + "raise aioduco.DucoError('of the program')\n",
    "resume and leave": MOTION + "await robot.pause()\nawait robot.resume()\n",
    "hang": MOTION + "time.sleep(3.0)\nawait move\n",
    "wait": MOTION + "await move\n",
    "stream": STREAM,
    "stream and stop": STREAM.replace(
        "begun()", "begun()\n    asyncio.get_running_loop().call_later(1.0, robot.stop_now)"
    ),
}
#: body, and what the test does to the program once the arm moves
CASES = {
    **{name: (name, "") for name in BODIES if name not in ("wait", "stream")},
    "killed": ("wait", "kill"),
    "stream killed": ("stream", "kill"),
    "interrupted": ("wait", "interrupt"),
    "stream interrupted": ("stream", "interrupt"),
    "frozen": ("wait", "freeze"),
    "stream frozen": ("stream", "freeze"),
}
_STILL = 2e-3  # rad: what a standing arm may sway
_SEEN = 0.4  # s: time of the arm over which is judged whether it moves
_WATCHED = 1.5  # s: time of the arm for which one that has come to rest is watched


class Arm:
    """Where the arm was: the cycles that the simulator shows, fewer while it stands."""

    def __init__(self, sim: Simulator) -> None:
        self.cycles: list[tuple[float, ...]] = []
        self.times: list[float] = []
        self._sim = sim
        sim.observe(self._see)

    def _see(self, snapshot: Any, *_: object) -> None:
        self.cycles.append(tuple(snapshot.positions[:6]))
        self.times.append(self._sim.time)

    def seen(self, seconds: float, since: int = 0) -> bool:
        """Whether it was seen for so long, from a cycle on [s of the arm]."""
        return len(self.times) > since and self.times[-1] - self.times[since] > seconds

    def moves(self) -> bool:
        """Whether it moved within the last time, or was not seen for so long."""
        begin = bisect.bisect_left(self.times, (self.times or [0.0])[-1] - _SEEN)
        last = np.array(self.cycles[begin:])
        return not self.seen(_SEEN) or bool(np.ptp(last, axis=0).max() > _STILL / 10)

    def moved_since(self, cycle: int) -> float:
        """How far it has been from where it was at a cycle [rad]."""
        after = np.array(self.cycles[cycle:])
        return float(np.abs(after - after[0]).max())


@contextmanager
def program(sim: Simulator, body: str, guard: str | None) -> Iterator[subprocess.Popen[str]]:
    code = PROGRAM.format(
        host=sim.host, port=sim.port, guard=guard, body=textwrap.indent(body, " " * 8)
    )
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as child:
        try:
            yield child
        finally:
            child.kill()


@pytest.mark.parametrize("guard", [None, "process"], ids=["alone", "guard"])
@pytest.mark.parametrize("case", CASES)
@pytest.mark.linux("signals that freeze and interrupt a process")
def test_an_arm_stays_where_it_came_to_rest(case: str, guard: str | None) -> None:
    name, deed = CASES[case]
    with ready() as sim, program(sim, BODIES[name], guard) as child:
        assert child.stdout is not None
        assert child.stderr is not None
        lines = iter(child.stdout.readline, "")
        first = next(lines, "")
        assert first.startswith(("begun", "told ")), child.stderr.read()
        arm = Arm(sim)
        eventually(
            lambda: arm.seen(_SEEN) and (arm.moves() or child.poll() is not None),
            timeout=120.0,
        )
        if deed == "kill":
            child.kill()
        elif deed == "interrupt":
            child.send_signal(signal.SIGINT)
        elif deed == "freeze":
            child.send_signal(signal.SIGSTOP)  # none is sent to one that has ended
            eventually(lambda: not arm.moves(), timeout=120.0)
            thawed = len(arm.cycles)
            child.send_signal(signal.SIGCONT)
        said = [first]
        thread = threading.Thread(target=lambda: said.extend(lines))
        thread.start()
        eventually(lambda: child.poll() is not None, timeout=120.0)
        thread.join()
        left = len(arm.cycles)
        # a program that was killed is stopped by its guard, or by the missing heartbeat
        eventually(lambda: not arm.moves(), timeout=120.0)
        rested = len(arm.cycles)
        eventually(lambda: arm.seen(_WATCHED, rested), timeout=120.0)
        assert arm.moved_since(rested) < _STILL, f"it began to move by itself; {said}"
        if deed == "freeze":
            assert arm.moved_since(thawed) < _STILL, f"it moved after the thaw; {said}"
        if not deed:
            # stopped, cancelled, left: it stood by then
            assert arm.moved_since(left) < _STILL, f"it moved after its program had ended; {said}"
