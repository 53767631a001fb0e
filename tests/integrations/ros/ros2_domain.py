"""A domain of ROS 2: a driver and clients in processes of their own."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .programs import HERE, ROOT, START, Programs

__all__ = ["Domain"]

_PROFILE = ROOT / "integrations" / "ros2" / "aioduco_driver" / "config" / "fastdds.xml"
_PATIENT = (str(HERE.parents[1] / "patient.py"), str(HERE / "ros1_node.py"))
_LEASE = "<sec>0</sec><nanosec>600000000</nanosec>"


class Domain(Programs):
    """Processes that see one another, and nobody else; all of them end with the stack."""

    client_program = "ros2_client.py"

    def __init__(self, folder: Path, stack: contextlib.ExitStack, number: int) -> None:
        environment = {
            "ROS_DOMAIN_ID": str(number),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(folder),
        }
        super().__init__(folder, stack, environment)

    def start_node(
        self, sim: Any, *given: str, program: Sequence[str] = _PATIENT, **environment: str
    ) -> subprocess.Popen[str]:
        """Start the driver.

        Args:
            sim: its arm.
            given: parameters as `name:=value`, remappings as `-r from:=to`.
            program: what runs the command `ros2`: one that a busy machine may hold up.
            environment: more of it.
        """
        # the controller's queue holds a tenth of a second, and this machine may be busy
        given = ("through:=servoj", "goal_time_tolerance:=60.0", *given)
        words = [
            word for each in given for word in (each.split() if each[0] == "-" else ["-p", each])
        ]
        return self.start(
            *(sys.executable, *program),
            *("ros2", "--host", sim.host, "--port", str(sim.port), "--ros-args", *words),
            **environment,
        )

    def lease(self, lease: str = "") -> dict[str, str]:
        """Variables for a client: the driver's profile for Fast DDS, perhaps with another lease."""
        shipped = _PROFILE.read_text()
        assert _LEASE in shipped
        profile = self.folder / "fastdds.xml"
        profile.write_text(shipped.replace(_LEASE, lease or _LEASE))
        names = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
        return dict.fromkeys(names, str(profile))

    def ready(self, service: str = "bring_up", **environment: str) -> None:
        """Call a service of a driver that may still be starting, until the arm is ready."""
        reply = self.last("call", service, **environment)
        while "not configured" in reply["message"]:
            reply = self.last("call", service, **environment)
        assert reply["success"], (reply, self.errors)

    def go_to_start(self, **environment: str) -> None:
        given = json.dumps({"joints": START, "v": 2.0, "a": 10.0})
        reply = self.last("call", "movej", given, **environment)
        assert reply["success"], reply
