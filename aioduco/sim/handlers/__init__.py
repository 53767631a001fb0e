"""What the simulated controller answers: a class for each section of the manual.

Together they are every function of the wire. What none of them has is refused by an application
error with its reason, never answered by a made-up value.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn

from aioduco._wire import rpc
from aioduco.sim.handlers.cabinet import CabinetHandlers
from aioduco.sim.handlers.compound import CompoundHandlers
from aioduco.sim.handlers.curves import CurveHandlers
from aioduco.sim.handlers.external_axes import ExternalAxisHandlers
from aioduco.sim.handlers.force import ForceHandlers
from aioduco.sim.handlers.frames import FrameHandlers
from aioduco.sim.handlers.log import LogHandlers
from aioduco.sim.handlers.motion import MotionHandlers
from aioduco.sim.handlers.offsets import OffsetHandlers
from aioduco.sim.handlers.optimization import OptimizationHandlers
from aioduco.sim.handlers.realtime import RealtimeHandlers
from aioduco.sim.handlers.recording import RecordingHandlers
from aioduco.sim.handlers.service import NOT_PUBLIC
from aioduco.sim.handlers.servo import ServoHandlers
from aioduco.sim.handlers.settings import SettingHandlers
from aioduco.sim.handlers.state import StateHandlers
from aioduco.sim.handlers.system import SystemHandlers
from aioduco.sim.handlers.track import TrackHandlers
from aioduco.sim.handlers.velocity import VelocityHandlers
from aioduco.sim.refusal import Refusal

if TYPE_CHECKING:
    from aioduco.sim.handlers.base import Context

__all__ = ["Handlers"]


def _refused(name: str, _args: tuple[Any, ...]) -> NoReturn:
    raise Refusal(f"{name} is not simulated: the vendor does not publish {NOT_PUBLIC[name]}")


class Handlers(
    SystemHandlers,
    MotionHandlers,
    OffsetHandlers,
    CurveHandlers,
    CompoundHandlers,
    ExternalAxisHandlers,
    OptimizationHandlers,
    ServoHandlers,
    RealtimeHandlers,
    TrackHandlers,
    RecordingHandlers,
    VelocityHandlers,
    CabinetHandlers,
    ForceHandlers,
    FrameHandlers,
    StateHandlers,
    SettingHandlers,
    LogHandlers,
    rpc.RpcClient,
):
    """Every function of the wire.

    The generated client stands at the end of the line: it has a method for each function, whose
    every call here ends in a refusal.
    """

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        rpc.RpcClient.__init__(self, _refused)


def handlers(context: Context) -> rpc.Handler:
    """The handlers, as what a server wants: this line is the proof that none is missing."""
    return Handlers(context)
