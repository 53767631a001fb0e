"""Guide the arm by hand, and have it do that again: the same way, then from corner to corner.

    python teach_and_replay.py                  on a simulated arm, pushed by a simulated hand
    python teach_and_replay.py 192.168.1.10     on a real one: set its tool and its weight before

While the arm gives way, all that it does is recorded, and a waypoint is kept whenever you press
Enter. Then it is led along the recorded way at half the speed, and through the waypoints, which are
a TOML file that you may edit. Nothing here sees what stands in the way.
"""

from __future__ import annotations

import argparse
import tempfile
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import aioduco.sync
from aioduco.recording import read
from aioduco.recording.playback import RecordedPath, WaypointFile

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.sim import Simulator

    #: returns when the arm is at the next place that is to be kept; False: there is none
    Hand = Callable[[int], bool]

PUSHES = ((0.0, 30.0, 0.0), (0.0, 0.0, 25.0), (0.0, -30.0, 0.0))  # of the simulated hand [N]


def person(number: int) -> bool:
    """Wait until the person at the arm presses Enter."""
    return input(f"guide it to place {number}, then Enter; q ends: ") != "q"


def simulated_hand(sim: Simulator, number: int) -> bool:
    """Push the simulated arm until a joint has turned by 5 degrees, then let go for a second."""
    if number > len(PUSHES):
        return False
    begin = sim.joints
    sim.push([*PUSHES[number - 1], 0.0, 0.0, 0.0])
    sim.wait_until(lambda: sim.joints.distance(begin) > aioduco.deg(5), timeout=60)
    sim.push([0.0] * 6)
    until = sim.clock.now() + 1.0
    sim.wait_until(lambda: sim.clock.now() > until, timeout=60)
    return True


def teach(robot: aioduco.sync.Robot, folder: Path, hand: Hand) -> tuple[Path, WaypointFile]:
    """Record what the hand does; the recording, and the waypoints that were kept."""
    kept = WaypointFile.new(title="teach_and_replay")
    with robot.record(folder / "taught.mcap") as recording, robot.motion.teach_mode.start():
        while hand(len(kept.waypoints) + 1):
            joints = robot.state.get_actual_joints_position()
            kept.add(f"p{len(kept.waypoints) + 1}", joints)
            kept.save(folder / "taught.toml")
            print("kept:", ", ".join(f"{angle:.1f}°" for angle in joints.degrees))
    return recording.path, kept


def main(host: str, port: int, folder: Path, sim: Simulator | None = None) -> None:
    hand = person if sim is None else partial(simulated_hand, sim)
    clock = None if sim is None else sim.clock
    with aioduco.sync.connect(host, port, state_rate=125, clock=clock) as robot:
        robot.bring_up()
        recording, kept = teach(robot, folder, hand)

        try:
            path = RecordedPath.of(read(recording), of="states", speed=0.5)
            result = aioduco.sync.play(robot, path, approach=0.3)
        except (aioduco.RecordingError, aioduco.PathRefused) as unfit:
            # It has gaps, or leaps, of a computer that was too busy meanwhile; nothing was sent.
            print("the way again: no,", unfit)
        else:
            off = max(result.path_error)
            print(f"the way again: {result.duration:.1f} s, {off:.3f} rad off at most")

        aioduco.sync.run_waypoints(robot, kept, speed=0.5)
        print(f"the places again: {len(kept.waypoints)} of {len(kept.waypoints)}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        main(given.host, given.port, Path.cwd())
    else:
        from aioduco.sim import Simulator

        with Simulator() as arm, tempfile.TemporaryDirectory() as name:
            main(arm.host, arm.port, Path(name), arm)
