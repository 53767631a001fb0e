"""Programs and files of the controller (脚本控制, manual 1.3.4)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.section import Section
from aioduco.models import ranges
from aioduco.models.enums import FileKind

if TYPE_CHECKING:
    from aioduco.supervision.command import MotionCommand


class Program(Section):
    """Programs and files of the controller (脚本控制, manual 1.3.4).

    A program may move the arm: take the same care as for a motion when you start one.
    """

    __slots__ = ()

    def run_program(self, name: str) -> MotionCommand:
        """Run a program that is stored on the controller (运行程序脚本).

            await robot.program.run_program("palletize")

        Cancelling its await stops the arm and all tasks. `Robot.pause` and `Robot.resume`
        act on it.

        Args:
            name: name of the program.

        Returns:
            The run of the program, not started yet. It ends when the program does.

        Raises:
            ParameterError: the name is empty.

        Manual section 1.3.4.
        """
        name_ = ranges.LONG_NAME("name", name)
        return self._motion(calls.run_program(name_, False))

    async def get_current_project(self) -> str:
        """Read the path of the project that is loaded (当前工程路径). Manual section 1.3.4."""
        return await self._rpc.get_current_project()

    async def get_files_list(self, path: str) -> dict[str, FileKind]:
        """Read the files and folders under a path of the controller (文件列表).

            path = await robot.program.get_current_project()
            files = await robot.program.get_files_list(path + "program")

        Args:
            path: path on the controller; the project's path ends with a separator.

        Returns:
            The kind of each file and folder, by its name.

        Raises:
            ParameterError: the path is no text; nothing was sent.
            Refused: the controller lists an error: there is no such folder.

        Manual section 1.3.4.
        """
        path_ = ranges.PATH("path", path)
        files = await self._read_checked(calls.get_files_list(path_), path_)
        return {name: FileKind(kind) for name, kind in files.items()}
