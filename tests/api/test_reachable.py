"""Every function of the manual and of the wire is there, documented, with its arguments checked."""

from __future__ import annotations

import inspect
import re
import sys
from functools import cache
from typing import TYPE_CHECKING, Any

import pytest

import aioduco
from aioduco._wire import idl
from aioduco.api.section import Section
from api.cases import DATA, MANUAL, NOBODY

if TYPE_CHECKING:
    from collections.abc import Callable

#: what is on the robot itself, since it is for all of it
ON_THE_ROBOT = {"stop", "pause", "resume", "abort"}
#: what a program has no use for, and why
EXCEPTIONS = {
    "rpc_heartbeat": "sent by the robot's heartbeat while it is open; connect(heartbeat=...)",
}
#: what the manual has and the wire has not, and where it is here
ELSEWHERE = {
    "DucoCobot": aioduco.connect,
    "open": aioduco.Robot.open,
    "close": aioduco.Robot.aclose,
    "get_version": aioduco.__version__,
}
#: not written yet
_PENDING = """
    apply_servo_config cal_fkine cal_ikine change_recipe collision_detect
    collision_detection_reset disable_acc_optimization disable_singularity_control
    disable_speed_optimization disable_vibration_control enable_acc_optimization
    enable_singularity_control enable_speed_optimization enable_vibration_control fc_config
    fc_force_set_value fc_get_ft fc_guard_act fc_guard_deact fc_mode_is_active fc_move fc_start
    fc_stop fc_wait_ft fc_wait_logic fc_wait_pos fc_wait_vel get_axis_motor_kt
    get_axis_motor_rated_current get_axis_ratio get_calib_DH get_dynamic_calibration_params
    get_global_speed get_motor_pole_pair_number get_motor_stator_slots get_origin_DH
    get_pos_bias get_tcp_offset get_teach_speed get_tool_load get_vibration_calibration_params
    get_wobj log_error log_info modbus_add_signal modbus_delete_signal modbus_read
    modbus_set_frequency modbus_write modbus_write_multiple_coils modbus_write_multiple_regs
    reach_check read_encoder_count save_dynamic_calibration_params
    save_kinematic_calibration_params set_dynamic_calibration_info
    set_dynamic_calibration_params set_kinematic_calibration_info
    set_kinematic_calibration_params set_load_data set_pendant_type set_servo_config
    set_servo_file_params set_teach_pendant set_teach_speed set_tool_data
    set_vibration_calibration_info set_wobj set_wobj_offset simulation speed start_record_track
    stop_record_track upload_robot_param_to_toolboard
"""
PENDING = set(_PENDING.split())

#: says that a function, or what is said of it, is not in manual 3.8
BEYOND = re.compile(r"[Nn]ot in (the )?manual|only on the wire|on the wire alone|manual 4\.3")


@cache
def reachable() -> dict[str, Callable[..., Any]]:
    """Each public function of a section of the robot, and of the robot itself, by name."""
    found: dict[str, Callable[..., Any]] = {name: getattr(NOBODY, name) for name in ON_THE_ROBOT}
    for attribute, section in vars(NOBODY).items():
        if not isinstance(section, Section):
            continue
        assert attribute in aioduco.Robot.__annotations__
        assert f"        {attribute}: " in str(aioduco.Robot.__doc__), (
            f"{attribute} is undocumented"
        )
        for name, method in inspect.getmembers(section, callable):
            if not name.startswith("_"):
                assert name not in found, f"{name} is in two sections"
                found[name] = method
    return found


WIRE = sorted(set(idl.functions()) - set(EXCEPTIONS) - PENDING)


def test_every_function_of_the_wire_is_reachable() -> None:
    assert len(idl.functions()) == 226
    assert set(idl.functions()) - set(reachable()) - set(EXCEPTIONS) <= PENDING
    assert not set(EXCEPTIONS) & set(reachable())


def test_every_function_of_the_manual_is_reachable() -> None:
    functions = {one["name"]: one["wire"] for one in DATA["functions"]}
    assert len(functions) == 188
    for name, wire in functions.items():
        if wire is None:
            assert ELSEWHERE[name]
        else:
            assert wire in reachable() or wire in EXCEPTIONS or wire in PENDING, name


@pytest.mark.parametrize("name", WIRE)
def test_it_is_documented(name: str) -> None:
    method = reachable()[name]
    text = inspect.getdoc(method)
    assert text
    first = text.partition("\n")[0]
    assert first.rstrip(".") != first or "\n\n" in text, "the first line is a sentence, or a title"
    if (function := MANUAL.get(name)) is None:
        assert BEYOND.search(text), "where does it come from?"
    else:
        assert f"anual section {function['section']}" in text
        assert re.search("[\u4e00-\u9fff]", text), "the manual's own term helps a search"
        if function["name"] != name:
            assert function["name"] in text, "the manual's spelling helps a search"
    parameters = inspect.signature(method).parameters
    if len(parameters) > 1:
        for parameter in parameters:
            assert re.search(rf"^    \*?{parameter}: ", text, re.MULTILINE), parameter
    if "\n" in text and inspect.signature(method).return_annotation not in {"None", None}:
        assert "Returns:" in text or len(parameters) <= 1


@pytest.mark.parametrize("name", WIRE)
def test_each_parameter_is_checked(name: str) -> None:
    """Each has its name in a check; that the checks refuse what they should, other tests see."""
    method = reachable()[name]
    source = inspect.getsource(sys.modules[method.__module__])
    for parameter in inspect.signature(method).parameters:
        if parameter != "timeout":  # `Section` checks that
            alone = rf'\(\s*"{parameter}",'
            together = rf'ranges\.[a-z_]+\([^"()]*\b{parameter}\b'
            assert re.search(f"{alone}|{together}", source), parameter


@pytest.mark.parametrize("name", WIRE)
def test_there_is_no_block_and_nothing_beyond_the_first_is_positional_by_chance(name: str) -> None:
    parameters = inspect.signature(reachable()[name]).parameters
    assert "block" not in parameters
    for parameter, one in parameters.items():
        if one.default is not one.empty:
            alone = len(parameters) <= 2
            assert one.kind is one.KEYWORD_ONLY or alone, f"{parameter} has a default"
