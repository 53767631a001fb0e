"""The simulated controller's status port: it sends a frame to each client ten times a second.

One thread serves all clients and waits for none: it accepts new clients before each frame, and
disconnects a client whose buffer has no room for the frame. The contents of a frame come from the
handlers, so they agree with the answers to calls.
"""

from __future__ import annotations

import contextlib
import logging
import math
import selectors
import socket
import time
from typing import TYPE_CHECKING

from aioduco.models.status_frame import FRAME_SIZE, RATE, StatusFrame
from aioduco.sim.refusal import Refusal
from aioduco.sim.server.socket_thread import SocketThread

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire import rpc


_log = logging.getLogger(__name__)

_PERIOD = 1.0 / RATE
#: approximate number of frames that may wait for a client: the system counts more than their bytes
_WAITING = 4
_MOST_CLIENTS = 64


def frame_of(robot: rpc.Functions, *, simulated: bool = False) -> StatusFrame:
    """Make a frame of a controller's answers to calls, and of whether it only simulates its arm.

    Fields that no source explains are zero: the state of the drives, the expected forces, and the
    forces at the base. Analog channels are four voltages, then four currents.
    """
    status, signals = robot.getRobotStatus(), robot.getRobotIOStatus()
    state, program, safety, mode = robot.get_robot_state()
    function_io = range(1, 9)
    return StatusFrame(
        joint_position=tuple(status.jointActualPosition),
        joint_velocity=tuple(status.jointActualVelocity),
        joint_acceleration=tuple(status.jointActualAccelera),
        joint_torque=tuple(robot.get_actual_joints_torque()),
        joint_position_expected=tuple(status.jointExpectPosition),
        joint_velocity_expected=tuple(status.jointExpectVelocity),
        joint_acceleration_expected=tuple(status.jointExpectAccelera),
        joint_torque_expected=tuple(robot.get_target_joints_torque()),
        joint_temperature=tuple(status.jointTemperature),
        joint_current=tuple(status.jointActualCurrent),
        tcp_position=tuple(status.cartActualPosition),
        tcp_velocity=tuple(status.cartActualVelocity),
        tcp_acceleration=tuple(status.cartActualAccelera),
        tcp_force=tuple(robot.get_tcp_force()) or (0.0,) * 6,
        tcp_position_expected=tuple(status.cartExpectPosition),
        tcp_velocity_expected=tuple(status.cartExpectVelocity),
        tcp_acceleration_expected=tuple(status.cartExpectAccelera),
        tool=tuple(robot.get_tcp_offset()),
        work_object=tuple(robot.get_wobj()),
        blended_speed=math.hypot(*status.cartExpectVelocity[:3]),
        global_speed=robot.get_global_speed(),
        jog_speed=robot.get_teach_speed(),
        function_digital_in=tuple(robot.get_function_digital_in(num) for num in function_io),
        function_digital_out=tuple(robot.get_function_digital_out(num) for num in function_io),
        digital_in=tuple(signals.digitalInputs),
        digital_out=tuple(signals.digitalOutputs),
        analog_in=(*signals.analogVoltageInputs, *signals.analogCurrentInputs),
        analog_out=(*signals.analogVoltageOutputs, *signals.analogCurrentOutputs),
        float_register_in=tuple(signals.floatRegisterInputs),
        float_register_out=tuple(signals.floatRegisterOutputs),
        function_bool_in=tuple(signals.funRegisterInputs),
        function_bool_out=tuple(signals.funRegisterOutputs),
        bool_register_in=tuple(signals.boolRegisterInputs),
        bool_register_out=tuple(signals.boolRegisterOutputs),
        word_register_in=tuple(word & 0xFFFF for word in signals.wordRegisterInputs),
        word_register_out=tuple(word & 0xFFFF for word in signals.wordRegisterOutputs),
        tool_digital_in=tuple(signals.toolIOIn),
        tool_digital_out=tuple(signals.toolIOOut),
        tool_analog_in=tuple(robot.get_tool_analog_voltage_in(num) for num in (1, 2)),
        tool_buttons=tuple(reversed(signals.toolButton)),  # S, then T
        mode=mode,
        robot=state,
        program=program,
        safety=safety,
        collision=status.collision,
        collision_axis=status.collisionAxis,
        error=status.robotError,
        simulated=int(simulated),
    )


class StatusServer:
    """A second listener, which pushes frames.

    Args:
        frame: makes the frame of the present instant.
        host: address to listen on.
        port: TCP port; 0 picks a free one, which the attribute `port` then gives.
    """

    def __init__(
        self, frame: Callable[[], StatusFrame], *, host: str = "127.0.0.1", port: int = 0
    ) -> None:
        self.host = host
        self.port: int = port
        self._frame = frame
        self._clients: set[socket.socket] = set()
        self._thread: SocketThread | None = None
        self._refusing = False
        self._cut = False

    @property
    def clients(self) -> int:
        """Number of connected clients."""
        return len(self._clients)

    def start(self) -> None:
        """Listen, and begin to push.

        Raises:
            OSError: The server cannot listen on the address, for instance if the port is in use.
        """
        family = socket.getaddrinfo(self.host, self.port, type=socket.SOCK_STREAM)[0][0]
        listener = socket.create_server((self.host, self.port), family=family)
        self.port = listener.getsockname()[1]
        self._thread = SocketThread("sim-status", listener, self._serve)

    def refuse(self, refusing: bool) -> None:
        """While `refusing` is set, disconnect clients at the next frame and refuse new ones."""
        self._refusing = refusing
        self._cut = self._cut or refusing  # also if the controller is back before the next frame

    def close(self) -> None:
        """Disconnect every client, and wait until the thread has ended."""
        if self._thread is not None:
            self._thread.end()
            self._thread = None

    def _serve(self, listener: socket.socket, wake: socket.socket) -> None:
        with selectors.DefaultSelector() as selector:
            selector.register(wake, selectors.EVENT_READ)
            due = time.monotonic()
            try:
                while not selector.select(max(0.0, due - time.monotonic())):
                    # The schedule is absolute; missed frames are not made up for.
                    due += _PERIOD * (1.0 + max(0.0, time.monotonic() - due) // _PERIOD)
                    while self._accept(listener):
                        pass
                    self._push()
            finally:
                for client in tuple(self._clients):
                    self._drop(client)

    def _accept(self, listener: socket.socket) -> bool:
        """Accept a client, if one waits; return whether one did."""
        try:
            client, _ = listener.accept()
        except OSError:
            return False  # no client, or no descriptor left for one
        if self._refusing or len(self._clients) >= _MOST_CLIENTS:
            client.close()
            return True
        client.setblocking(False)
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        # A small buffer is soon full, which shows that a client is slow.
        client.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _WAITING * FRAME_SIZE)
        self._clients.add(client)
        return True

    def _push(self) -> None:
        if self._cut:
            self._cut = self._refusing
            for client in tuple(self._clients):
                self._drop(client)
        if not self._clients:
            return
        try:
            data = self._frame().encode()
        except Refusal:
            return  # the simulation has ended: there is no state to send
        for client in tuple(self._clients):
            try:
                whole = client.send(data) == len(data)
            except OSError:  # the client has disconnected, or its buffer is full
                whole = False
            if not whole:
                self._drop(client)

    def _drop(self, client: socket.socket) -> None:
        self._clients.discard(client)
        with contextlib.suppress(OSError):
            client.shutdown(socket.SHUT_RDWR)
        client.close()
        _log.info("a client of the status port has gone, or was too slow")
