"""The running parts of a simulator: built when it starts, taken down when it closes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.kinematics.mounting import gravity
from aioduco.sim import trial
from aioduco.sim.cabinet.grippers import ValveGripper, slave_of
from aioduco.sim.controller.monitoring import CollisionDetector
from aioduco.sim.controller.state_machine import Controller
from aioduco.sim.force.control import ForceControl
from aioduco.sim.force.sensor import SensorNoise
from aioduco.sim.handlers import Handlers
from aioduco.sim.handlers.base import HandlerContext
from aioduco.sim.handlers.generations import NewerHandlers, OlderHandlers, in_single_precision
from aioduco.sim.physics.drives import TrailingDrives
from aioduco.sim.physics.world import World
from aioduco.sim.planner.blending import CornerLaw, Corners
from aioduco.sim.planner.mover import Mover
from aioduco.sim.runtime import SimulationRuntime
from aioduco.sim.server import Server
from aioduco.sim.server.force_server import ForceServer, force_sample_of
from aioduco.sim.server.generations import Generation, wire_of
from aioduco.sim.server.status_server import StatusServer, frame_of
from aioduco.sim.view.render import PictureProcess

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.kinematics import Arm
    from aioduco.models.gripper_models import GripperModel
    from aioduco.models.pose import Pose
    from aioduco.models.rotation import Array
    from aioduco.models.status_frame import StatusFrame
    from aioduco.sim.cabinet import Cabinet
    from aioduco.sim.cabinet.axis_schemes import SimulatedExternalAxes
    from aioduco.sim.controller.signal_rules import SignalRules
    from aioduco.sim.physics.gripper import Hand
    from aioduco.sim.profile import ArmProfile
    from aioduco.sim.refusal import Forgiving


_HANDLERS: dict[Generation, type[Handlers]] = {"3.8": Handlers, "4.3": NewerHandlers}


@dataclass(frozen=True, kw_only=True)
class SimulatorSettings:
    """What a simulator is built from: the arguments of `Simulator`, checked.

    The objects among them outlast a run: the cabinet and its signal rules, the external axes, and
    the count of accepted deviations.
    """

    arm: Arm
    generation: Generation
    #: duration of one cycle [s]
    cycle: float
    #: joints at the start [rad]
    joints: Array
    #: pose of the base in the world
    mounting: Pose
    #: whether the arm stands on a column
    pedestal: bool
    #: MJCF, or the path of an MJCF file
    scene: str | None
    tool: str | None
    gripper: GripperModel | None
    host: str
    #: 0 for any free port
    port: int
    #: None for no status frames
    status_port: int | None
    #: None for no force stream
    force_port: int | None
    seed: int
    real_readings: bool
    #: [s]
    vibration_time: float
    program_lag: float
    heartbeat_slack: float
    cabinet: Cabinet
    external_axes: SimulatedExternalAxes
    rules: SignalRules
    forgiving: Forgiving
    #: what is known of the arm; empty for nothing
    profile: ArmProfile


class SimulatorAssembly:
    """World, controller, simulation thread, servers and picture process of one run.

    When it is made, the servers listen, but simulated time does not run yet: `runtime.start` starts
    it.

    Args:
        settings: what to build.
        speed: simulated seconds per real second.
        on_network: called when the network goes down for a restart (False), is up again (True), or
            goes down for good (None).

    Raises:
        OSError: A server cannot listen on its address.
        SceneError: MuJoCo does not accept the MJCF of the scene or the tool.
    """

    def __init__(
        self,
        settings: SimulatorSettings,
        *,
        speed: float,
        on_network: Callable[[bool | None], None],
    ) -> None:
        arm, cycle = settings.arm, settings.cycle
        self.world: World = World(
            arm,
            cycle,
            settings.joints,
            scene=settings.scene,
            tool=settings.tool,
            mounting=settings.mounting,
            pedestal=settings.pedestal,
            gripper=settings.gripper,
            **_drives(settings),
        )
        self.controller: Controller = _controller(settings)
        self.runtime: SimulationRuntime = SimulationRuntime(
            self.controller,
            self.world,
            cycle=cycle,
            effort=arm.effort,
            speed=speed,
            sense=SensorNoise(settings.seed) if settings.real_readings else None,
            encode=_encoders(settings),
            on_network=on_network,
        )
        profile = settings.profile
        if profile.has("load"):
            mass, *centre = (profile.value("load", name, 0.0) for name in ("mass", *"xyz"))
            self.runtime.load(mass, centre)
        settings.rules.restart()
        settings.cabinet.restart()
        settings.rules.gripper = None
        if self.world.hand is not None:
            self._connect_gripper(self.world.hand, settings)
        handlers = _handlers(settings, self.controller, self.runtime)
        self.server: Server = Server(
            handlers, host=settings.host, port=settings.port, wire=wire_of(settings.generation)
        )
        self.status: StatusServer | None = None
        self.forces: ForceServer | None = None
        self._ports: list[Server | StatusServer | ForceServer] = [self.server]
        if settings.status_port is not None:
            self.status = StatusServer(
                partial(self._frame, handlers), host=settings.host, port=settings.status_port
            )
            self._ports.append(self.status)
        if settings.force_port is not None:
            self.forces = ForceServer(
                partial(force_sample_of, handlers), host=settings.host, port=settings.force_port
            )
            self._ports.append(self.forces)
        try:
            for port in self._ports:
                port.start()
        except OSError:
            self._close_ports()
            raise
        self.pictures: PictureProcess = PictureProcess(self.world.drawn)

    def _connect_gripper(self, hand: Hand, settings: SimulatorSettings) -> None:
        slave = slave_of(hand)
        if slave is None:
            settings.rules.gripper = ValveGripper(hand)
        else:
            settings.cabinet.tool_serial.peer = slave
        # The gripped thing itself is the load, whatever load the program sets.
        self.runtime.carry(0.0, (0.0, 0.0, 0.0))

    def _frame(self, handlers: Handlers) -> StatusFrame:
        return frame_of(handlers, simulated=self.runtime.snapshot.view.simulation)

    def refuse_clients(self, refused: bool) -> None:
        """Refuse clients or accept them again, on every port."""
        for port in self._ports:
            port.refuse(refused)

    def close(self) -> None:
        """Cut the connections, stop the simulation, and wait until its threads have ended."""
        self.runtime.release()
        try:
            self._close_ports()
        finally:
            self.runtime.close()
            self.pictures.close()

    def _close_ports(self) -> None:
        for port in reversed(self._ports):
            port.close()


def _drives(settings: SimulatorSettings) -> dict[str, Any]:
    """Lag and friction of the drives, if the profile has them."""
    profile = settings.profile
    found: dict[str, Any] = {}
    if profile.has("drives"):
        lag = profile.six("drives", "lag", 0.0)
        fastest = tuple(1.0 / each if each else math.inf for each in lag)
        gain = tuple(
            profile.value("drives", f"gain{i + 1}", each) for i, each in enumerate(fastest)
        )
        found["drives"] = TrailingDrives(lag, gain, settings.cycle)
    if profile.has("friction"):
        found["compensated"] = (
            profile.six("friction", "dry", 0.0),
            profile.six("friction", "viscous", 0.0),
        )
    return found


def _encoders(settings: SimulatorSettings) -> Callable[[Array], Array] | None:
    """Noise of the measured joints, if the profile has it."""
    profile = settings.profile
    if not profile.has("noise"):
        return None
    size = np.array(profile.six("noise", "joint", 0.0))
    random = np.random.default_rng(settings.seed)
    return lambda joints: joints + size * random.standard_normal(6)


def _corners(settings: SimulatorSettings) -> Corners:
    """How corners are cut, by the profile if it has that."""
    profile, usual = settings.profile, CornerLaw()
    joint, line = (
        CornerLaw(
            *(
                profile.value("blends", f"{kind}_{name}", getattr(usual, name))
                for name in CornerLaw._fields
            )
        )
        for kind in Corners._fields
    )
    return Corners(joint, line)


def _controller(settings: SimulatorSettings) -> Controller:
    arm, cycle, corners = settings.arm, settings.cycle, _corners(settings)

    def mover(q: Array) -> Mover:
        return Mover(arm, q, cycle, settling=settling, corners=corners)

    def settling() -> float:
        return settings.vibration_time if controller.optimization.vibration else 0.0

    force = ForceControl(arm, cycle, gravity(settings.mounting))
    controller = Controller(mover, settings.joints, force)
    controller.program_lag = settings.program_lag
    controller.heartbeat.slack = settings.heartbeat_slack
    times = settings.profile.values.get("times", {})
    controller.power.times.update({name: found.value for name, found in times.items()})
    controller.rules = settings.rules
    controller.external_axes = settings.external_axes
    tried = trial.current
    controller.collisions = CollisionDetector(
        np.array(arm.effort), None if tried is None else tried.passes_over
    )
    controller.tasks.made = None if tried is None else tried.task
    return controller


def _handlers(
    settings: SimulatorSettings, controller: Controller, runtime: SimulationRuntime
) -> Handlers:
    context = HandlerContext(
        settings.arm,
        runtime,
        controller,
        f"SIM{settings.seed:08d}",
        settings.cabinet,
        settings.forgiving,
        settings.mounting,
        tuple(settings.joints.tolist()),
        settings.profile.value("readings", "period", 0.0),
    )
    kind = _HANDLERS.get(settings.generation, OlderHandlers)
    return (in_single_precision(kind) if settings.real_readings else kind)(context)
