"""The vendor's service functions, whose data are not public: refused, never made up."""

from __future__ import annotations

__all__ = ["NOT_PUBLIC"]

_PASSWORD = "the password and what it is for"
_DRIVES = "the drives' parameters"

#: by function, what of it is not public
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
