"""Answers to arguments out of their range where they are no state of a task (manual 1.3.7)."""

from __future__ import annotations

__all__ = ["ZERO_OUT_OF_RANGE"]

#: functions of 1.3.7, whose first note says that they return 0 for an argument out of its range;
#: the last two are on the wire, not in the manual, and like their neighbours
ZERO_OUT_OF_RANGE = frozenset(
    (
        "set_digital_output_mode",
        "set_standard_digital_out",
        "set_tool_digital_out",
        "set_standard_analog_voltage_out",
        "set_standard_analog_current_out",
        "write_bool_reg",
        "write_word_reg",
        "write_float_reg",
        "set_wobj_offset",
        "set_tool_data",
        "speed",
        "set_load_data",
        "start_record_track",
        "collision_detect",
        "set_teach_speed",
        "switch_mode",
        "set_wobj",
        "set_analog_output_mode",
    )
)
