"""Each example of a stream runs to its end, and prints what it should and nothing else."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from client.test_examples import EXAMPLES, PATIENT, run
from moments import complaints

from aioduco.sim import Simulator
from aioduco.sim.process import SimulatorProcess
from aioduco.testing import eventually

NUMBERED = sorted(EXAMPLES.glob("1[0-57]_*.py"))
CLOSED = r"<StreamStatistics ENDED \(CLOSED\): \d+ sent"

#: what each says at its end
SAYS = {
    "10_sine.py": CLOSED,
    "12_policy.py": CLOSED,
    "15_policy_sync.py": CLOSED,
    "17_action_chunks.py": rf"chunks, \d+ of their actions came too late\n{CLOSED}",
    "13_play_npy.py": r"200 points in [\d.]+ s\nlargest distance from the path: 0\.0",
    "14_realtime_velocity.py": rf"moved by -0\.\d+ -0\.\d+ \+0\.\d+ .*rad\n{CLOSED}",
}


@pytest.fixture(scope="module")
def sim() -> Iterator[SimulatorProcess]:
    with Simulator.spawn() as sim:
        yield sim


@pytest.mark.slow
@pytest.mark.parametrize("name", SAYS)
def test_on_a_given_address(sim: SimulatorProcess, tmp_path: Path, name: str) -> None:
    given = [sim.host, "--port", str(sim.port), "--seconds", "0.4"]
    if name == "13_play_npy.py":
        file = tmp_path / "path.npy"
        times = np.linspace(2.0, 2.6, 200)
        rows = np.tile([0.0, 0.0, 1.57, 0.0, -1.57, 0.0], (200, 1))
        rows[:, 5] = 0.1 * np.sin(np.linspace(0, np.pi, 200)) ** 2
        np.save(file, np.column_stack([times, rows]))
        given.insert(0, str(file))
    assert re.search(SAYS[name], run(str(EXAMPLES / name), *given))


class Standing:
    """Whether the arm has not moved for a while of its own time."""

    def __init__(self, sim: Simulator) -> None:
        self._sim = sim
        self._since, self._joints = sim.time, sim.joints.array

    def __call__(self) -> bool:
        time, joints = self._sim.time, self._sim.joints.array
        if np.abs(joints - self._joints).max() > 1e-4:
            self._since, self._joints = time, joints
        return time - self._since > 0.2


@pytest.mark.slow
def test_teleoperation_by_keys_from_a_pipe() -> None:
    with Simulator() as sim:
        program = subprocess.Popen(
            [
                *(sys.executable, "-W", "error", PATIENT, str(EXAMPLES / "11_teleoperation.py")),
                *(sim.host, "--port", str(sim.port)),
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert program.stdin is not None
        assert program.stdout is not None
        assert "q ends" in program.stdout.readline(), program.communicate()
        keys, before = program.stdin, sim.arm.fkine(sim.joints)[:3, 3]

        def moved_while_the_key_is_held() -> bool:
            # once is not enough: a busy machine may take longer than a key that came once counts
            keys.write("r")
            keys.flush()
            return bool(np.linalg.norm(sim.arm.fkine(sim.joints)[:3, 3] - before) > 1e-3)

        eventually(moved_while_the_key_is_held, 30.0)
        # The flange looks down, and the key says up.
        way = sim.arm.fkine(sim.joints)[:3, 3] - before
        np.testing.assert_allclose(way / np.linalg.norm(way), [0.0, 0.0, 1.0], atol=0.1)
        # The key is let go: it stands again.
        eventually(Standing(sim))
        said, errors = program.communicate("q", timeout=20)
        assert (complaints(errors), program.returncode) == ("", 0)
        assert "the tool stands at Pose(" in said
        assert not sim.view.moving


def test_each_is_short_opens_with_its_goal_and_is_run_here() -> None:
    assert {path.name for path in NUMBERED} == {*SAYS, "11_teleoperation.py"}
    for path in NUMBERED:
        lines = path.read_text(encoding="utf-8").splitlines()
        assert f"    python {path.name}  " in "\n".join(lines[:6]), path
