"""The datagrams that controllers send on UDP port 2011 when they are asked to.

Source: one public program, which calls it a high-frequency recipe port. It sends a word, and takes
datagrams of 24 or 48 bytes: six floats of force, or these and six of the tool's pose. The order of
the bytes, the units and the frames are assumptions: those of the status port and of the wire.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from typing import Final

from aioduco.errors import ProtocolError
from aioduco.models.pose import Pose

FORCE_PORT: Final = 2011
#: the datagram that asks for the stream
FORCE_REQUEST: Final = b"start_force_stream"

_FORCE, _BOTH = struct.Struct("<6f"), struct.Struct("<12f")


@dataclass(frozen=True, slots=True)
class ForceSample:
    """One datagram of the force stream.

    Attributes:
        force: force and torque at the tool [N, N m].
        tcp: pose of the tool in the base frame [m, rad]; None if the controller sends none.
    """

    force: tuple[float, ...]
    tcp: Pose | None = None

    def encode(self) -> bytes:
        """Return the bytes of the datagram."""
        if self.tcp is None:
            return _FORCE.pack(*self.force)
        return _BOTH.pack(*self.force, *self.tcp)

    @classmethod
    def decode(cls, data: bytes) -> ForceSample:
        """Read a datagram.

        Args:
            data: its bytes.

        Raises:
            ProtocolError: it has another length than 24 or 48 bytes, or a pose that is not finite.
        """
        if len(data) == _FORCE.size:
            return cls(_FORCE.unpack(data))
        if len(data) == _BOTH.size:
            numbers = _BOTH.unpack(data)
            if not all(map(math.isfinite, numbers[6:])):
                raise ProtocolError(f"the force port sent a pose that is not finite: {numbers[6:]}")
            return cls(numbers[:6], Pose(*numbers[6:]))
        raise ProtocolError(
            f"the force port sent {len(data)} bytes, and 24 or 48 are known: nothing was read"
        )
