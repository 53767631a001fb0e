"""The worker of a stream: it owns a connection and a schedule, and sends the program's set-points.

The same code runs in a separate process, which gets the shared block and a socket to the program,
or in a thread. The socket carries no data: the worker writes a byte when there is news in the
block, and the end of the data (EOF) from one side tells the other side that it has ended.

When the program dies, the worker brings the arm to rest, stops the robot, and ends. When its permit
has ended, it sends no set-point any more, not even to brake: it ends the controller's mode, stops
the robot unless another one does, and waits until the arm stands.
"""

from __future__ import annotations

import contextlib
import gc
import os
import signal
import threading
import time
import traceback
from pathlib import Path
from typing import TYPE_CHECKING

from aioduco._process.platform import (
    boost_main_thread,
    drop_realtime_priority,
    ending_signals,
    handed_socket,
    readiness,
    realtime_priority,
    set_affinity,
    set_realtime_priority,
)
from aioduco._process.scheduling import shorten_slice
from aioduco._wire import way_out
from aioduco._wire.endpoint import Endpoint
from aioduco._wire.own_connection import OwnConnection
from aioduco.errors import ControllerError, DucoError, OutcomeUnknown, StopUnconfirmed
from aioduco.models.enums import TaskState
from aioduco.streaming.shared.block import Block
from aioduco.streaming.shared.words import ControlWord, Reason, StatusWord, StreamState, Unmet
from aioduco.streaming.worker.buffered import RealtimeQueueDriver, TrackPoolDriver
from aioduco.streaming.worker.clock import ProcessorShare, Schedule, sharpen_sleep, sleep_until
from aioduco.streaming.worker.drivers import CallDriver, ProbeDriver
from aioduco.streaming.worker.permit import PermitEnded, StreamPermit
from aioduco.streaming.worker.rest import bring_to_rest
from aioduco.streaming.worker.watch import disabled, ended, refused
from aioduco.supervision.unanswered import UnansweredMotion

if TYPE_CHECKING:
    import socket

    from aioduco._wire.connection import Connection
    from aioduco.streaming.shared.config import WorkerConfig
    from aioduco.streaming.shared.options import WorkerOptions
    from aioduco.streaming.worker.driver import Driver


#: reasons for which the worker itself stops the robot: no other part detects them, or can stop it
_STOPS = (
    Reason.STARVED,
    Reason.PROGRAM_DIED,
    Reason.HUNG,
    Reason.REFUSED,
    Reason.CONNECTION,
    Reason.FAILED,
    Reason.ENVELOPE,
    Reason.AWAY,
    Reason.LAPSED,
)
_ANSWER = 50_000  # ns: no controller answers sooner
_SLICE = 100_000  # ns: the shortest time slice that the system allows
_LATE = 1_000_000  # ns of lateness, or a quarter of a period, after which a worker takes SCHED_FIFO
_LONGEST = 0.05  # s of work without a wait, after which it loses SCHED_FIFO
_LOOK = 5_000_000  # ns between two checks whether the program is alive
_STAND_LIMIT = 5.0  # s within which the arm must stand still
_REPORT = 10_000_000  # ns between two reports of the set-point


