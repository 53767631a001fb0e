"""Write `docs/images/rviz.png`: RViz of ROS 1, as the exported launch file starts it.

    .ci/ros1 rviz

A screen of its own, roslaunch with a simulated arm, driver, robot_state_publisher and RViz, and a
goal by the action. It fails if the picture does not change as the arm moves, or if RViz does not
draw as much of the arm after as before. It needs Debian's packages of ROS 1, RViz and Xvfb.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from PIL import Image

from aioduco.testing import eventually

if TYPE_CHECKING:
    from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from integrations.ros.ros1_graph import Graph  # noqa: E402 - the tests are no package
from ports import free_port  # noqa: E402

PICTURE = Path(__file__).resolve().parent / "images" / "rviz.png"
SIZE = (1200, 800)
#: s within which whatever is waited for has come
PATIENT = 120.0
#: of the arm's dark caps, of which at least so many points are seen
FEWEST = 800


def screen(folder: Path) -> NDArray[np.uint8]:
    """What the screen shows. Shape (height, width, 3)."""
    path = folder / "Xvfb_screen0"
    head = np.fromfile(path, ">u4", 25)
    start, width, height, bits, line, colours = (int(head[i]) for i in (0, 4, 5, 11, 12, 19))
    data = np.fromfile(path, np.uint8)[start + 12 * colours :][: line * height]
    points = data.reshape(height, line)[:, : width * bits // 8].reshape(height, width, bits // 8)
    return np.ascontiguousarray(points[:, :, 2::-1])


def caps(shown: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Where the caps of the arm's joints are, in the picture of the scene: dark and bluish."""
    r, g, b = (shown[:, :, i].astype(int) for i in range(3))
    found: NDArray[np.bool_] = (b > 1.15 * g) & (b > 1.4 * r) & (b > 30)
    found[:, : SIZE[0] // 3] = False
    found[:60] = False
    return found


def start_screen(stack: contextlib.ExitStack, folder: Path) -> str:
    """Start a screen that lies in a file; returns its name."""
    read, write = os.pipe()
    process = stack.enter_context(
        subprocess.Popen(
            [
                *("Xvfb", "-displayfd", str(write), "-screen", "0", f"{SIZE[0]}x{SIZE[1]}x24"),
                *("-fbdir", str(folder), "-nolisten", "tcp"),
            ],
            pass_fds=[write],
            stderr=subprocess.DEVNULL,
        )
    )
    stack.callback(process.terminate)
    os.close(write)
    with os.fdopen(read) as told:
        return f":{told.readline().strip()}"


def main() -> None:
    """Start all, move the arm, and keep the picture."""
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as stack:
        folder = Path(name)
        subprocess.run(
            [sys.executable, "-m", "aioduco.cli", "export", "ros1", "-o", str(folder)],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        display = start_screen(stack, folder)
        graph: Any = Graph(folder, stack)
        environment = {
            "DISPLAY": display,
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "QT_LOGGING_RULES": "*=false",
            "ROS_PACKAGE_PATH": os.pathsep.join([str(folder), "/usr/share"]),
        }
        launch = graph.start(
            *("roslaunch", "gcr5_910_bringup", "arm.launch", "through:=servoj"),
            f"simulator_port:={free_port()}",
            **environment,
        )
        stack.callback(graph.end_launch, launch, PATIENT)
        graph.call("bring_up")
        graph.go_to_start()
        eventually(lambda: caps(screen(folder)).sum() > FEWEST, PATIENT, what="RViz draws the arm")
        before = caps(screen(folder))
        found = graph.last("goal", "200", "4.0", "0.8")
        assert (found["state"], found["code"]) == (3, 0), found
        eventually(lambda: _stands(folder), PATIENT, what="RViz shows a standing arm")
        shown = screen(folder)
        after = caps(shown)
        changed = int((before ^ after).sum())
        assert changed > FEWEST, f"{changed} points of the arm changed as it moved by 0.8 rad"
        assert after.sum() > FEWEST, after.sum()
        Image.fromarray(shown).quantize(64).save(PICTURE, optimize=True)
    said = f"{PICTURE.relative_to(ROOT)}; {changed} points changed as the arm moved"
    sys.stdout.write(f"written: {said}\n")


def _stands(folder: Path) -> bool:
    one = caps(screen(folder))
    time.sleep(0.5)
    return not (one ^ caps(screen(folder))).any()


if __name__ == "__main__":
    main()
