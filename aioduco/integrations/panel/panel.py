"""The panel: pages, a lease, and two robots: an observer, and one for the duration of a lease.

Guarantees:
- The observing robot sends no heartbeat and moves nothing: the program that moves the arm keeps its
  supervision. A stop from any page uses its stop lane, and waits for no other request of a page.
- The robot of a lease is opened and closed with the lease, and closing stops its motion. Its
  heartbeat makes the controller stop the arm if this program dies or hangs.
"""

from __future__ import annotations

import contextlib
import itertools
import logging
import math
import secrets
import time
from collections import deque
from typing import TYPE_CHECKING, Any, Final, Self
from urllib.parse import quote

import anyio

import aioduco
from aioduco import JogDirections, ProgramState, events
from aioduco._process.copying import Uncopied
from aioduco._process.threads import in_thread
from aioduco.errors import (
    DucoError,
    MissingExtra,
    ParameterError,
    RobotStateError,
    StopsUnconfirmed,
)
from aioduco.integrations.panel.control_lease import (
    BeginLease,
    BeginMotion,
    ControlLease,
    EndLease,
    EndMotion,
    LeasePhase,
    RefusePage,
)
from aioduco.integrations.panel.measuring import Measurement, take_step, write
from aioduco.integrations.panel.page_requests import (
    JOINT_ACCELERATION,
    LINE_ACCELERATION,
    GiveBack,
    JogMotion,
    JointMotion,
    LetGo,
    MeasureStep,
    PageAim,
    PageBeat,
    PageStop,
    Press,
    RobotAction,
    SetOutput,
    SimulatorLine,
    TakeControl,
    WriteMeasured,
    page_request,
)
from aioduco.integrations.panel.page_server import PageServer
from aioduco.integrations.panel.page_state import (
    alarm_text,
    history_point,
    page_sample,
)
from aioduco.integrations.panel.page_stops import PageStops
from aioduco.integrations.panel.simulator_port import ask_simulator
from aioduco.integrations.panel.twin_view import TWIN_RATE, parted_text, twin_line
from aioduco.kinematics import arm as arm_of
from aioduco.kinematics.catalogue import arm_named, model_named
from aioduco.models.host_port import host_port
from aioduco.models.ranges import LISTEN_HOST
from aioduco.models.rules import Number
from aioduco.models.user_terms import in_terms_of
from aioduco.supervision.concurrency import every

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from anyio.abc import TaskGroup
    from websockets.asyncio.server import ServerConnection

    from aioduco import RecoverReport, Robot, Snapshot, Task
    from aioduco.envelope import Envelope
    from aioduco.integrations.panel.arm_scene import ArmScene
    from aioduco.integrations.panel.control_lease import LeaseEffect
    from aioduco.integrations.panel.page_requests import HoldMotion, PageRequest
    from aioduco.kinematics import Arm
    from aioduco.planning import Scene
    from aioduco.sim.twin import Twin, TwinLimits


_log = logging.getLogger("aioduco.integrations.panel")

#: seconds between two reads of values that change seldom
_SELDOM: Final = 1.0
#: number of events that are kept for pages that open later
_KEPT: Final = 200
#: time span of the plots [s]
_MINUTE: Final = 60.0
#: points per second that are kept for pages that open later
_KEPT_RATE: Final = 5.0
#: seconds without a sample after which pages show that the controller does not answer
_SILENT: Final = 1.0
#: events that only the robot that commands the arm reports
_OF_COMMANDER: Final = (events.EnvelopeLeft, events.EnvelopeUnwatched, events.HeartbeatChanged)
#: model that is drawn if neither the controller nor a scene or an envelope says which one it is
_DRAWN_AS: Final = "gcr5_910"
#: function of the robot that errors name -> the page's button for it
_BUTTONS: Final = {
    "bring_up": "Bring up",
    "recover": "Recover",
    "rearm_heartbeat": "Recover",
    "stop": "STOP",
    "resume": "Resume",
    "envelope": "the envelope in the file that gives it",
}


