"""The simulated controller as an object: start it, set its inputs, observe the arm."""

from __future__ import annotations

import atexit
import contextlib
import inspect
import math
import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self, cast

import anyio
import anyio.to_thread
import numpy as np

from aioduco._process.closing import Startable
from aioduco.errors import ParameterError
from aioduco.kinematics import Arm
from aioduco.kinematics import arm as arm_of
from aioduco.models.gripper_models import gripper_model
from aioduco.models.host_port import host_port
from aioduco.models.pose import Joints, JointsLike, Pose, PoseLike
from aioduco.models.ranges import FLAG, JOINTS, LISTEN_HOST, LISTEN_PORT, OWN_NAME, WAIT
from aioduco.models.rules import Integer, Number
from aioduco.models.words import one_of
from aioduco.sim import trial
from aioduco.sim.arm_pictures import ArmPictures
from aioduco.sim.assembly import SimulatorAssembly, SimulatorSettings
from aioduco.sim.cabinet import Cabinet
from aioduco.sim.cabinet.axis_schemes import SimulatedExternalAxes
from aioduco.sim.cabinet.values import SystemValues
from aioduco.sim.clock import LoopStatistics, checked_speed
from aioduco.sim.controller.signal_rules import SignalRule, SignalRules
from aioduco.sim.operator_actions import OperatorActions
from aioduco.sim.part_faults import PartFaults
from aioduco.sim.physics.parts import pose_of
from aioduco.sim.profile import ArmProfile
from aioduco.sim.refusal import Forgiving
from aioduco.sim.runtime import SimulatedClock
from aioduco.sim.scene import MountingLike, SceneLike, mjcf_of, mounting_of
from aioduco.sim.server.generations import GENERATIONS, Generation

if TYPE_CHECKING:
    from os import PathLike

    from numpy.typing import NDArray

    from aioduco.sim.cabinet.script import Script
    from aioduco.sim.cabinet.signals import Signals
    from aioduco.sim.cabinet.values import Value
    from aioduco.sim.controller.state_machine import ControllerState
    from aioduco.sim.controller.tasks import ControllerTask
    from aioduco.sim.process import SimulatorProcess
    from aioduco.sim.runtime import Observer

#: time of one controller cycle [s]
CYCLE = 0.001
#: delay with which a heartbeat may arrive [s]; 0 if strict. An assumption
HEARTBEAT_SLACK = 0.5
#: Elbow bent and flange down, as in the vendor's demo: far from every singularity [rad].
READY = (0.0, 0.0, np.pi / 2, 0.0, -np.pi / 2, 0.0)
_USUAL = "gcr5_910"
_SEED = Integer(0, 2**31 - 1, source="this package")
_CYCLES = Integer(1, 2**31 - 1, source="this package")


