"""A graph of ROS 1: a master, and programs under it in processes of their own."""

from __future__ import annotations

import contextlib
import json
import signal
import socket
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ports import free_port

from aioduco.testing import eventually

from .programs import HERE, ROOT, START, Programs, processor_time

__all__ = ["HERE", "ROOT", "START", "Graph", "processor_time"]

_MASTER = "import rosmaster.main as m; m.rosmaster_main()"


class Graph(Programs):
    """A master, and what is started with it; all of it ends with the stack."""

    client_program = "ros1_client.py"

    def __init__(self, folder: Path, stack: contextlib.ExitStack) -> None:
        self.port = free_port()
        environment = {
            "ROS_MASTER_URI": f"http://127.0.0.1:{self.port}",
            "ROS_IP": "127.0.0.1",
            "ROS_HOME": str(folder),
        }
        super().__init__(folder, stack, environment)
        self.master = self.start_master()

    def start_master(self) -> subprocess.Popen[str]:
        """Start the master, and wait until it listens."""
        process = self.start(sys.executable, "-c", _MASTER, "--core", "-p", str(self.port))

        def answers() -> bool:
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", self.port)):
                return True
            return False

        eventually(answers)
        return process

    def start_node(
        self, sim: Any, *given: str, program: Sequence[str] = ("-m", "aioduco.cli")
    ) -> subprocess.Popen[str]:
        """Start a driver."""
        address = ("--host", sim.host, "--port", str(sim.port))
        return self.start(sys.executable, *program, "ros1", *address, *given)

    def call(self, service: str, node: str = "/duco", **given: Any) -> dict[str, Any]:
        """Call a service of the driver, which has to succeed."""
        reply = self.last("call", service, json.dumps(given), NODE=node)
        assert reply["success"], reply
        return reply

    def go_to_start(self, node: str = "/duco") -> None:
        """Move the arm to START, by the driver's service."""
        self.call("movej", node, joints=START, v=2.0, a=10.0)

    def make_ready(self, node: str) -> None:
        """Lead the arm out of a stop, and to START."""
        replies = self.ask("ready", json.dumps(START), NODE=node)
        assert all(reply["success"] for reply in replies), replies

    def end_launch(self, process: subprocess.Popen[str], patience: float) -> int:
        """End roslaunch as Ctrl-C does, with all that it started."""
        process.send_signal(signal.SIGINT)
        return process.wait(patience)