class StreamWorker:
    """One run of a worker, from the connection to the last call.

    Args:
        block: the shared block, with the configuration.
        link: the worker's end of the socket to the program.
        process: whether the worker runs in a separate process.
    """

    def __init__(self, block: Block, link: socket.socket, *, process: bool) -> None:
        self._block = block
        self._config: WorkerConfig = block.config
        options = block.config.options
        self._endpoint = Endpoint(block.config.host, block.config.port, options.connect_timeout)
        self._timeout = options.timeout
        self._permit = StreamPermit(block.control, block.config.stall_limit, options.away_limit)
        self._link = link
        self._link.setblocking(False)
        self._readable = readiness(link)
        self._looked = self._reported = 0
        #: the processor time of a worker that took SCHED_FIFO by itself
        self._share: ProcessorShare | None = None
        self._told: object = None
        self._driver: Driver | None = None
        self._terminated = False
        self._process = process
        self._parent = os.getppid()
        #: whether the outcome of a set-point that was sent is unknown
        self._unanswered = False

    def run(self) -> None:
        """Run to the end of the stream. The outcome, errors included, is written into the block."""
        block, own = self._block, self._own_connection()
        reason, text = Reason.NONE, ""
        block.status[StatusWord.UNMET] = prepare(self._config.options)
        block.status[StatusWord.PRIORITY] = realtime_priority()
        try:
            leave, ending = self._config.sent.leave, self._config.sent.ending
            way_out.prepare((*way_out.STANDSTILL, *(call[0] for call in leave), ending))
            self._driver = self._make_driver(own.ready())
            block.status[StatusWord.READY] = 1
            self._wake_program()
            self._loop(self._driver, own)
        except ControllerError as exc:
            reason, text = Reason.REFUSED, str(exc)
        except DucoError as exc:
            reason, text = Reason.CONNECTION, str(exc)
            self._unanswered = isinstance(exc, OutcomeUnknown)
        except Exception:
            # The program must see an internal error of the worker, so it is reported, not raised.
            reason, text = Reason.FAILED, traceback.format_exc()[-900:]
        if self._driver is not None:
            life = self._driver.life
            life.end(reason or life.reason, text or life.text)
            reason, text = life.reason, life.text
            with contextlib.suppress(DucoError, OSError):
                self._driver.publish()
                reason, text = self._paused(own, reason) or (reason, text)
        try:
            self._end_on_controller(own, reason)
            if reason is Reason.CLOSED:
                ended_by, why = self._ended_early(own)
                if ended_by:
                    reason, text = ended_by, why
                    self._end_on_controller(own, reason)
            if reason is Reason.REFUSED and block.status[StatusWord.REASON] != reason:
                text += self._explanation(own)  # it has not been published yet
        except (DucoError, OSError) as exc:
            text = f"{text}; and it is not known that the arm stands: {exc}".strip("; ")
            block.status[StatusWord.UNSTOPPED] = 1
            if reason in (Reason.CLOSED, Reason.ABORTED):
                reason = Reason.FAILED
        finally:
            own.close()
            block.text = text
            block.status[StatusWord.MEMORY] = _memory()
            block.status[StatusWord.REASON] = reason
            block.status[StatusWord.STATE] = StreamState.ENDED
            self._wake_program()
            self._link.close()

    def terminate(self) -> None:
        """Come to rest and end; called by a signal handler."""
        self._terminated = True

    def _own_connection(self) -> OwnConnection:
        return OwnConnection(self._endpoint, keeps_overdue=True, waiting=self._permit.look)

    def _make_driver(self, connection: Connection) -> Driver:
        kinds: dict[str, type[CallDriver | RealtimeQueueDriver | TrackPoolDriver | ProbeDriver]] = {
            "call": CallDriver,
            "queue": RealtimeQueueDriver,
            "pool": TrackPoolDriver,
            "probe": ProbeDriver,
        }
        return kinds[self._config.sent.kind](connection, self._block, self._permit)

    def _end_on_controller(self, own: OwnConnection, reason: Reason) -> None:
        """End the stream's mode or motion on the controller's side, too."""
        status, sent = self._block.status, self._config.sent
        if self._unanswered:
            self._wait_out(own.connection)
        elif status[StatusWord.SENT] == 0 and not status[StatusWord.MODE]:
            return
        # Of a program that died, nobody stops the arm for certain.
        halted = reason is Reason.STOPPED and not self._gone()
        lost = self._permit.reason not in (Reason.NONE, Reason.STOPPED)
        calls = [] if halted else [tuple(call) for call in sent.leave]
        if status[StatusWord.MODE]:
            calls.append((sent.ending,))
        if reason in _STOPS or lost or (reason is Reason.STOPPED and not halted):
            calls.append(("stop", True))
        error: DucoError | None = None
        pool = sent.kind == "pool"  # if its end is refused, its points are still there
        for name, *args in calls:
            connection = own.ready()
            try:
                answer = connection.call(name, tuple(args), self._timeout)
            except DucoError as exc:
                error = exc  # the next call is still tried
                continue
            if name == sent.ending and answer >= 0 and not (pool and refused(answer)):
                status[StatusWord.MODE] = 0
        if sent.kind == "queue" and isinstance(error, ControllerError | None):
            # whoever starts the mode again would begin with what is left; so if its end is refused
            with contextlib.suppress(DucoError):
                own.call("clear_realtime_data_queue", (), self._timeout)
        if error is not None:
            raise error
        if not halted:
            self._wait_for_standstill(own)

    def _paused(self, own: OwnConnection, reason: Reason) -> tuple[Reason, str] | None:
        """Why a speed that its program has closed does not end well; None if nothing says so.

        Asked before the call that ends a speed, since that may end a pause, and leave no trace.
        """
        sent = self._block.status[StatusWord.SENT]
        if reason is not Reason.CLOSED or not sent or not self._config.sent.leave:
            return None
        found = disabled(own.call("get_robot_state", (), self._timeout))
        return found if found[0] else None

    def _ended_early(self, own: OwnConnection) -> tuple[Reason, str]:
        """Why the arm that stands is not at the last set-point; NONE if nothing says so."""
        sent = self._block.status[StatusWord.SENT]
        if not sent or self._config.sent.leave:  # how a call ends a task, the manual does not say
            return Reason.NONE, ""
        task = 0 if self._driver is None else self._driver.task
        if task > 0:
            state = own.call("get_noneblock_taskstate", (task,), self._timeout)
            if state == TaskState.INTERRUPT:  # not by the next set-point: there is none
                return Reason.STOPPED, f"task {task} was interrupted by another program"
            reason, text = ended(task, state)
            if reason or state == TaskState.FINISHED:
                return reason, text
        elif not self._config.options.watch:
            return Reason.NONE, ""
        return disabled(own.call("get_robot_state", (), self._timeout))

    def _explanation(self, own: OwnConnection) -> str:
        """What the controller reports, for messages: a collision, and the newest of its errors.

        Set-points that are refused may have added more to the list of errors than it holds.
        """
        found = ""
        with contextlib.suppress(DucoError):  # it is only an explanation
            status = own.call("getRobotStatus", (), self._timeout)
            if status.collision:
                found = f"; a collision was detected at joint {status.collisionAxis}"
        with contextlib.suppress(DucoError):
            errors = own.call("get_last_error", (), self._timeout)
            if errors:
                found += f"; the newest on its error list: {errors[-1]}"
        return found

    def _wait_out(self, lost: Connection) -> None:
        """Stop the arm until the unanswered set-point cannot move it any more."""
        status, now = self._block.status, time.monotonic()
        answer_by = now + self._config.unanswered_timeout
        status[StatusWord.UNANSWERED] = 1
        self._wake_program()
        motion = UnansweredMotion(now, answer_by, answer_by + _STAND_LIMIT)
        own = self._own_connection()
        try:
            if not bring_to_rest(motion, own, self._timeout, self._alive, lost):
                raise StopUnconfirmed(
                    "a set-point was sent, and it is not known what became of it: the arm may "
                    "be moving, or begin to. Press the emergency stop"
                )
        finally:
            own.close()
            lost.close()
        status[StatusWord.UNANSWERED] = 0

    def _wait_for_standstill(self, own: OwnConnection) -> None:
        """Wait until the arm stands still: a controller smooths set-points, so the arm lags."""
        now = time.monotonic()
        motion = UnansweredMotion.none(now, now + _STAND_LIMIT, stops=False)
        if not bring_to_rest(motion, own, self._timeout, self._alive):
            own.call("stop", (True,), self._timeout)
            raise StopUnconfirmed("it was not seen to stand long after the end, and told to stop")

    def _alive(self) -> None:
        self._block.status[StatusWord.BEAT] = time.monotonic_ns()

    def _loop(self, driver: Driver, own: OwnConnection) -> None:
        block, config = self._block, self._config
        clock = time.monotonic_ns
        spin = int(config.options.spin * 1e9)
        lateness = block.histograms["lateness"].record
        interval = block.histograms["interval"].record
        work = block.histograms["work"].record
        status = block.status
        schedule = Schedule(int(config.period * 1e9), clock())
        before = now = clock()
        self._permit.begin()
        late = min(schedule.period // 4, _LATE)
        may_go_first = self._process and config.options.priority is None
        while True:
            due = schedule.due
            asleep = now < due
            now = sleep_until(due, spin)
            # the system woke it late; its own work did not delay it
            if may_go_first and asleep and now - due > late:
                may_go_first = False
                self._raise_priority()
            lateness(now - due)
            interval(now - before)
            before = now
            try:
                self._permit.require(due)
                self._apply_commands(driver, now)
                more = driver.tick(now + _ANSWER >= due + schedule.period)
            except PermitEnded:
                driver.end(self._permit.reason, self._permit.text)
                more = False
            status[StatusWord.TICKS] += 1
            status[StatusWord.BEAT] = now
            if driver.life.reason is Reason.REFUSED and not more and own.idle:
                # before it is published: a program may read it before the arm has been stopped
                driver.life.text += self._explanation(own)
            self._publish(driver, now)
            if not more:
                return
            now = clock()
            work(now - before)
            # Before the next tick is chosen: a time in which this one stood still counts.
            self._permit.look()
            # A skipped tick is late by the time since it was due. If it did not count, a worker
            # that stood still would have good percentiles.
            for missed in range(schedule.advance(now)):
                lateness(now - due - (missed + 1) * schedule.period)
            status[StatusWord.MISSED] = schedule.missed

    def _raise_priority(self) -> None:
        """Run before all threads without a priority, as long as ticks are short and mostly wait."""
        status = self._block.status

        def given_back() -> None:
            status[StatusWord.PRIORITY] = 0

        if boost_main_thread(_LONGEST, given_back):
            status[StatusWord.PRIORITY] = realtime_priority()
            self._share = ProcessorShare(time.monotonic_ns(), time.thread_time_ns())

    def _apply_commands(self, driver: Driver, now: int) -> None:
        """Apply the program's commands, and check whether the program is alive."""
        control = self._block.control
        if control[ControlWord.ABORT]:
            driver.brake(Reason.ABORTED)
        elif control[ControlWord.CLOSE]:
            driver.life.close()
        if now - self._looked < _LOOK:
            return
        self._looked = now
        if self._share is not None and self._share.exceeded(now, time.thread_time_ns):
            # Much work with short waits: a program on the same processor would hardly run.
            self._share = None
            drop_realtime_priority()
            self._block.status[StatusWord.PRIORITY] = 0
        if self._terminated:
            driver.brake(Reason.FAILED, "the worker's process was told to end by a signal")
        if self._gone():
            dead = self._process and os.getppid() != self._parent
            # If a guard stops the robot at once, more set-points would only start it again.
            end = driver.end if dead and self._config.guarded else driver.brake
            end(Reason.PROGRAM_DIED)

    def _gone(self) -> bool:
        """Whether the program has ended: its end of the socket is closed, or its process exited.

        A child that the program forked keeps the socket open, so the socket alone does not tell.
        """
        if self._process and os.getppid() != self._parent:
            return True
        if not self._readable(0.0):
            return False
        try:
            return not self._link.recv(64)
        except BlockingIOError:
            return False
        except OSError:
            return True

    def _publish(self, driver: Driver, now: int) -> None:
        block = self._block
        told = (driver.state, driver.life.reason)
        if told != self._told:
            self._told = told
            driver.publish()
            # the state last: a program that sees the end reads the reason, and with it the text
            block.text = driver.life.text
            block.status[StatusWord.REASON] = driver.life.reason
            block.status[StatusWord.STATE] = driver.state
            self._wake_program()
        elif now - self._reported >= _REPORT:
            self._reported = now
            driver.publish()
        below = block.control[ControlWord.WAKE_BELOW]
        if below and block.ring.level <= below:
            self._wake_program()

    def _wake_program(self) -> None:
        """Wake the program, which then reads the block."""
        with contextlib.suppress(OSError):
            self._link.send(b"\1")


def prepare(options: WorkerOptions) -> Unmet:
    """Request timer slack, time slice, processors and priority for the calling thread.

    Returns:
        The requests that the system did not allow.
    """
    unmet = Unmet(0)
    if not sharpen_sleep(threading.get_native_id()):
        unmet |= Unmet.TIMER_SLACK
    if not shorten_slice(_SLICE):
        unmet |= Unmet.SLICE
    if options.cpus and not set_affinity(options.cpus):
        unmet |= Unmet.CPUS
    if options.priority and not set_realtime_priority(options.priority):
        unmet |= Unmet.PRIORITY
    return unmet


def _memory() -> int:
    """The peak size of this process so far [kB]; 0 if the system does not report it."""
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
    except OSError:
        return 0
    return next((int(line.split()[1]) for line in lines if line.startswith("VmHWM")), 0)


def run_in_thread(block: Block, link: socket.socket) -> None:
    """Run a worker in the calling thread until it ends."""
    StreamWorker(block, link, process=False).run()


def main(arguments: list[str]) -> int:
    """Run a worker in this process.

    Args:
        arguments: the handle of the socket to the program, and that of the shared block.
    """
    # Ctrl-C reaches every process of a terminal; the program decides when the stream ends.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    link, memory = arguments
    block = Block.open(int(memory) if memory.isdecimal() else memory)
    worker = StreamWorker(block, handed_socket(link), process=True)
    for number in ending_signals():
        signal.signal(number, lambda *_: worker.terminate())
    # Imported objects are never garbage: exclude them from every collection from here on.
    gc.collect()
    gc.freeze()
    worker.run()
    return 0
