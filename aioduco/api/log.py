"""Messages to the people at the robot (调试相关, manual 1.3.8)."""

from __future__ import annotations

from aioduco.api.section import Section
from aioduco.models import ranges


class Log(Section):
    """The controller's log and its pendant (调试相关, manual 1.3.8)."""

    __slots__ = ()

    async def log_info(self, message: str) -> None:
        """Write a message into the controller's log (插入 log 日志).

        Args:
            message: its text.

        Raises:
            ParameterError: it is no text; nothing was sent.

        Manual section 1.3.8.
        """
        await self._rpc.log_info(ranges.TEXT("message", message))

    async def log_error(self, message: str) -> None:
        """Show a message on the pendant, and pause all tasks (产生弹窗, 并暂停当前所有任务).

        Motions of this program pause as well; `Robot.resume` resumes them.

        Args:
            message: its text.

        Raises:
            ParameterError: it is no text; nothing was sent.

        Manual section 1.3.8.
        """
        await self._rpc.log_error(ranges.TEXT("message", message))