class Panel(Uncopied):
    """An arm in the browser: `async with Panel("192.168.1.10") as panel: print(panel.link)`.

    Everyone who can reach the page may watch and stop the arm. A page that commands needs the token
    and the lease, which one page holds at a time. The arm moves only while a button is held down.
    The lease ends when its page is closed, and its motion is stopped.

    Args:
        host: name or address of the controller.
        port: its TCP port.
        listen: port of the page and its 3D picture; 0 for a free one.
        bind: address of this computer to listen on. Any address but loopback lets everybody in
            that network watch, and stop the arm.
        token: secret that a page must present to command; None for a new one, "" if no page may
            command.
        name: name of the robot on the page; empty for its address.
        model: the arm that is drawn, such as "gcr5_910"; None for the one that the controller
            reports, or that of the scene or the envelope if it reports none.
        scene: objects around the arm, to be drawn; None for nothing.
        envelope: limits within which the panel keeps the arm; its zones are drawn. None for none.
        simulator_port: a simulator's port for commands, on this computer; None for none.
        rate: states per second that are sent to pages, 2 to 50 [Hz].
        hold_limit: seconds for which a motion continues after the sending time of the newest state
            that its page confirmed: 0.1 to 600, and 2 / rate or more if a page may command.
        page_limit: seconds without a keep-alive message or a button press of its page after which a
            lease ends, 0.5 to 600.
        directions: the controller's meaning of the directions of a jog; None: as its version says.
        twin: whether to watch the arm beside a simulated one, and draw both: True with wide limits,
            or the limits, from `aioduco.sim.twin.learn`. It reports, and never commands.
        options: further options of `connect`, for both robots, such as `clock`.

    Attributes:
        twin: the arm's twin; None without one, and before the panel is open.

    Raises:
        ParameterError: an argument is out of range.
    """

    _begun: bool = False

    def __init__(
        self,
        host: str,
        port: int = 7003,
        *,
        listen: int = 8080,
        bind: str = "127.0.0.1",
        token: str | None = None,
        name: str = "",
        model: str | None = None,
        scene: Scene | None = None,
        envelope: Envelope | None = None,
        simulator_port: int | None = None,
        rate: float = 20.0,
        hold_limit: float = 0.4,
        page_limit: float = 3.0,
        directions: JogDirections | None = None,
        twin: TwinLimits | bool = False,
        **options: Any,
    ) -> None:
        rate = Number(2.0, 50.0, "Hz", source="this package")("rate", rate)
        # a page confirms a state when it gets it: with fewer, each motion would end at once
        least = 0.1 if token == "" else max(0.1, 2.0 / rate)
        hold_limit = Number(least, 600.0, "s", source="this package")("hold_limit", hold_limit)
        page_limit = Number(0.5, 600.0, "s", source="this package")("page_limit", page_limit)
        if directions is not None and not isinstance(directions, JogDirections):
            raise ParameterError("directions", directions, "a member of JogDirections, or None")
        self.token: str = secrets.token_urlsafe(18) if token is None else token
        self.twin: Twin | None = None
        self.rate = rate
        self._address = (host, port)
        self._options = {"lag_limit": None, **options}
        self._name = name or host_port(host, port)
        self._model = model
        self._scene_around = scene
        self._envelope = envelope
        self._simulator_port = simulator_port
        self._directions = directions
        self._hold_limit = hold_limit
        self._lease = ControlLease(self.token, hold_limit=hold_limit, page_limit=page_limit)
        self._stops = PageStops(
            self._stop, lambda: self._apply(self._lease.stop()), self._stop_ended
        )
        self._server = PageServer(
            LISTEN_HOST("bind", bind), listen, self._hello, self._take, self._left,
            self._stops.carry_out, self._show_picture,
        )  # fmt: skip
        self._twin_limits = twin
        states = max(rate, 10.0 if twin is False else TWIN_RATE)
        quiet = self._options | {"heartbeat": None, "state_rate": states}
        self._observer: Robot = aioduco.connect(host, port, **quiet)
        self._observer.feed.forces = True
        self._commander: Robot | None = None
        self._scene: ArmScene | None = None
        self._arm = _arm_shown(model, scene, envelope)
        self._measured = Measurement(self._arm, "floor" if scene is None else scene.mounting)
        self._all: TaskGroup | None = None
        self._work: TaskGroup | None = None
        self._lease_over = anyio.Event()
        self._button_released = anyio.Event()
        self._motion_scope: anyio.CancelScope | None = None
        self._jog: Task | None = None
        self._resumed = False
        self._aim: tuple[float, ...] | None = None
        self._busy: list[str] = []
        self._wrong_tokens: list[str] = []
        self._sample: Snapshot | None = None
        self._told: dict[str, Any] = {}
        self._seldom: dict[str, Any] = {"tell": "seldom"}
        self._numbers = itertools.count(1)
        self._sent: dict[int, float] = {}
        #: number of states whose sending time is stored; older ones are too old for a motion
        self._numbered = math.ceil(rate * (hold_limit + 1.0))
        self._history: deque[list[Any]] = deque(maxlen=int(_MINUTE * _KEPT_RATE))
        self._events: deque[dict[str, Any]] = deque(maxlen=_KEPT)

    def __repr__(self) -> str:  # never with the token
        return f"<Panel of {self._name} on {self.url}, {self._lease!r}>"

    @property
    def url(self) -> str:
        """Address of the page, for observers."""
        return f"http://{host_port(self._server.host, self._server.port)}/"

    @property
    def link(self) -> str:
        """Address of the page with the token, for the person who commands.

        The token follows a #: a browser does not send that part, and the page hides it.
        """
        return f"{self.url}#token={quote(self.token, safe='')}" if self.token else self.url

    async def __aenter__(self) -> Self:
        """Connect, and serve the page.

        Raises:
            ConnectError: there is no controller.
            OSError: the port is taken, or the address is not one of this computer.
            RobotStateError: it was opened before.
        """
        if self._begun:
            raise RobotStateError("a panel is opened once: make another one")
        self._begun = True
        async with contextlib.AsyncExitStack() as stack:
            await stack.enter_async_context(self._observer)
            await self._identify_arm()
            self._scene = await in_thread(self._make_scene)
            stack.push_async_callback(in_thread, self._scene.close)
            if (limits := self._twin_limits) is not False:
                known, around = None if limits is True else limits, self._scene_around
                mounting = None if around is None else around.mounting
                # The twin sees the arm alone: other programs may command it.
                self.twin = self._observer.twin(
                    known, arm=self._arm.name, mounting=mounting, commands=False
                )
                await stack.enter_async_context(self.twin)
            # last: pages that wait for a panel come at once
            await stack.enter_async_context(self._server.listening())
            self._all = self._stops.tasks = group = await anyio.create_task_group().__aenter__()
            stack.push_async_callback(self._end_work, group)
            for work in (self._samples, self._happenings, self._ask_seldom, self._tell):
                group.start_soon(work)
            self._stack = stack.pop_all()
        return self

    async def __aexit__(self, *exc: Any) -> None:
        """End it: stop a lease's motion and wait until the arm stands; other motions continue."""
        await self._stack.__aexit__(*exc)

    async def _end_work(self, group: TaskGroup) -> None:
        """Cancel all tasks; an error of the caller's block stays unchanged."""
        group.cancel_scope.cancel()
        await group.__aexit__(None, None, None)
        self._all = self._stops.tasks = None

    async def _identify_arm(self) -> None:
        """Find out which arm it is, and whether there is a simulator."""
        told = await _asked(self._observer.version.get_robot_type)
        arm = "" if told is None else arm_named(told)
        version = self._observer.version.controller
        self._seldom["arm"] = f"{arm} {version}".strip()
        found = None if self._model is not None else model_named(arm)
        if found is not None:
            self._arm = self._measured.arm = found
        elif self._model is None:
            self._note(
                f"the controller tells no arm that is known: drawn as {self._arm.name}", "warning"
            )
        if self._simulator_port is not None:
            try:
                await ask_simulator(self._simulator_port, "state")
            except OSError as error:
                _log.info("no simulator takes commands: %s", error)
                self._simulator_port = None

    def _make_scene(self) -> ArmScene:
        """Make the scene; run on a thread, because viser takes a while to load and to start."""
        with MissingExtra.named("the panel's picture", "panel"):
            from aioduco.integrations.panel.arm_scene import ArmScene  # noqa: PLC0415

        around, twin = self._scene_around, self._twin_limits is not False
        return ArmScene(self._arm, around, self._envelope, twin=twin)

    # -- requests of pages, on the event loop: nothing here waits ----------------------------------

    def _hello(self, page: int) -> dict[str, Any]:
        return {
            "tell": "hello",
            "page": page,
            "name": self._name,
            "model": self._arm.name,
            "lower": self._arm.lower,
            "upper": self._arm.upper,
            "watch_only": not self.token,
            "twin": self.twin is not None,
            "simulator": self._simulator_port is not None,
            "limits": () if self._envelope is None else self._envelope.titles,
            "rate": self.rate,
            "hold_limit": self._hold_limit,
            "history": list(self._history),
            "events": list(self._events),
            "seldom": self._seldom,
            "measured": self._measured.as_json(),
        }

    def _take(self, page: int, message: str | bytes) -> None:
        """Carry out a message of a page, or refuse it."""
        try:
            request = page_request(message)
        except ParameterError as error:
            self._server.send(page, {"tell": "refused", "reason": str(error)})
            return
        if isinstance(request, PageStop):  # before all other requests
            self._stops.begin()
            return
        now = time.monotonic()
        lease = self._lease
        if isinstance(request, TakeControl):
            self._apply(lease.take(page, request.token, now))
        elif isinstance(request, GiveBack):
            self._apply(lease.release(page))
        elif isinstance(request, Press):
            self._apply(lease.press(page, request.motion, self._seen_at(request.seen), now))
        elif isinstance(request, LetGo):
            self._apply(lease.button_released(page))
        elif isinstance(request, PageBeat):
            seen_at = self._seen_at(request.seen)
            self._apply(lease.beat(page, seen_at, now, down=request.down))
        elif isinstance(request, PageAim):
            self._aim = request.joints if page == lease.holder else self._aim
        else:
            refused = lease.refusal(page)
            # A pause, which may come late, is no request that could move anything.
            if (
                refused is None
                and isinstance(request, RobotAction | SetOutput)
                and request != RobotAction("pause", request.seen)
            ):
                refused = lease.too_old(page, self._seen_at(request.seen), now)
            if refused is not None:
                self._apply(refused)
            else:
                self._begin_action(request)

    def _seen_at(self, number: int) -> float:
        """When a state was sent [s]; minus infinity for an old or unknown state."""
        return self._sent.get(number, -math.inf)

    def _left(self, page: int) -> None:
        self._apply(self._lease.gone(page))

    def _apply(self, effect: LeaseEffect | None) -> None:
        """Carry out a decision of the lease."""
        if isinstance(effect, RefusePage):
            self._server.send(effect.page, {"tell": "refused", "reason": effect.reason})
            if effect.wrong_token:
                # noted once a second, whatever pages do
                self._wrong_tokens.append(self._server.address_of(effect.page))
        elif isinstance(effect, BeginLease) and self._all is not None:
            self._lease_over = anyio.Event()
            self._all.start_soon(self._command)
        elif isinstance(effect, EndLease):
            self._note(f"the lease ends: {effect.reason}")
            self._cancel_motion()
            self._lease_over.set()
        elif isinstance(effect, BeginMotion) and self._work is not None:
            self._button_released = anyio.Event()
            self._motion_scope = scope = anyio.CancelScope()
            self._work.start_soon(self._move, effect.motion, scope)
        elif isinstance(effect, EndMotion):
            self._button_released.set()
            # A jog whose button was released is ended in order; every other motion is cancelled.
            if effect.reason or self._jog is None:
                self._cancel_motion()
            if effect.reason:
                self._note(f"the motion ends: {effect.reason}", "warning")

    def _cancel_motion(self) -> None:
        if self._motion_scope is not None:
            self._motion_scope.cancel()

    # -- actions ---------------------------------------------------------------------------------

    async def _stop(self) -> str:
        """Stop the arm for a page; returns the reason if that failed."""
        self._busy.append("stop")
        self._resumed = False
        try:
            # what a page commanded may still be on its way: its robot's stop waits for that
            commander = () if self._commander is None else (self._commander,)
            await aioduco.stop_all((self._observer, *commander))
        except StopsUnconfirmed as error:
            return f"stop failed: {error.__cause__}"  # of the one arm: the first robot's reason
        finally:
            self._busy.remove("stop")
        return ""

    def _stop_ended(self, failed: str) -> None:
        self._lease.stop_ended()
        if not self._stops:
            self._note(failed or "stopped: the arm stands", "alarm" if failed else "good")

    async def _show_picture(self, connection: ServerConnection) -> None:
        if self._scene is not None:
            await self._scene.serve(connection)

    async def _command(self) -> None:
        """A lease, from its opening to the standstill at its end."""
        host, port = self._address
        over = self._lease_over
        try:
            async with aioduco.connect(host, port, **self._options) as robot:
                robot.envelope = self._envelope
                try:
                    async with anyio.create_task_group() as work:
                        self._commander, self._work = robot, work
                        work.start_soon(self._hear, robot)
                        self._lease.opened()
                        self._note("a page commands")
                        await over.wait()
                        work.cancel_scope.cancel()
                finally:
                    self._commander = self._work = None
                    with anyio.CancelScope(shield=True):
                        await self._stops.over()  # they need this robot
                    if self._resumed:  # not a motion of this robot, but this lease resumed it
                        self._resumed = False
                        with anyio.CancelScope(shield=True):
                            await robot.stop()
        except DucoError as error:
            self._note(f"the lease failed: {error}", "alarm")
        finally:
            self._aim = None
            self._lease.closed()
            self._note("nobody commands")

    async def _hear(self, robot: Robot) -> None:
        """Note events that the observing robot does not report."""
        with robot.events.subscribe("drop_oldest") as stream:
            async for event in stream:
                if isinstance(event, _OF_COMMANDER):
                    self._note(event.line(), event.severity)

    async def _move(self, motion: HoldMotion, scope: anyio.CancelScope) -> None:
        """Carry out the motion of a button."""
        robot = self._commander
        assert robot is not None, "motions begin within a lease"
        done = "ended"
        try:
            with scope:
                if isinstance(motion, JogMotion):
                    jog = robot.motion.move_jog(motion.jog, time=None, directions=self._directions)
                    async with jog as self._jog:
                        await self._button_released.wait()
                elif isinstance(motion, JointMotion):
                    await robot.motion.movej2(motion.joints, motion.speed, JOINT_ACCELERATION)
                    done = "there"
                else:
                    await robot.motion.movel(motion.pose, motion.speed, LINE_ACCELERATION)
                    done = "there"
        except DucoError as error:
            self._note(f"{motion}: {error}", "warning")
        else:
            self._note(f"{motion}: {done}")
        finally:
            self._jog = self._motion_scope = None
            self._lease.motion_ended()

    def _begin_action(self, request: PageRequest) -> None:
        """Begin a request that is neither a motion nor a stop, for the page that commands."""
        robot, work = self._commander, self._work
        if robot is None or work is None or self._all is None:
            return
        if isinstance(request, RobotAction):
            if request.verb not in self._busy:
                work.start_soon(self._act, robot, request.verb)
        elif isinstance(request, SetOutput):
            name = f"{'tool ' if request.tool else ''}output {request.num}"
            io = robot.io
            put = io.set_tool_digital_out if request.tool else io.set_standard_digital_out
            said = f"{name} {'on' if request.on else 'off'}"
            work.start_soon(self._carry_out, name, lambda: put(request.num, request.on), said)
        elif isinstance(request, MeasureStep | WriteMeasured):
            if "measure" not in self._busy:
                work.start_soon(self._measure, robot, request)
        elif isinstance(request, SimulatorLine) and self._simulator_port is not None:
            self._all.start_soon(self._simulate, request.line, self._simulator_port)

    async def _act(self, robot: Robot, verb: str) -> None:
        steps: dict[str, tuple[Callable[[], Awaitable[Any]], str]] = {
            "bring_up": (lambda: self._advised(robot.bring_up()), "brought up: the arm can move"),
            "recover": (lambda: self._advised(robot.recover()), "recovered: the arm can move"),
            "pause": (robot.pause, "paused: the arm stands"),
            "resume": (robot.resume, "resumed"),
        }
        step, said = steps[verb]
        # The arm counts as moving until it is known to stand.
        self._resumed = self._resumed or verb == "resume"
        if await self._carry_out(verb, step, said) and verb != "resume":
            self._resumed = False

    async def _advised(self, step: Awaitable[RecoverReport]) -> None:
        """Carry out a step, and show what to do before forces are measured again."""
        if advice := (await step).advice:
            self._note(advice, "warning")

    async def _carry_out(self, name: str, step: Callable[[], Awaitable[Any]], said: str) -> bool:
        self._busy.append(name)
        try:
            done = await step()
        except DucoError as error:
            self._note(f"{name.replace('_', ' ')} failed: {error}", "alarm")
            return False
        finally:
            self._busy.remove(name)
        self._note("nothing was paused" if done is False else said, "good")
        return True

    async def _measure(self, robot: Robot, request: MeasureStep | WriteMeasured) -> None:
        self._busy.append("measure")
        try:
            if isinstance(request, WriteMeasured):
                self._note(await write(self._measured, robot, request), "good")
            else:
                await take_step(self._measured, robot, request)
        except DucoError as error:
            self._note(f"measurement: {error}", "alarm")
        finally:
            self._busy.remove("measure")
        self._server.broadcast(self._measured.as_json())

    async def _simulate(self, line: str, port: int) -> None:
        try:
            answer = await ask_simulator(port, line)
        except OSError as error:
            answer = f"error: no simulator answers: {error}"
        severity = "warning" if answer.startswith("error") else "info"
        self._note(f"simulator: {line}: {answer}", severity)

    # -- messages to pages -----------------------------------------------------------------------

    def _note(self, text: str, severity: str = "info") -> None:
        """Show a line among the events of every page."""
        told = in_terms_of(_BUTTONS, text)
        line = {"at": time.strftime("%H:%M:%S"), "text": told, "severity": severity}
        self._events.append(line)
        self._server.broadcast({"tell": "event", **line})

    async def _samples(self) -> None:
        with self._observer.feed.subscribe("latest") as samples:
            async for self._sample in samples:
                if self._sample.states.program is ProgramState.STOPPED:
                    self._resumed = self._resumed and "resume" in self._busy

    async def _happenings(self) -> None:
        with self._observer.events.subscribe("drop_oldest") as stream:
            async for event in stream:
                text = (
                    parted_text(event) if isinstance(event, events.TwinDiverged) else event.line()
                )
                self._note(text, event.severity)

    async def _ask_seldom(self) -> None:
        robot = self._observer
        async for _ in every(_SELDOM):
            self._seldom |= {
                "project": await _asked(robot.program.get_current_project) or "",
                "speed": await _asked(robot.settings.get_global_speed),
                "pages": self._server.pages,
            }
            # last: pages take it for where the tool is, while the arm stands
            pose = await _asked(robot.state.get_tcp_pose_coord)
            self._seldom["work_pose"] = None if pose is None else [*pose]
            if self._wrong_tokens:
                number, where = len(self._wrong_tokens), self._wrong_tokens[-1]
                said = f"{number} wrong token{'s' * (number > 1)} refused, from {where}"
                _log.warning("the panel: %s; nothing was moved", said)
                self._note(said, "warning")
                self._wrong_tokens.clear()
            self._server.broadcast(self._seldom)

    async def _tell(self) -> None:
        """Send the state to every page at a steady rate, and apply the time-outs of the lease."""
        shown, kept_at = None, 0.0
        async for _ in every(1.0 / self.rate):
            self._apply(self._lease.due(time.monotonic()))
            if self._jog is not None and self._jog.done:
                self._button_released.set()  # it ended by itself
            sample, now = self._sample, time.monotonic()
            if sample is not None and sample is not shown:
                shown = sample
                self._told = page_sample(sample)
            if sample is not None and now - kept_at >= 1.0 / _KEPT_RATE:
                kept_at = now
                self._history.append([round(now, 2), *history_point(self._told)])
            self._tell_state(sample, now)

    def _tell_state(self, sample: Snapshot | None, now: float) -> None:
        number = next(self._numbers)
        self._sent[number] = time.monotonic()
        self._sent.pop(number - self._numbered, None)
        if self._scene is not None and sample is not None:
            told = sample.status
            twin = None if self.twin is None else self.twin.joints
            self._scene.show([*told.joints], [*told.expected_joints], self._aim, twin)
        age = math.inf if sample is None else sample.age
        robot = self._commander
        lease = self._lease
        held = lease.phase is LeasePhase.HELD
        self._server.broadcast(
            {
                "tell": "state",
                "n": number,
                "now": round(now, 3),
                "age": None if sample is None else round(age, 3),
                "alarm": alarm_text(sample, max(_SILENT, 3.0 / self.rate), age),
                "holder": lease.holder,
                "phase": lease.phase.value,
                "motion": None if lease.motion is None else str(lease.motion),
                "tasks": []
                if robot is None or not held
                else [f"{each.name} {each.state.name}" for each in robot.tasks],
                "busy": self._busy,
                "sample": self._told or None,
                "twin": None if self.twin is None else twin_line(self.twin),
                "late": None if sample is None else history_point(self._told)[-1],
            }
        )


def _arm_shown(model: str | None, scene: Scene | None, envelope: Envelope | None) -> Arm:
    """The arm to draw unless the controller reports one."""
    if model is None:
        for around in (scene, envelope):
            if around is not None:
                return around.arm
    return arm_of(model or _DRAWN_AS)


async def _asked(ask: Callable[[], Awaitable[Any]]) -> Any:
    """The answer to a request; None after an error."""
    try:
        return await ask()
    except DucoError:
        return None
