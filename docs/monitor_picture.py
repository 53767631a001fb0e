"""Write `docs/images/monitor.svg`: what `aioduco monitor` shows of a simulated arm that moves.

python docs/monitor_picture.py
"""

from __future__ import annotations

import io
import os
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio
from rich.console import Console

import aioduco
from aioduco.cli.monitor.observer import MonitorClient
from aioduco.cli.monitor.screen import screen
from aioduco.sim import Simulator

if TYPE_CHECKING:
    from aioduco.cli.monitor.view_state import MonitorState

PICTURE = Path(__file__).resolve().parent / "images" / "monitor.svg"
WIDTH, HEIGHT = 112, 25
#: rich's template asks for fonts from elsewhere; whoever looks has one of a fixed width
FONTS = re.compile(r"@font-face \{.*?\}\s*", re.DOTALL)


async def watched(sim: Simulator) -> MonitorState:
    """What a monitor knows of an arm in the middle of a motion."""
    states: list[MonitorState] = []
    keys, keyboard = os.pipe()
    # patient: a busy machine is to give the same picture
    patience: dict[str, Any] = {"call_timeout": 60.0, "lag_limit": None}
    program = aioduco.connect(sim.host, sim.port, heartbeat=60.0, **patience)
    onlooker = aioduco.connect(sim.host, sim.port, heartbeat=None, state_rate=10.0, **patience)
    onlooker.feed.forces = True
    async with anyio.create_task_group() as watching:
        watching.start_soon(
            MonitorClient(onlooker, "left (192.168.1.10:7003)", keys, states.append).watch
        )
        async with program as robot:
            await robot.wait_for(lambda _: bool(states) and states[-1].sample is not None)
            await robot.bring_up()
            await robot.io.set_standard_digital_out(3, True)
            sim.set_digital_input(5, True)
            task = await robot.motion.movej2(
                aioduco.Joints.deg(70, -35, 120, 10, -90, 300), v=0.5, a=1.0
            ).start()
            await robot.wait_for(lambda sample: sample.status.joints.j1 > 0.3)
            os.write(keyboard, b"p")
            await robot.wait_for(lambda _: states[-1].notice is not None)
            os.write(keyboard, b"r")
            await robot.wait_for(lambda sample: sample.status.joints.j1 > 0.7)
            now = states[-1]
            await task
        os.write(keyboard, b"q")
    os.close(keys)
    os.close(keyboard)
    return now


def main() -> int:
    """Write the picture."""
    with Simulator(joints=(0.0, -0.3, 1.8, 0.0, -1.57, 0.0)) as sim:
        state = anyio.run(watched, sim)
    console = Console(file=io.StringIO(), width=WIDTH, height=HEIGHT, record=True)
    console.print(screen(replace(state, rate=10.0), WIDTH, HEIGHT))
    text = console.export_svg(title="aioduco monitor left", unique_id="monitor")
    PICTURE.write_text(FONTS.sub("", text), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
