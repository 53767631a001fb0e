"""Drive the tool by the keyboard or a gamepad, at a speed, for as long as a key is held.

    python 11_teleoperation.py                                      on a simulated arm
    python 11_teleoperation.py 192.168.1.10                         on a real one: keep clear of it
    python 11_teleoperation.py 192.168.1.10 --pad /dev/input/js0    by a gamepad

Keys: w s forward and back, a d left and right, r f up and down; any other stands; q ends. Sticks of
a gamepad: left x and y, right y up and down; its first button ends. Directions are those of the
base, as somebody sees them who stands behind the arm, however the tool is turned: its x leads
forward, its z up.

When nothing comes from the keyboard any more, the tool slows down and stands. When this program
dies, so it does; and if the network is lost, the controller ends the motion 0.2 s later by itself.
"""

from __future__ import annotations

import argparse
import os
import struct
import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING

import anyio

import aioduco

if TYPE_CHECKING:
    from collections.abc import Iterator

SPEED = 0.05  # m/s
HELD = 0.4  # s: a terminal repeats a held key sooner than this
KEYS = {
    "w": (1, 0, 0), "s": (-1, 0, 0), "a": (0, 1, 0), "d": (0, -1, 0), "r": (0, 0, 1),
    "f": (0, 0, -1),
}  # fmt: skip


class Keyboard:
    """The direction of the key that was pressed last; None to end."""

    direction: tuple[float, float, float] | None = (0, 0, 0)

    async def read(self) -> None:
        while self.direction is not None:
            with anyio.move_on_after(HELD) as silence:
                await anyio.wait_readable(sys.stdin)
                key = os.read(sys.stdin.fileno(), 1).decode(errors="replace")
                self.direction = None if key in ("q", "") else KEYS.get(key, (0, 0, 0))
            if silence.cancelled_caught:
                self.direction = (0, 0, 0)


class Pad:
    """The direction of a gamepad's sticks; None to end. Linux tells it without a library."""

    direction: tuple[float, float, float] | None = (0, 0, 0)
    _AXES = {1: (0, -1), 0: (1, -1), 4: (2, -1)}  # noqa: RUF012  # number: axis of the base, sign

    def __init__(self, path: str) -> None:
        self._file = os.open(path, os.O_RDONLY)

    async def read(self) -> None:
        stick = [0.0, 0.0, 0.0]
        while self.direction is not None:
            await anyio.wait_readable(self._file)
            _, value, kind, number = struct.unpack("IhBB", os.read(self._file, 8))
            if kind & 0x7F == 2 and number in self._AXES:
                axis, sign = self._AXES[number]
                stick[axis] = sign * value / 32767 if abs(value) > 3000 else 0.0
                self.direction = (stick[0], stick[1], stick[2])
            elif kind & 0x7F == 1 and number == 0 and value:
                self.direction = None


@contextmanager
def single_keys() -> Iterator[None]:
    """Have the terminal pass on each key at once, if the input is a terminal."""
    if not sys.stdin.isatty():
        yield
        return
    import termios  # noqa: PLC0415
    import tty  # noqa: PLC0415

    before = termios.tcgetattr(sys.stdin)
    tty.setcbreak(sys.stdin)
    try:
        yield
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)


async def main(host: str, port: int, pad: str | None) -> None:
    source = Pad(pad) if pad else Keyboard()
    async with aioduco.connect(host, port) as robot, anyio.create_task_group() as tasks:
        await robot.bring_up()
        async with robot.speed.linear(a=0.5, v=SPEED, frame="base", dead_man=0.2) as stream:
            print("w s a d r f move the tool; q ends", flush=True)
            tasks.start_soon(source.read)
            async for _ in stream.ticks():
                if source.direction is None:
                    break
                x, y, z = source.direction
                await stream.send([SPEED * x, SPEED * y, SPEED * z, 0, 0, 0])
        print("the tool stands at", await robot.state.get_tcp_pose())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("--port", type=int, default=7003)
    parser.add_argument("--pad", help="a gamepad, such as /dev/input/js0")
    given = parser.parse_args()
    with single_keys():
        if given.host:
            anyio.run(main, given.host, given.port, given.pad)
        else:
            from aioduco.sim import Simulator

            with Simulator.spawn() as sim:
                anyio.run(main, sim.host, sim.port, given.pad)
