"""Connection, power, task control, programs and log (manual 1.3.1 to 1.3.4, 1.3.8)."""

from __future__ import annotations

import logging
from time import monotonic
from typing import TYPE_CHECKING, Any

from aioduco.sim.cabinet.project import NoSuchFolder
from aioduco.sim.controller.programs import ProgramRun
from aioduco.sim.handlers.base import HandlerSection
from aioduco.sim.refusal import mismatch

if TYPE_CHECKING:
    from aioduco.sim.controller.state_machine import Controller


_log = logging.getLogger("aioduco.sim.program")


class SystemHandlers(HandlerSection):
    """power_on to rpc_heartbeat, run_program to get_files_list, log_info to robotmoving."""

    def power_on(self, block: bool) -> int:
        """机器人上电."""
        return self._task("power_on", block, lambda c: c.power.request("power_on"))

    def power_off(self, block: bool) -> int:
        """机器人下电."""
        return self._task("power_off", block, lambda c: c.power.request("power_off"))

    def enable(self, block: bool) -> int:
        """机器人上使能."""
        return self._task("enable", block, lambda c: c.power.request("enable"))

    def disable(self, block: bool) -> int:
        """机器人下使能."""
        return self._task("disable", block, lambda c: c.power.request("disable"))

    def shutdown(self, block: bool) -> int:
        """机器人关机."""
        return self._task("shutdown", block, lambda c: c.power.request("shutdown"))

    def restart(self, block: bool) -> int:
        """机器人重启."""
        return self._task("restart", block, lambda c: c.power.request("restart"))

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
        """Take a heartbeat; the next one is due within `time` milliseconds."""
        with self._runtime.command() as controller:
            late = controller.heartbeat.beat(monotonic(), time)
        # A strict simulator accepts a late heartbeat only within a slack that was set for it.
        if late and not self._forgiving.strict:
            self._forgiving.forgive("late heartbeat", f"a heartbeat came {late:.3f} s late")

    def run_program(self, name: str, block: bool) -> int:
        """运行程序脚本: its calls are answered as if a client made them."""

        def make(function: str, values: tuple[Any, ...]) -> Any:
            return getattr(self, function)(*values)

        def command(controller: Controller) -> int:
            script = self._cabinet.project.programs.get(name)
            if script is None:
                raise mismatch(f"there is no program {name!r}")
            steps = ProgramRun(name, script, make, controller.tasks)
            return controller.run_program(steps)

        return self._task("run_program", block, command)

    def get_current_project(self) -> str:
        """当前工程的路径, with a slash at its end."""
        return self._cabinet.project.path

    def get_files_list(self, path: str) -> dict[str, int]:
        """指定路径下的文件列表; 0: folder, 1: file."""
        try:
            return self._cabinet.project.list(path)
        except NoSuchFolder as exc:
            return self._invalid_arguments("get_files_list", exc, {})

    def log_info(self, message: str) -> None:
        """Write to the controller's log."""
        _log.info("%s", message)

    def log_error(self, message: str) -> None:
        """Show a message on the pendant, and pause all tasks."""
        _log.error("%s", message)
        with self._runtime.command() as controller:
            controller.note_error(message)
            controller.pause()

    def get_last_error(self) -> list[str]:
        """机器人最新的错误列表."""
        return list(self._runtime.snapshot.view.errors)

    def get_noneblock_taskstate(self, id: int) -> int:  # noqa: A002 - the name on the wire
        """State of a task."""
        return int(self._runtime.task_state(id))

    def robotmoving(self) -> bool:
        """Whether the arm moves."""
        return self._runtime.snapshot.view.moving
