"""Motions that came while the arm was being stopped: they wait until it stands."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.models.enums import TaskState
    from aioduco.sim.controller.motion_queue import Following
    from aioduco.sim.controller.tasks import TaskTable


class DeferredMotion(NamedTuple):
    """A motion that waits.

    Attributes:
        id: id of its task.
        name: the function that made it.
        following: how it follows its targets; None if it has a path.
        begin: queues it.
    """

    id: int
    name: str
    following: Following | None
    begin: Callable[[int], None]


class DeferredMotions:
    """The motions that wait for the end of a stop, in order.

    Args:
        tasks: the table that holds the tasks' states.

    Attributes:
        motions: all of them.
        paused: whether they pause before they begin.
    """

    def __init__(self, tasks: TaskTable) -> None:
        self._tasks = tasks
        self.motions: list[DeferredMotion] = []
        self.paused: bool = False

    def __len__(self) -> int:
        return len(self.motions)

    @property
    def last(self) -> Following | None:
        """The last one if it follows targets; None if it has a path, or if there is none."""
        return self.motions[-1].following if self.motions else None

    def add(self, motion: DeferredMotion) -> None:
        """Let a motion wait."""
        self.motions.append(motion)

    def take(self) -> list[DeferredMotion]:
        """Give all of them, which then wait no more."""
        taken, self.motions = self.motions, []
        return taken

    def end(
        self,
        state: TaskState,
        message: str,
        which: Callable[[DeferredMotion], bool] = lambda _motion: True,
    ) -> None:
        """End them before they have begun: all, or some."""
        for motion in self.take():
            if which(motion):
                self._tasks.set(motion.id, state, message)
            else:
                self.motions.append(motion)
