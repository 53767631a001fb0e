"""Programs and files of the controller (manual 1.3.4)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from aioduco.sim.handlers.base import Section, mismatch
from aioduco.sim.project import NoSuchFolder
from aioduco.sim.script import Steps

if TYPE_CHECKING:
    from aioduco.sim.controller import Controller


class ProgramHandlers(Section):
    """run_program, get_current_project, get_files_list."""

    def run_program(self, name: str, block: bool) -> int:
        """运行程序脚本: its calls are answered as if a client made them."""

        def make(function: str, values: tuple[Any, ...]) -> Any:
            return getattr(self, function)(*values)

        def command(controller: Controller) -> int:
            script = self._cabinet.project.programs.get(name)
            if script is None:
                raise mismatch(f"there is no program {name!r}")
            steps = Steps(
                name,
                script,
                make,
                controller.tasks,
                ahead=lambda: controller.read_ahead,
                progress=lambda: controller.progress,
            )
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
            return self._senseless("get_files_list", exc, {})
