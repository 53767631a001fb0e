"""Preflight: what trying a program takes, of the program's own time and of a processor's.

    python benchmarks/preflight.py [--quick] [--save]

A program of motions, one after the other, which takes about a minute on an arm: it is tried by
`aioduco preflight` several times. "share" is what the preflight takes by the wall, of the program's
own time; asked for is at most a fifth for programs of more than 20 s. "processor share" is the same
of processor time, of all threads, the start of the process among it: on a machine that has other
things to do, it is the one that can be compared.
"""

from __future__ import annotations

import resource
import tempfile
from pathlib import Path

from _common import parser, percentile, save, show

from aioduco.testing.preflight import preflight

PROGRAM = """
import anyio
import aioduco

ONE, OTHER = aioduco.Joints.deg(60, 0, 90, 0, -90, 0), aioduco.Joints.deg(-60, 0, 90, 0, -90, 0)


async def main():
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        for _ in range({rounds}):
            await robot.motion.movej2(ONE, v=0.4, a=1.0)
            await robot.motion.movej2(OTHER, v=0.4, a=1.0)
            here = await robot.state.get_tcp_pose()
            await robot.motion.movel(here.shifted(z=-0.1), v=0.05, a=0.5)
            await robot.motion.movel(here, v=0.05, a=0.5)


anyio.run(main)
"""


def spent() -> float:
    """Processor time of this process and of those that it has started [s]."""
    uses = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(use.ru_utime + use.ru_stime for use in uses)


def main() -> None:
    options = parser(__doc__).parse_args()
    rounds, times = (2, 1) if options.quick else (4, 7)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "program.py"
        program.write_text(PROGRAM.format(rounds=rounds), encoding="utf-8")
        for _ in range(times):
            before = spent()
            report = preflight(program, (), None, quiet=True)
            assert report.ok, report.findings
            rows.append((report.duration, report.took, spent() - before))
    shares = {
        "by the wall": [took / duration for duration, took, _ in rows],
        "of a processor": [used / duration for duration, _, used in rows],
    }
    share = {
        name: {
            "p50_percent": round(100 * percentile(each, 50), 1),
            "max_percent": round(100 * max(each), 1),
        }
        for name, each in shares.items()
    }
    program_s = round(rows[0][0], 1)
    show(f"Trying a program of {program_s} s, {times} times: share of its time", share)
    save(options, "preflight", {"runs": times, "program_s": program_s, "share": share})


if __name__ == "__main__":
    main()
