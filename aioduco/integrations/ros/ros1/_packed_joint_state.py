"""Joint states that are packed in one call; genpy makes a format for each name, each time."""

# pyright: reportMissingImports=false
# ROS 1's messages come with the system, and have no types.

from __future__ import annotations

import functools
import struct
from typing import Any, Final

from sensor_msgs.msg import JointState

_THREE: Final = struct.Struct("<3I")
_NUMBERS: Final = struct.Struct("<I6dI6dI6d")


class PackedJointState(JointState):  # type: ignore[misc]  # genpy's have no types
    """Joint states of an arm of six joints."""

    def serialize(self, buff: Any) -> None:
        """Write the bytes of the message."""
        header = self.header
        stamp = _THREE.pack(header.seq, header.stamp.secs, header.stamp.nsecs)
        numbers = _NUMBERS.pack(6, *self.position, 6, *self.velocity, 6, *self.effort)
        buff.write(stamp + _packed(header.frame_id) + _packed_names(self.name) + numbers)


def _packed(text: str) -> bytes:
    data = text.encode()
    return len(data).to_bytes(4, "little") + data


@functools.lru_cache
def _packed_names(names: tuple[str, ...]) -> bytes:
    return len(names).to_bytes(4, "little") + b"".join(map(_packed, names))
