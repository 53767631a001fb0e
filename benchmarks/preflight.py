"""Preflight: what trying a program takes, as a share of the program's own time.

    python benchmarks/preflight.py [--quick] [--save]

A program of motions, one after the other, which takes about a minute on an arm: it is tried by
`aioduco preflight` several times. Asked for is at most a fifth for programs of more than 20 s.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from _common import parser, percentile, report

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


def main() -> None:
    options = parser(__doc__).parse_args()
    rounds, times = (2, 1) if options.quick else (4, 7)
    shares = []
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "program.py"
        program.write_text(PROGRAM.format(rounds=rounds), encoding="utf-8")
        for _ in range(times):
            tried = preflight(program, (), None, quiet=True)
            assert tried.ok, tried.findings
            shares.append(100 * tried.took / tried.duration)
    median, most = round(percentile(shares, 50), 1), round(max(shares), 1)
    results = {
        "runs": times,
        "program_s": round(tried.duration, 1),
        "share": {"by the wall": {"p50_percent": median, "max_percent": most}},
    }
    report(options, "preflight", results)


if __name__ == "__main__":
    main()
