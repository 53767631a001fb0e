"""Handlers of the functions of the wire in the simulated controller, a class for each section.

A handler checks the arguments of a call, then gives the controller a command or reads a snapshot.
The modules have the names of the manual's sections and of the modules of `aioduco.api`. They may
import `controller`, `cabinet`, `force`, `planner`, `physics`, `runtime` and `refusal`.

A function whose data the vendor does not publish is refused with an application error that gives
the reason. It is never answered with an invented value.
"""

from __future__ import annotations

from typing import Any, NoReturn

from aioduco._wire.rpc import Functions
from aioduco.sim.handlers.buses import BusHandlers
from aioduco.sim.handlers.compound import CompoundHandlers
from aioduco.sim.handlers.external_axes import ExternalAxisHandlers
from aioduco.sim.handlers.force import ForceHandlers
from aioduco.sim.handlers.frames import FrameHandlers
from aioduco.sim.handlers.motion import MotionHandlers
from aioduco.sim.handlers.optimization import OptimizationHandlers
from aioduco.sim.handlers.realtime import RealtimeHandlers
from aioduco.sim.handlers.servo import ServoHandlers
from aioduco.sim.handlers.settings import SettingHandlers
from aioduco.sim.handlers.signals import SignalHandlers
from aioduco.sim.handlers.state import StateHandlers
from aioduco.sim.handlers.system import SystemHandlers
from aioduco.sim.handlers.track import TrackHandlers
from aioduco.sim.handlers.velocity import VelocityHandlers
from aioduco.sim.refusal import Refusal

__all__ = ["NOT_PUBLIC", "Handlers"]

_PASSWORD = "the password and what it is for"
_DRIVES = "the drives' parameters"

#: for each function, the data that the vendor does not publish
NOT_PUBLIC = {
    "get_axis_motor_kt": "the motors' torque constants",
    "get_axis_motor_rated_current": "the motors' rated currents",
    "get_axis_ratio": "the gears' ratios",
    "get_motor_pole_pair_number": "the motors' pole pairs",
    "get_motor_stator_slots": "the motors' slots",
    "get_pos_bias": "the encoders' biases",
    "get_vibration_calibration_params": "the parameters of vibration control",
    "set_kinematic_calibration_params": "the meaning of the parameters",
    "set_kinematic_calibration_info": _PASSWORD,
    "set_dynamic_calibration_info": _PASSWORD,
    "set_vibration_calibration_info": _PASSWORD,
    "save_kinematic_calibration_params": _PASSWORD,
    "save_dynamic_calibration_params": _PASSWORD,
    "upload_robot_param_to_toolboard": _PASSWORD,
    "set_servo_config": _DRIVES,
    "set_servo_file_params": _DRIVES,
    "apply_servo_config": _DRIVES,
    "set_pendant_type": "the types of pendants",
    "change_recipe": "what a recipe is",
}


class Handlers(
    SystemHandlers,
    MotionHandlers,
    CompoundHandlers,
    ExternalAxisHandlers,
    OptimizationHandlers,
    ServoHandlers,
    RealtimeHandlers,
    TrackHandlers,
    VelocityHandlers,
    SignalHandlers,
    BusHandlers,
    ForceHandlers,
    FrameHandlers,
    StateHandlers,
    SettingHandlers,
    Functions,
):
    """Every function of the wire.

    `Functions`, which is generated, is the last base class: a call of a function that no section
    implements reaches `_call`, which refuses it.
    """

    def _call(self, name: str, args: tuple[Any, ...]) -> NoReturn:  # noqa: ARG002  # as above
        raise Refusal(f"{name} is not simulated: the vendor does not publish {NOT_PUBLIC[name]}")
