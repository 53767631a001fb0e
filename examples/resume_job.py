"""A job that goes on where it was: after a protective stop, and after the program was ended.

    python resume_job.py JOB.json                    on a simulated arm, which collides once
    python resume_job.py JOB.json 192.168.1.10       on a real one

What is done is written to the file after each step. A fault is recovered from once a person says
so, and the step that it interrupted is done again. A real arm does not move again by itself:
without a terminal to ask in, the fault ends the program. Start the program again after it was
ended, and it goes on with the next step; without the file it begins anew.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import aioduco.sync
from aioduco import Joints

STEPS = [Joints.deg(angle, -10, 100, 0, -90, 0) for angle in (-40, -20, 0, 20, 40)]
FAULTS = (aioduco.TaskFailed, aioduco.TaskInterrupted, aioduco.TaskStopped)


def done(file: Path) -> int:
    """How many steps are done."""
    return int(json.loads(file.read_text("utf-8"))["done"]) if file.exists() else 0


def note(file: Path, number: int) -> None:
    """Write it down whole or not at all: the program may be killed meanwhile."""
    fresh = file.with_suffix(".new")
    fresh.write_text(json.dumps({"done": number}), encoding="utf-8")
    fresh.replace(file)


def cleared() -> bool:
    """Wait until a person has looked at the arm; whether one says that it may go on."""
    if sys.stdin.isatty():
        input("look at the arm, then press Enter to go on: ")
    return sys.stdin.isatty()


def main(file: Path, host: str, port: int, *, simulated: bool = False) -> None:
    with aioduco.sync.connect(host, port) as robot:
        robot.bring_up()
        for number in range(done(file), len(STEPS)):
            while True:
                try:
                    robot.motion.movej2(STEPS[number], v=0.6, a=1.5)
                    break
                except FAULTS as fault:
                    print(f"step {number + 1}: {type(fault).__name__}")
                    if not cleared() and not simulated:
                        raise
                    robot.recover()
            note(file, number + 1)
            print(f"step {number + 1}: done")
        print("the job is done")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("job", nargs="?", type=Path, default="job.json")
    parser.add_argument("host", nargs="?")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        main(given.job, given.host, given.port)
    else:
        import threading

        from aioduco.sim import Simulator

        with Simulator() as sim:

            def push() -> None:
                for passed in (lambda: sim.joints[0] < -0.6, lambda: sim.joints[0] > -0.2):
                    sim.wait_until(passed, 60.0)
                sim.collide(joint=1)

            pusher = threading.Thread(target=push, name="somebody in the way")
            pusher.start()
            main(given.job, sim.host, sim.port, simulated=True)
            pusher.join()
