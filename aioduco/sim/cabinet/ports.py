"""RS-485 and CAN ports, and the devices that are connected to them (manual 1.3.6)."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Sequence


_BUFFER = 4096  # bytes, or frames, that wait to be read; if more come, the oldest are lost
_LAST_CAN_ID = 0x1FFFFFFF
_CAN_DATA = 8


class SerialPeer(Protocol):
    """A device at an RS-485 port."""

    def receive(self, data: bytes, /) -> bytes | None:
        """Return the device's answer to bytes that were written to the bus."""
        ...


class CanPeer(Protocol):
    """A device at the CAN bus."""

    def receive(self, id: int, data: bytes, /) -> Sequence[tuple[int, bytes]]:  # noqa: A002 - CAN's name
        """Return the frames, identifier and data, with which the device answers one frame."""
        ...


class SerialPort:
    """An RS-485 port: bytes that come in stay in a buffer until they are read.

    Attributes:
        peer: the connected device.
        baudrate: bits per second; it has no effect, since peers have no timing.
        delay: time from a write until the peer's answer can be read [s]; 0.10 to 0.15 s have been
            seen on a tool's port of a real arm.
    """

    def __init__(self, baudrate: int = 115_200) -> None:
        self.peer: SerialPeer | None = None
        self.baudrate: int = baudrate
        self.delay: float = 0.0
        self._buffer = bytearray()
        self._coming: deque[tuple[float, bytes]] = deque()

    def arrive(self, data: bytes) -> None:
        """Receive bytes that a device sends on its own."""
        self._buffer += data
        del self._buffer[:-_BUFFER]

    def write(self, data: bytes, time: float = 0.0) -> bool:
        """Send bytes at a time [s]; return whether there were any."""
        if not data:
            return False
        answer = None if self.peer is None else self.peer.receive(data)
        if answer:
            self._coming.append((time + self.delay, answer))
            self.advance(time)
        return True

    def advance(self, time: float) -> None:
        """Move what has arrived by a time [s] into the buffer."""
        while self._coming and self._coming[0][0] <= time:
            self.arrive(self._coming.popleft()[1])

    def restart(self) -> None:
        """Begin a run: answers that were on their way in the one before do not come."""
        self._coming.clear()

    def read(self, length: int | None = None) -> bytes:
        """Take up to `length` bytes from the buffer; None for all."""
        if length is not None and length <= 0:
            return b""
        return self._take(len(self._buffer) if length is None else length)

    def read_framed(self, head: bytes, length: int) -> bytes:
        """Take a frame of `length` bytes, including its head; empty until it is complete."""
        start = self._buffer.find(head)
        if not head or start < 0 or length < len(head) or len(self._buffer) < start + length:
            return b""
        self._take(start)
        return self._take(length)

    def read_between(self, head: bytes, tail: bytes) -> bytes:
        """Take a frame from its head to its tail, including both; empty until it is complete."""
        start = self._buffer.find(head)
        if not head or not tail or start < 0:
            return b""
        end = self._buffer.find(tail, start + len(head))
        if end < 0:
            return b""
        self._take(start)
        return self._take(end - start + len(tail))

    def _take(self, length: int) -> bytes:
        taken = bytes(self._buffer[:length])
        del self._buffer[:length]
        return taken


class CanPort:
    """The CAN bus: received frames wait until they are read.

    Attributes:
        peer: the connected device.
        bitrate: bits per second; it has no effect.
    """

    def __init__(self, bitrate: int = 500_000) -> None:
        self.peer: CanPeer | None = None
        self.bitrate = bitrate
        self._frames: deque[tuple[int, bytes]] = deque(maxlen=_BUFFER)

    def arrive(self, id: int, data: bytes) -> None:  # noqa: A002 - CAN's name
        """Receive a frame.

        Raises:
            ValueError: It is not a CAN frame.
        """
        if not _is_frame(id, data):
            raise ValueError(f"no CAN frame: identifier {id}, {len(data)} bytes")
        self._frames.append((id, data))

    def write(self, id: int, data: bytes) -> bool:  # noqa: A002 - CAN's name
        """Send a frame; False if it is not a CAN frame, or if no device acknowledges it."""
        if self.peer is None or not _is_frame(id, data):
            return False
        for frame in self.peer.receive(id, data):
            self.arrive(*frame)
        return True

    def read(self) -> tuple[int, bytes] | None:
        """Take the oldest frame; None if there is none."""
        return self._frames.popleft() if self._frames else None


def _is_frame(id: int, data: bytes) -> bool:  # noqa: A002 - CAN's name
    return 0 <= id <= _LAST_CAN_ID and len(data) <= _CAN_DATA