class Simulator(OperatorActions, PartFaults, ArmPictures, Startable):
    """A simulated controller with its arm, on a TCP port of this computer.

    It runs in threads of this process, from entering its context to leaving it:

        with Simulator() as sim:          # or: async with Simulator() as sim
            ... connect to sim.host, sim.port ...

    The methods below act on the arm and the cabinet, like a person at the machine. Programs under
    test use the port.

    Args:
        model: the arm, such as "gcr5_910"; `aioduco.kinematics.models()` lists them. Or an
            `aioduco.kinematics.Arm`, such as one with lengths of your own. None for that of the
            profile, or a GCR5-910.
        profile: what is known of one arm, as `aioduco calibrate` writes it: an `ArmProfile`, or its
            file. Geometry, drives, times, noise and readings are then those of that arm; arguments
            that say the same go before it.
        generation: the controller that it plays: by its manual "3.8" or "4.3", or "older", "oldest"
            or "first", three before them. That of 3.8 also takes the calls of older clients; each
            of the others knows its own wire alone.
        host: address to listen on; loopback by default.
        port: TCP port; 0 picks a free one, which the property `port` then gives.
        status_port: TCP port of status frames, 2001 on a real controller; 0 picks a free one, which
            the property `status_port` then gives; None for no such port.
        force_port: UDP port of the force stream, 2011 on a real controller; 0 picks a free one,
            which the property `force_port` then gives; None for no such port.
        speed: simulated seconds per real second; `math.inf` for as fast as possible.
        seed: determines the serial number, and with `real_readings` the errors of the force sensor.
        real_readings: whether readings are like those of a real controller: joints, poses, torques
            and forces in single precision, and a force sensor with an offset and a noise of about
            0.5 N. Otherwise they are exact.
        joints: joints at the start [rad]; None for elbow bent and flange down.
        scene: things around the arm, in the world's frame: a sequence of
            `aioduco.sim.scene.Thing`s, the path of an MJCF file, or MJCF as text.
        tool: things that the flange carries, in the same forms, in the flange's frame.
        gripper: name of a gripper at the flange, instead of `tool`; it grips loose things of the
            scene: "robotiq_2f85", "robotiq_2f140", "robotiq_hand_e", "dh_ag95" and "dh_pge" at the
            tool's RS-485 port, "parallel" and "vacuum" on general outputs of the cabinet.
        vibration_time: time by which each motion that ends at rest takes longer while vibration
            control is on, as it is at first [s]: 0.2 to 0.4 on a real arm, 0 by default.
        program_lag: time for which the program state reads 1, stopping, after all motions have
            ended [s]: up to 2 was seen on a real controller, 0 by default.
        mounting: position of the base in the world: "floor", "wall", "ceiling", or a pose [m, rad].
        pedestal: height of a column on which an arm on the floor stands, so that it reaches below
            its base [m].
        external_axes: schemes of external axes by name, which the pendant of a real controller
            defines: for each, one to three `aioduco.sim.cabinet.Axis`, or their numbers.
        values: system values by name, which the pendant of a real controller defines.
        programs: programs by name, for run_program: each a list of calls of the wire, or a
            generator function that yields them; or a folder whose files "<name>.json" hold such
            lists.
        heartbeat_slack: delay with which a heartbeat may arrive before the arm is stopped [s]; that
            of a real controller is not known. None for 0.5, or for 0 if strict.
        strict: whether to refuse calls that deviate from the manual although public programs send
            them, such as numbers out of their range. A lenient simulator accepts them; `forgiven`
            counts them.
        cycle: duration of one cycle of controller and physics [s]; a longer one needs less
            processor time, and is less accurate.
        on_shutdown: called when a client has shut the controller down, on one of its threads.

    Raises:
        ParameterError: There is no such model or generation, or `joints` are not six angles within
            two turns; a port or the seed is out of range; the profile is not valid, or of another
            model; or an argument is of another type.
        ValueError: `external_axes` are not valid.
        SceneError: `mounting` or `pedestal` is not valid, or `scene` or `tool` holds an object that
            is not a `Thing`.
        ValueError: One of the `programs` is not valid, or a time is out of range.
        ParameterError: There is no such gripper.
        ValueError: There is a gripper and a tool.
    """

    def __init__(
        self,
        model: str | Arm | None = None,
        *,
        generation: Generation = "3.8",
        profile: ArmProfile | str | PathLike[str] | None = None,
        host: str = "127.0.0.1",
        port: int = 0,
        status_port: int | None = None,
        force_port: int | None = None,
        speed: float = 1.0,
        seed: int = 0,
        real_readings: bool = False,
        joints: JointsLike | None = None,
        scene: SceneLike | None = None,
        tool: SceneLike | None = None,
        gripper: str | None = None,
        mounting: MountingLike = "floor",
        pedestal: float = 0.0,
        external_axes: Mapping[str, Sequence[Sequence[float]]] | None = None,
        vibration_time: float = 0.0,
        program_lag: float = 0.0,
        values: Mapping[str, Value] | None = None,
        programs: Mapping[str, Script] | str | Path | None = None,
        heartbeat_slack: float | None = None,
        strict: bool = False,
        cycle: float = CYCLE,
        on_shutdown: Callable[[], object] = lambda: None,
    ) -> None:
        one_of("generation", generation, GENERATIONS)
        LISTEN_HOST("host", host)
        port = LISTEN_PORT("port", port)
        for name, number in {"status_port": status_port, "force_port": force_port}.items():
            if number is not None:
                LISTEN_PORT(name, number)
        seed = _SEED("seed", seed)
        strict, real_readings = FLAG("strict", strict), FLAG("real_readings", real_readings)
        if not callable(on_shutdown):
            raise ParameterError("on_shutdown", on_shutdown, "a function")
        _by_name("external_axes", external_axes)
        _by_name("values", values)
        if not isinstance(programs, (str, Path)):
            _by_name("programs", programs)
        known = None if profile is None else ArmProfile.of(profile)
        if known is not None:
            named = model.name if isinstance(model, Arm) else model
            if named is not None and arm_of(named).name != known.model:
                raise ParameterError("model", named, f"that of the profile, {known.model}")
            real_readings = real_readings or bool(known.single_precision)
            if heartbeat_slack is None and known.has("heartbeat"):
                heartbeat_slack = known.value("heartbeat", "slack", HEARTBEAT_SLACK)
        cycle = Number(0.0, 0.004, "s", open_low=True, source="this package")("cycle", cycle)
        if heartbeat_slack is None:
            heartbeat_slack = 0.0 if strict else HEARTBEAT_SLACK
        times = {"vibration_time": vibration_time, "program_lag": program_lag}
        for name, time in (times | {"heartbeat_slack": heartbeat_slack}).items():
            WAIT(name, time)
        if gripper is not None and tool is not None:
            raise ValueError("a gripper is the tool: give one of the two")
        if not isinstance(model, Arm):
            model = known.arm if known is not None else arm_of(_USUAL if model is None else model)
        self.arm: Final[Arm] = model
        self.mounting: Final[Pose] = mounting_of(mounting, self.arm, pedestal)
        self.gripper: Final = None if gripper is None else gripper_model(gripper)
        joints = READY if joints is None else JOINTS("joints", joints)
        if trial.current is not None:
            joints, cycle, speed = trial.current.made(
                *(model, joints),
                scene=scene,
                tool=tool,
                gripper=gripper,
                mounting=mounting,
                pedestal=pedestal,
            )
        self.generation: Final[Generation] = generation
        self.seed: Final = seed
        self.cabinet: Final[Cabinet] = Cabinet(SystemValues(values))
        self.cabinet.tooled = tool is not None or gripper is not None
        self.cabinet.project.add(programs or {})
        self.external_axes: Final = SimulatedExternalAxes(external_axes)
        self._settings = SimulatorSettings(
            arm=self.arm,
            generation=generation,
            cycle=cycle,
            joints=Joints.of(joints).array,
            mounting=self.mounting,
            pedestal=pedestal > 0.0,
            scene=None if scene is None else mjcf_of(scene),
            tool=None if tool is None else mjcf_of(tool, free=False),
            gripper=self.gripper,
            host=host,
            port=port,
            status_port=status_port,
            force_port=force_port,
            seed=seed,
            real_readings=real_readings,
            vibration_time=vibration_time,
            program_lag=program_lag,
            heartbeat_slack=heartbeat_slack,
            cabinet=self.cabinet,
            external_axes=self.external_axes,
            rules=SignalRules(),
            forgiving=Forgiving(strict=strict),
            profile=ArmProfile(self.arm.name) if known is None else known,
        )
        self._speed = checked_speed(speed)
        self._observer: Observer | None = None
        self._halted = threading.Event()
        self._on_shutdown = on_shutdown
        self._assembly: SimulatorAssembly | None = None
        self._closing = False

    def __repr__(self) -> str:
        state = (
            f"on {host_port(self.host, self.port)}" if self._assembly is not None else "not running"
        )
        return f"<{type(self).__name__} {self.arm.name} {state}>"

    # -- life ----------------------------------------------------------------------------------

    def start(self) -> Self:
        """Build the arm and listen.

        Raises:
            OSError: The server cannot listen on the address.
            SceneError: MuJoCo does not accept the MJCF of the scene or the tool.
            RuntimeError: The simulator is running already.
        """
        if self._assembly is not None:
            raise RuntimeError("this simulator is running already")
        self._halted.clear()
        assembly = SimulatorAssembly(self._settings, speed=self._speed, on_network=self._network)
        assembly.runtime.observer = self._observer
        self._assembly = assembly
        # If the interpreter exits during a simulation, it frees memory that a step still uses.
        atexit.register(self.close)
        assembly.runtime.start()
        if trial.current is not None:
            trial.current.started(self)
        return self

    def close(self) -> None:
        """Cut the connections, stop the simulation, and wait until its threads have ended."""
        atexit.unregister(self.close)
        if self._assembly is None or self._closing:
            return
        self._closing = True
        if trial.current is not None:
            trial.current.closing(self)
        try:
            self._assembly.close()
        finally:
            self._assembly, self._closing = None, False

    @staticmethod
    def spawn(**options: Any) -> SimulatorProcess:
        """Run a simulator in a process of its own.

        Args:
            options: arguments of `Simulator` without `on_shutdown`: only numbers, texts and lists,
                apart from scenes and tools.

        Returns:
            A context manager that gives the running process with its `host` and `port`.

        Raises:
            ParameterError: one of them cannot be sent to another process, as a function cannot.
            TypeError: there is no such argument.
        """
        from aioduco.sim.process import SimulatorProcess  # noqa: PLC0415 - it names this class

        if "on_shutdown" in options:
            left_out = "left out; `process.wait()` returns after a shutdown"
            raise ParameterError("on_shutdown", options["on_shutdown"], left_out)
        inspect.signature(Simulator).bind(**options)
        if trial.current is not None:  # here it is tried; it has the same attributes and methods
            return cast("SimulatorProcess", Simulator(**options))
        for name in options.keys() & {"scene", "tool"}:
            if options[name] is not None:
                options[name] = mjcf_of(options[name], free=name == "scene")
        return SimulatorProcess(options)

    # -- state ---------------------------------------------------------------------------------

    @property
    def host(self) -> str:
        """The address on which the simulator listens."""
        return self._settings.host

    @property
    def port(self) -> int:
        """The TCP port on which the simulator listens; before the start 0 for any free port."""
        return self._settings.port if self._assembly is None else self._assembly.server.port

    @property
    def status_port(self) -> int | None:
        """The TCP port of status frames; None if there is none."""
        if self._assembly is None or self._assembly.status is None:
            return self._settings.status_port
        return self._assembly.status.port

    @property
    def force_port(self) -> int | None:
        """UDP port of the force stream; None if there is none."""
        if self._assembly is None or self._assembly.forces is None:
            return self._settings.force_port
        return self._assembly.forces.port

    @property
    def scene(self) -> str | None:
        """The things around the arm: MJCF, or the path of an MJCF file; None for nothing."""
        return self._settings.scene

    @property
    def tool(self) -> str | None:
        """The things that the flange carries, in the same forms."""
        return self._settings.tool

    @property
    def pedestal(self) -> bool:
        """Whether the arm stands on a column."""
        return self._settings.pedestal

    @property
    def connections(self) -> int:
        """Number of connected clients."""
        return 0 if self._assembly is None else self._assembly.server.connections

    @property
    def time(self) -> float:
        """Simulated time since the start [s]."""
        return self._running().runtime.snapshot.time

    @property
    def clock(self) -> SimulatedClock:
        """Simulated time as a clock for `aioduco.connect(clock=...)`, in this process.

            async with aioduco.connect(sim.host, sim.port, clock=sim.clock) as robot:

        It can be held: simulated time stands still while the program ends a motion at its due time.
        """
        return SimulatedClock(self._running().runtime)

    @property
    def speed(self) -> float:
        """Simulated seconds per real second; may be set while the simulator runs."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        self._speed = checked_speed(speed)
        if self._assembly is not None:
            self._assembly.runtime.set_speed(speed)

    @property
    def joints(self) -> Joints:
        """Joints of the real arm [rad], also while its controller only simulates."""
        return Joints.of(self._running().runtime.snapshot.positions[:6])

    @property
    def moving(self) -> bool:
        """Whether the arm moves, as the controller reports it (`robotmoving`).

        After a motion has finished this is false, although a joint may still swing by some
        hundredths of a milliradian. `view.standing` takes that into account.
        """
        return self.view.moving

    @property
    def view(self) -> ControllerState:
        """The controller's states, error list, tool and work object at this instant."""
        return self._running().runtime.snapshot.view

    @property
    def halted(self) -> bool:
        """Whether a client has shut the controller down."""
        return self._halted.is_set()

    @property
    def tasks(self) -> tuple[ControllerTask, ...]:
        """The tasks that have not ended, oldest first."""
        return self._running().controller.tasks.unfinished()

    def task(self, id: int) -> ControllerTask | None:  # noqa: A002 - what it is
        """A task that runs or has ended, by its id; None if it is unknown or no longer stored."""
        return self._running().controller.tasks.get(id)

    def observe(self, observer: Observer | None) -> None:
        """Set the function that is called after every cycle, in place of an earlier one.

        Args:
            observer: called on the simulation's thread, which waits for it, with the state after
                the cycle and with a function that describes the arm's contacts; None for nothing.
                An error that it raises ends the simulation: clients get an application error, and
                the methods of this simulator raise RuntimeError.

        Raises:
            ParameterError: It is neither a function nor None.
        """
        if observer is not None and not callable(observer):
            raise ParameterError("observer", observer, "a function, or None")
        self._observer = observer
        if self._assembly is not None:
            self._assembly.runtime.observer = observer

    def get_digital_output(self, num: int) -> bool:
        """State of a general output of the cabinet, 1 to 16.

        Raises:
            IndexError: There is no such output.
        """
        outputs = self.signals.standard_out
        return outputs[num] and outputs.level(num, self.time)

    @property
    def forgiven(self) -> dict[str, int]:
        """Number of accepted deviations from the manual, by kind; empty if there was none."""
        return self._settings.forgiving.counts

    @property
    def signals(self) -> Signals:
        """Every signal and register by number, such as `sim.signals.voltage_in[2] = 5.0`."""
        return self._running().controller.signals

    def statistics(self) -> LoopStatistics:
        """Timing of the controller's cycles."""
        return self._running().runtime.statistics()

    def wait_until(self, predicate: Callable[[], bool], timeout: float = 10.0) -> None:
        """Wait until a condition holds.

        The calling thread checks it, at most once per cycle: when the simulation runs faster than
        that thread, the thread sees only some of the cycles.

        Args:
            predicate: the condition, such as `lambda: not sim.moving`.
            timeout: the longest wait, in simulated time [s]; `math.inf` for no limit.

        Raises:
            ParameterError: The time is negative, or the predicate must be awaited.
            TimeoutError: The condition did not hold in time.
        """
        if timeout != math.inf:
            timeout = WAIT("timeout", timeout)
        if not self._running().runtime.wait_until(predicate, timeout):
            raise TimeoutError(f"it did not come to hold within {timeout} s of simulated time")

    async def wait_until_async(self, predicate: Callable[[], bool], timeout: float = 10.0) -> None:
        """Wait like `wait_until`, asynchronously; the predicate is called in another thread."""
        await anyio.to_thread.run_sync(self.wait_until, predicate, timeout)

    def drop_connections(self) -> int:
        """Cut every connection, like a pulled cable, and return their number."""
        return 0 if self._assembly is None else self._assembly.server.drop()

    # -- wiring --------------------------------------------------------------------------------

    def rule(
        self,
        output: int | str,
        input: int | str,  # noqa: A002 - what it is
        *,
        after: float = 0.0,
        inverted: bool = False,
    ) -> None:
        """Make an input follow an output, as the sensor of a cylinder follows its valve.

            sim.rule(output=1, input=3, after=0.5)      # closed, half a second after the valve

        It may also be called before the start. The input takes the output's state at once, and then
        follows each change until another rule is given for it. It also follows a pulse that is
        shorter than `after`.

        Args:
            output: a general output, 1 to 16; "tool 1" or "tool 2" for one of the tool.
            input: a general input, likewise.
            after: delay with which it follows, in simulated time [s].
            inverted: whether the input is on while the output is off.

        Raises:
            ParameterError: There is no such signal, or the time is negative.
        """
        rule = SignalRule(output, input, after, inverted)
        running = self._assembly
        with contextlib.nullcontext() if running is None else running.runtime.command():
            self._settings.rules.add(rule)

    # -- step by step ---------------------------------------------------------------------------

    def lock_time(self) -> None:
        """Lock simulated time: from now on it stands still, and only `advance` moves it.

        So a program's work between two steps takes no simulated time, and the same commands at the
        same cycles have the same effect in every run. Calls are answered meanwhile; calls that wait
        for the end of a task need `advance`.
        """
        self._running().runtime.lock()

    def unlock_time(self) -> None:
        """Unlock simulated time, so that it runs by itself again."""
        self._running().runtime.unlock()

    def advance(self, cycles: int) -> None:
        """Run a number of cycles, as fast as possible, and return when they have run.

        Args:
            cycles: number of cycles, at least 1; the argument `cycle` of `Simulator` is the
                duration of each, 1 ms by default.

        Raises:
            ParameterError: `cycles` is no whole number, or less than 1.
            RuntimeError: simulated time is not locked.
        """
        cycles = _CYCLES("cycles", cycles)
        self._running().runtime.advance(cycles)

    def arrange(self, things: Mapping[str, PoseLike]) -> None:
        """Place things, the rest of the scene as at the start, and the arm at its set-point.

        Afterwards nothing moves: the further simulation depends only on the joints and on `things`.
        Call it for an arm at rest, while simulated time is locked.

        Args:
            things: poses in the world [m, rad], by the names of things of the scene with a mass.

        Raises:
            ParameterError: there is no such thing.
            RuntimeError: simulated time is not locked.
        """
        self._running().runtime.arrange(things)

    # -- observing the arm ----------------------------------------------------------------------

    def thing(self, name: str) -> Pose:
        """Pose in the world of a thing of the scene that may move on its own [m, rad].

        Raises:
            ParameterError: there is no such thing.
        """
        return pose_of(self.positions[self.place(name)])

    def place(self, name: str) -> slice:
        """Indices of such a thing in `positions`: x, y, z [m], and a quaternion, w first.

        Raises:
            ParameterError: there is no such thing.
        """
        return self._running().world.parts.place(name)

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions of all moving parts, for `render`: the joints, the tool, the scene."""
        return self._running().runtime.snapshot.positions.copy()

    def instant(self) -> tuple[float, NDArray[np.float64]]:
        """Simulated time [s], and the positions at that time, for `render`."""
        snapshot = self._running().runtime.snapshot
        return snapshot.time, snapshot.positions.copy()

    # -- inside --------------------------------------------------------------------------------

    def _running(self) -> SimulatorAssembly:
        if self._assembly is None:
            raise RuntimeError("this simulator is not running: enter it by `with` or `async with`")
        self._assembly.runtime.check()
        return self._assembly

    def _network(self, up: bool | None) -> None:
        """Handle the network: it is up (True), down for a restart (False), or for good (None)."""
        if self._assembly is not None:
            self._assembly.refuse_clients(not up)
        if up is None:
            self._halted.set()
            self._on_shutdown()


def _by_name(name: str, table: object) -> None:
    """Check that an argument is a dict with names, or None."""
    if table is not None and not isinstance(table, Mapping):
        raise ParameterError(name, table, "a dict: what there is, by its name")
    for each in table or ():
        OWN_NAME(f"a name of {name}", each)
