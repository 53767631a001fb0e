"""Runs a program in a process of its own against the simulator, and judges what it did."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco._linked_process import LinkedProcess
from aioduco._spawn import Unstartable, is_frozen
from aioduco.errors import DucoError
from aioduco.kinematics import arm as arm_of
from aioduco.preflight.borders import address_of
from aioduco.preflight.findings import PreflightFinding, findings
from aioduco.preflight.margins import Margin, margins, near_singularities
from aioduco.sim.physics.world import World
from aioduco.sim.scene import mjcf_of, mounting_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.sim.scene import MountingLike, SceneLike

__all__ = ["PreflightError", "PreflightReport", "PreflightSettings", "preflight"]

#: time of a cycle of the simulation [s]: half as many as a controller has, for the sake of speed
CYCLE = 0.002
#: what the process imports for the simulator
_PACKAGES = ("OpenGL", "glfw", "mujoco")
#: time for a program that did not end to tell where it is [s]
_STACKS = 1.0


class PreflightError(DucoError):
    """The program could not be tried: nothing is known of it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PreflightSettings:
    """What a program is tried in.

    Attributes:
        model: the arm.
        scene, tool: what stands around it and what it carries: MJCF, a file of it, or things.
        mounting: "floor", "wall", "ceiling", or a pose [m, rad].
        pedestal: height of a column under the arm [m].
        joints: where it stands at first [rad]; None for the elbow bent, flange down.
        vendor: whether the vendor's modules are to be found by the program's imports.
        module: whether the program is the name of a module and no file.
        cwd: the folder that it runs in, and that its module lies in; None for the current one.
        allowed: names of bodies that the arm may touch.
        reachable: addresses as "host:port" that connections of the program's own may lead to;
            others are refused, since they could lead to an arm.
        patience: the program's time without a motion or a change after which it hangs [s].
        timeout: time of the wall after which it is ended [s].
        vary: what a seed varies: "start", "latency", "faults", "payload".
        seed: of the variation.
    """

    model: str = "gcr5_910"
    scene: SceneLike | None = None
    tool: SceneLike | None = None
    mounting: MountingLike = "floor"
    pedestal: float = 0.0
    joints: Sequence[float] | None = None
    vendor: bool = False
    module: bool = False
    cwd: str | None = None
    allowed: tuple[str, ...] = ()
    reachable: tuple[str, ...] = ()
    patience: float = 60.0
    timeout: float = 600.0
    vary: tuple[str, ...] = ()
    seed: int = 0

    def plain(self) -> dict[str, Any]:
        """The same as JSON takes it, with scenes as text."""
        mounting = self.mounting
        return {
            **{name: getattr(self, name) for name in self.__slots__},
            "scene": None if self.scene is None else mjcf_of(self.scene),
            "tool": None if self.tool is None else mjcf_of(self.tool, free=False),
            "mounting": mounting
            if isinstance(mounting, str)
            else [float(each) for each in mounting],
            "joints": None if self.joints is None else [float(each) for each in self.joints],
        }


@dataclass(frozen=True, slots=True)
class PreflightReport:
    """What a run of a program has shown.

    Attributes:
        program: its file or module.
        arguments: what it was given.
        findings: what would have gone wrong; empty if nothing.
        margins: how near the arm came to its limits.
        calls: each call that may change something, with its line and what became of it.
        contacts: each touch: the pair, from when to when.
        io: each change of an input or output of the cabinet.
        duration: the program's own time [s].
        took: time of the wall that the preflight needed [s].
        status: the program's exit status.
        variation: how this run differed, by its seed.
        samples: where the arm was: "time", "q", "qd", "positions".
        cell: arm, scene, tool and mounting of the run.
    """

    program: str
    arguments: tuple[str, ...]
    findings: tuple[PreflightFinding, ...]
    margins: tuple[Margin, ...]
    calls: tuple[dict[str, Any], ...]
    contacts: tuple[dict[str, Any], ...]
    io: tuple[dict[str, Any], ...]
    duration: float
    took: float
    status: int
    variation: dict[str, Any]
    samples: dict[str, Any] = field(repr=False)
    cell: dict[str, Any] = field(repr=False)

    @property
    def ok(self) -> bool:
        """Whether nothing was found."""
        return not self.findings

    @property
    def motions(self) -> tuple[dict[str, Any], ...]:
        """The calls that became tasks of the program, in the order in which they were made."""
        return tuple(call for call in self.calls if call["task"] is not None and call["where"])

    def as_json(self) -> dict[str, Any]:
        """The report without samples, by the schema in docs/preflight.md."""
        return {
            "schema": 1, "program": self.program, "arguments": list(self.arguments),
            "ok": self.ok, "findings": [one.as_json() for one in self.findings],
            "margins": [one.as_json() for one in self.margins], "calls": list(self.calls),
            "contacts": list(self.contacts), "io": list(self.io), "duration": self.duration,
            "took": self.took, "status": self.status, "variation": self.variation,
        }  # fmt: skip

    def world(self) -> World:
        """The cell of the run, for pictures and distances."""
        return _world(self.cell)


