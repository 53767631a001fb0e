"""The functions of the wire that stop an arm and leave it, made before they are needed.

A function is made when it is first used, which needs memory. Stopping often comes first when a
program fails, and it may fail because there is no memory left. So everything that opens a robot, a
guard or a stream also makes what its end needs, and loads thriftpy2, which some answers need.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from aioduco._wire import idl

if TYPE_CHECKING:
    from collections.abc import Iterable


#: functions that bring an arm to rest, and those that show whether it follows, moves or stands
STANDSTILL: Final = ("stop", "robotmoving", "get_noneblock_taskstate", "get_robot_state")
#: functions that a robot's supervision calls until its arm stands, and those that end modes and
#: held motions
WAY_OUT: Final = (
    *STANDSTILL,
    *("abort", "pause", "resume", "rpc_heartbeat", "get_last_error", "get_actual_joints_position"),
    *("end_teach_mode", "speed_stop", "stop_manual_move", "fc_stop"),
    *("end_realtime_mode", "clear_realtime_data_queue"),
)
#: what empties the queue of a mode after the call that ends it, which is carried out or refused:
#: who starts the mode again would begin with what is left. Before it, the arm would miss points
EMPTIES: Final = {"end_realtime_mode": "clear_realtime_data_queue"}


def prepare(names: Iterable[str]) -> None:
    """Make functions of the wire.

    Args:
        names: the functions; an empty name stands for none.
    """
    import aioduco._wire.thrift  # noqa: PLC0415, F401 - not with this module: see there

    functions = idl.functions()
    for name in names:
        if name:
            _ = functions[name]
