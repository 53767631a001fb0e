"""Connection, system and task control (manual 1.3.1 to 1.3.3)."""

from __future__ import annotations

from time import monotonic

from aioduco.sim.handlers.base import Section


class SystemHandlers(Section):
    """Power, enable, stop, pause, resume, abort, heartbeat."""

    def power_on(self, block: bool) -> int:
        """机器人上电."""
        return self._task("power_on", block, lambda c: c.change_power("power_on"))

    def power_off(self, block: bool) -> int:
        """机器人下电."""
        return self._task("power_off", block, lambda c: c.change_power("power_off"))

    def enable(self, block: bool) -> int:
        """机器人上使能."""
        return self._task("enable", block, lambda c: c.change_power("enable"))

    def disable(self, block: bool) -> int:
        """机器人下使能."""
        return self._task("disable", block, lambda c: c.change_power("disable"))

    def shutdown(self, block: bool) -> int:
        """机器人关机."""
        return self._task("shutdown", block, lambda c: c.change_power("shutdown"))

    def restart(self, block: bool) -> int:
        """机器人重启."""
        return self._task("restart", block, lambda c: c.change_power("restart"))

    def stop(self, block: bool) -> int:
        """停止所有任务."""
        return self._task("stop", block, lambda c: c.stop())

    def pause(self, block: bool) -> int:
        """暂停所有任务."""
        return self._task("pause", block, lambda c: c.pause())

    def resume(self, block: bool) -> int:
        """恢复所有暂停的任务."""
        return self._task("resume", block, lambda c: c.resume())

    def abort(self, block: bool) -> int:
        """End the running motion and those read ahead (manual 4.3, on the 3.8 wire)."""
        return self._task("abort", block, lambda c: c.abort())

    def rpc_heartbeat(self, time: int) -> None:
        """A sign of life; the next is due within `time` milliseconds."""
        with self._runtime.command() as controller:
            controller.heartbeat.beat(monotonic(), time)