def refuse_frozen() -> None:
    """Refuse to try a program from a frozen one, whose executable would start itself.

    Raises:
        PreflightError: this program is frozen.
    """
    if is_frozen():
        raise PreflightError(
            "this is a frozen program, which has no interpreter to run another program: nothing "
            "was run. Use `aioduco preflight` of an installed aioduco"
        )


def preflight(
    program: str | os.PathLike[str],
    arguments: Sequence[str] = (),
    settings: PreflightSettings | None = None,
    *,
    quiet: bool = False,
) -> PreflightReport:
    """Run a program against the simulator, as it is, and say what would have gone wrong.

    Args:
        program: its file, or the name of a module.
        arguments: what it finds in `sys.argv` behind its name.
        settings: what it is tried in; None for an arm on an empty floor.
        quiet: whether what it prints is thrown away.

    Returns:
        The report.

    Raises:
        PreflightError: it could not be run, it was killed, or never used this package; or what
            asks for it is a frozen program, which has no interpreter to run another one.
    """
    refuse_frozen()
    settings = PreflightSettings() if settings is None else settings
    name = os.fspath(program)
    if not settings.module and not Path(settings.cwd or "", name).is_file():
        raise PreflightError(f"{name} is no file: nothing was run")
    for address in settings.reachable:
        try:
            address_of(address)
        except ValueError as error:
            raise PreflightError(f"{error}: nothing was run") from None
    begin = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="aioduco-preflight-") as folder:
        options = {
            **settings.plain(), "program": name, "arguments": list(arguments), "cycle": CYCLE,
            "folder": folder,
        }  # fmt: skip
        run, samples = _run(options, Path(folder), settings.timeout, quiet=quiet)
    took = time.monotonic() - begin
    if not run["touched"] and not run["notes"]:
        raise PreflightError(f"{name} ended without connecting to a robot by aioduco")
    cell = {**options, **(run["used"] or {})}
    near_by = near_singularities(run, samples, cell["model"])
    found = findings(run, allowed=settings.allowed, more=near_by)
    near = margins(run, samples, cell["model"], _world(cell))
    return PreflightReport(
        name, tuple(arguments), found, near, tuple(run["calls"]), tuple(run["contacts"]),
        tuple(run["io"]), run["duration"], took, run["status"], run["variation"], samples, cell,
    )  # fmt: skip


def _world(cell: dict[str, Any]) -> World:
    arm = arm_of(cell["model"])
    scene, tool, pedestal = cell.get("scene"), cell.get("tool"), cell.get("pedestal") or 0.0
    return World(
        arm,
        scene=None if scene is None else mjcf_of(scene),
        tool=None if tool is None else mjcf_of(tool, free=False),
        mounting=mounting_of(cell.get("mounting") or "floor", arm, pedestal),
        pedestal=pedestal > 0.0,
    )


def _run(
    options: dict[str, Any], folder: Path, timeout: float, *, quiet: bool
) -> tuple[dict[str, Any], dict[str, Any]]:
    try:
        linked = LinkedProcess(
            "aioduco.preflight.child", packages=_PACKAGES, runs_program=True, output=not quiet
        )
    except (Unstartable, OSError) as error:
        raise PreflightError(f"nothing was run: {error}") from error
    process = linked.popen
    try:
        with contextlib.suppress(ConnectionError):  # it has ended, as is found below
            linked.channel.send(options)
        process.wait(timeout)
    except subprocess.TimeoutExpired:
        if hasattr(signal, "SIGUSR1"):
            process.send_signal(signal.SIGUSR1)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(_STACKS)
        stacks = folder / "stacks"
        told = (stacks.is_file() and stacks.read_text(encoding="utf-8")) or "not known"
        raise PreflightError(
            f"the program had not ended after {timeout:g} s; its stacks were:\n{told}"
        ) from None
    finally:
        process.kill()
        linked.close()
    result = folder / "run.json"
    if not result.is_file():
        words = linked.last_words
        raise PreflightError(
            f"the program's process ended with status {process.returncode} before it was over"
            + (f": {words}" if words else "")
        )
    with np.load(folder / "samples.npz") as arrays:
        samples = {name: arrays[name] for name in arrays.files}
    return json.loads(result.read_text(encoding="utf-8")), samples
