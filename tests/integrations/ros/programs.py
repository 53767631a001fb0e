"""Programs of a ROS graph: each in a process that ends with the test."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from aioduco.sim import Simulator
from aioduco.testing import eventually

__all__ = ["HERE", "ROOT", "START", "WAVE", "Programs", "processor_time", "ur_services"]

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
START = [0.0, 0.3, 1.2, 0.1, -1.5, 0.0]
#: a program of the controller, which takes minutes
WAVE = {"wave": [["movej2", [turn, *START[1:]], 0.3, 5.0] for turn in (1.0, 0.0) * 30]}


def processor_time(pid: int) -> float:
    """Seconds of processor time that a process has used."""
    numbers = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(numbers[11]) + int(numbers[12])) / os.sysconf("SC_CLK_TCK")


class Programs:
    """Starts programs that all end with the stack."""

    client_program: str

    def __init__(
        self, folder: Path, stack: contextlib.ExitStack, environment: dict[str, str]
    ) -> None:
        self._stack = stack
        self.folder = folder
        self.environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join(
                [str(ROOT), str(ROOT / "tests"), *filter(None, sys.path)]
            ),
            **environment,
        }

    @property
    def errors(self) -> str:
        """The end of what the programs wrote to their standard errors."""
        return (self.folder / "errors").read_text()[-4000:]

    def start(self, *command: str, **environment: str) -> subprocess.Popen[str]:
        """Start a program, whose output is kept from this one's but for what it answers."""
        with (self.folder / "errors").open("a") as errors:
            process = subprocess.Popen(
                command,
                env={**self.environment, **environment},
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
            )
        self._stack.callback(_end, process)
        return process

    def client(self, *asked: str, **environment: str) -> subprocess.Popen[str]:
        """Start a client."""
        return self.start(sys.executable, str(HERE / self.client_program), *asked, **environment)

    def moving_client(self, *goal: str, **environment: str) -> subprocess.Popen[str]:
        """A client whose goal is being carried out."""
        client = self.client("goal", *goal, **environment)
        assert client.stdout is not None
        first = client.stdout.readline()
        assert first == '{"moving": true}\n', first + self.errors
        return client

    def ask(self, *asked: str, **environment: str) -> list[dict[str, Any]]:
        """What a client answers, to its end."""
        process = self.client(*asked, **environment)
        out, _ = process.communicate(timeout=400)
        assert process.returncode == 0, self.errors
        return [json.loads(line) for line in out.splitlines()]

    def last(self, *asked: str, **environment: str) -> dict[str, Any]:
        """Its last answer."""
        return self.ask(*asked, **environment)[-1]


def _end(process: subprocess.Popen[str]) -> None:
    if process.poll() is None:
        process.kill()
    process.wait()
    assert process.stdout is not None
    process.stdout.close()


def ur_services(
    ask: Callable[[list[tuple[str, dict[str, Any]]]], list[dict[str, Any]]], sim: Simulator
) -> None:
    """Call what a user of the Universal Robots driver knows, on an arm that stands enabled."""

    def call(*services: str | tuple[str, dict[str, Any]]) -> list[str]:
        asked = [(each, {}) if isinstance(each, str) else each for each in services]
        replies = ask(asked)
        assert all(reply["success"] for reply in replies), list(zip(asked, replies, strict=True))
        return [reply["message"] for reply in replies]

    pressing = {
        "selection": [False, False, True, False, False, False],
        "wrench": [0.0, 0.0, 5.0, 0.0, 0.0, 0.0],
    }
    *_, robot, safety = call(
        "dashboard_client/power_off",
        "dashboard_client/power_on",
        "dashboard_client/brake_release",
        "dashboard_client/unlock_protective_stop",
        ("io_and_status_controller/set_io", {"fun": 1, "pin": 3, "state": 1.0}),
        ("set_analog_output", {"number": 1, "value": 2.5, "current": False}),
        ("io_and_status_controller/set_payload", {"mass": 0.5, "centre": [0.0, 0.0, 0.1]}),
        ("io_and_status_controller/set_speed_slider", {"speed_slider_fraction": 1.0}),
        "io_and_status_controller/zero_ftsensor",
        ("force_mode_controller/start_force_mode", pressing),
        "force_mode_controller/stop_force_mode",
        "dashboard_client/get_robot_mode",
        "dashboard_client/get_safety_mode",
    )
    assert (robot, safety) == ("ENABLE", "RUN")
    assert sim.get_digital_output(4)
    load = ("dashboard_client/load_program", {"text": "wave"})
    _, name, _ = call(load, "dashboard_client/get_loaded_program", "dashboard_client/play")
    assert name == "wave"
    eventually(lambda: sim.moving)
    call("dashboard_client/pause")
    assert not sim.moving
    call("dashboard_client/play")
    eventually(lambda: sim.moving)
    call("dashboard_client/stop")
    assert not sim.moving
    texts = ("dashboard_client/add_to_log", "dashboard_client/popup")
    call(*((each, {"text": "change the part"}) for each in texts), "stop")
