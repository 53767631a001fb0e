"""Run a program in a separate process against the simulator, and report its problems."""

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

from aioduco._process.linked_process import LinkedProcess
from aioduco._process.spawn import MUJOCO_PACKAGES, Unstartable, is_frozen
from aioduco.errors import DucoError, ParameterError
from aioduco.kinematics import arm as arm_of
from aioduco.models.gripper_models import gripper_model
from aioduco.models.ranges import FINITE, FLAG, FOLDER, JOINTS, TEXTS, TIMEOUT
from aioduco.models.rules import Integer, stored
from aioduco.sim.physics.world import World
from aioduco.sim.scene import MountingLike, SceneLike, mjcf_of, mounting_of
from aioduco.testing.preflight.borders import address_of
from aioduco.testing.preflight.findings import PreflightFinding, findings
from aioduco.testing.preflight.margins import Margin, margins, near_singularities
from aioduco.testing.preflight.variation import Variation

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.pose import JointsLike


_SEED = Integer(-(2**63), 2**63 - 1, source="this package")
#: time of a cycle of the simulation [s]: half the rate of a controller, for speed
CYCLE = 0.002
#: time within which a program that did not end must write its stacks [s]
_STACKS = 1.0


class PreflightError(DucoError):
    """The program could not be tried; there is no result."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PreflightSettings:
    """Settings of a preflight: the cell, and the run of the program.

    Attributes:
        model: the arm.
        scene, tool: surroundings and tool of the arm: MJCF, an MJCF file, or things.
        gripper: name of a gripper at the flange, in place of `tool`, as of `Simulator`.
        mounting: "floor", "wall", "ceiling", or a pose [m, rad].
        pedestal: height of a column under the arm [m].
        joints: start joints [rad]; None for a bent elbow with the flange down.
        vendor: whether imports of the vendor's modules get this package's instead.
        module: whether the program is the name of a module instead of a file.
        cwd: working directory, which also contains the module; None for the current one.
        allowed: names of bodies that the arm may touch.
        reachable: addresses as "host:port" to which the program's own connections may lead; others
            are refused, since they could lead to an arm.
        patience: the program's time without a motion or a change after which it counts as hung [s].
        timeout: time of the wall clock after which the program is ended [s].
        vary: quantities that a seed varies: "start", "latency", "faults", "payload",
            "parts".
        seed: seed of the variation.

    Raises:
        ParameterError: a setting is of a wrong type, or out of range.
    """

    model: str = "gcr5_910"
    scene: SceneLike | None = None
    tool: SceneLike | None = None
    gripper: str | None = None
    mounting: MountingLike = "floor"
    pedestal: float = 0.0
    joints: JointsLike | None = None
    vendor: bool = False
    module: bool = False
    cwd: str | os.PathLike[str] | None = None
    allowed: tuple[str, ...] = ()
    reachable: tuple[str, ...] = ()
    patience: float = 60.0
    timeout: float = 600.0
    vary: tuple[str, ...] = ()
    seed: int = 0

    def __post_init__(self) -> None:
        stored(
            self, patience=TIMEOUT, timeout=TIMEOUT, pedestal=FINITE, seed=_SEED, vendor=FLAG,
            module=FLAG, allowed=TEXTS, reachable=TEXTS, vary=TEXTS,
        )  # fmt: skip
        if self.gripper is not None and self.tool is not None:
            raise ParameterError("gripper", self.gripper, "None with a tool, whose place it takes")
        if self.joints is not None:
            object.__setattr__(self, "joints", tuple(JOINTS("joints", self.joints)))
        if self.cwd is not None:
            object.__setattr__(self, "cwd", str(FOLDER("cwd", self.cwd)))

    def plain(self) -> dict[str, Any]:
        """The settings as values for JSON, with scenes as text."""
        mounting = self.mounting
        return {
            **{name: getattr(self, name) for name in self.__slots__},
            "scene": None if self.scene is None else mjcf_of(self.scene),
            "tool": None if self.tool is None else mjcf_of(self.tool, free=False),
            "mounting": mounting
            if isinstance(mounting, str)
            else [float(each) for each in mounting],
            "joints": None if self.joints is None else [*self.joints],
        }


@dataclass(frozen=True, slots=True)
class PreflightReport:
    """Result of a run of a program.

    Attributes:
        program: file or module of the program.
        arguments: arguments of the program.
        findings: the problems; empty if there are none.
        margins: smallest distances of the arm from its limits.
        calls: each call that may change something, with its line and its result.
        contacts: each contact: the pair, its begin and end.
        io: each change of an input or output of the cabinet.
        duration: the program's own time [s].
        took: wall-clock time that the preflight needed [s].
        status: the program's exit status.
        variation: variation of this run, with its seed.
        samples: positions of the arm: "time", "q", "qd", "positions".
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
    """Refuse to try a program from a frozen program, whose executable would start itself.

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
    """Run an unchanged program against the simulator, and report its problems.

    Args:
        program: file of the program, or the name of a module.
        arguments: arguments of the program, in `sys.argv` after its name.
        settings: cell and settings; None for an arm on an empty floor.
        quiet: whether to discard the program's output.

    Returns:
        The report.

    Raises:
        ParameterError: a setting is out of range; nothing was run.
        SceneError: the scene or the tool is no MJCF; nothing was run.
        PreflightError: the program could not be run, was killed, or never used this package; or the
            caller is a frozen program, which has no interpreter to run another program.
    """
    refuse_frozen()
    arguments = TEXTS("arguments", arguments)
    settings = PreflightSettings() if settings is None else settings
    name = os.fspath(program)
    if not settings.module and not Path(settings.cwd or "", name).is_file():
        raise PreflightError(f"{name} is no file: nothing was run")
    for address in settings.reachable:
        try:
            address_of(address)
        except ValueError as error:
            raise PreflightError(f"{error}, and no program was run") from None
    Variation.of(settings.vary, settings.seed)
    _world(settings.plain())
    begin = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="aioduco-preflight-") as folder:
        options = {
            **settings.plain(), "program": name, "arguments": [*arguments], "cycle": CYCLE,
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
        name, arguments, found, near, tuple(run["calls"]), tuple(run["contacts"]),
        tuple(run["io"]), run["duration"], took, run["status"], run["variation"], samples, cell,
    )  # fmt: skip


def _world(cell: dict[str, Any]) -> World:
    arm = arm_of(cell["model"])
    scene, tool, pedestal = cell.get("scene"), cell.get("tool"), cell.get("pedestal") or 0.0
    gripper = cell.get("gripper")
    return World(
        arm,
        scene=None if scene is None else mjcf_of(scene),
        tool=None if tool is None else mjcf_of(tool, free=False),
        gripper=None if gripper is None else gripper_model(gripper),
        mounting=mounting_of(cell.get("mounting") or "floor", arm, pedestal),
        pedestal=pedestal > 0.0,
    )


def _run(
    options: dict[str, Any], folder: Path, timeout: float, *, quiet: bool
) -> tuple[dict[str, Any], dict[str, Any]]:
    try:
        linked = LinkedProcess(
            "aioduco.testing.preflight.child",
            packages=MUJOCO_PACKAGES,
            runs_program=True,
            output=not quiet,
        )
    except (Unstartable, OSError) as error:
        raise PreflightError(f"nothing was run: {error}") from error
    process = linked.popen
    try:
        with contextlib.suppress(ConnectionError):  # the process has ended; that is handled below
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
        words = linked.stderr_tail
        raise PreflightError(
            f"the program's process ended with status {process.returncode} before it was over"
            + (f": {words}" if words else "")
        )
    with np.load(folder / "samples.npz") as arrays:
        samples = {name: arrays[name] for name in arrays.files}
    return json.loads(result.read_text(encoding="utf-8")), samples
