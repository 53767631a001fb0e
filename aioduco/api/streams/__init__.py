"""What makes streams: units and ranges of `robot.servo` and `.speed`, `.realtime` and `.track`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._process.copying import Uncopied
from aioduco.models.host_port import host_port
from aioduco.models.names import ManualNames

if TYPE_CHECKING:
    from aioduco.streaming.endpoint import StreamEndpoint

__all__ = ["StreamMaker"]


class StreamMaker(Uncopied, ManualNames):
    """Base of what has functions that make streams.

    Args:
        endpoint: the controller.
    """

    def __init__(self, endpoint: StreamEndpoint) -> None:
        self._endpoint = endpoint

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {host_port(self._endpoint.host, self._endpoint.port)}>"
