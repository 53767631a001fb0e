"""The queue of motions, looked at as a whole: where they blend, and how fast each may end.

Entries are values. A motion that comes in makes a new queue, which is taken only if the motion
that is running can still keep to it: otherwise there is no blend, and the old one stands.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from aioduco.sim.planner.blending import Blend, blend
from aioduco.sim.planner.timing import allowed, backward

if TYPE_CHECKING:
    from aioduco.sim.planner.path import Path
    from aioduco.sim.planner.segments import Segment
    from aioduco.sim.planner.timing import Limits

__all__ = ["Entry", "append"]


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """A motion in the queue, from the blend into it to the blend out of it.

    Attributes:
        key: the motion's key.
        segment: the motion.
        path: the blend into it and what is left of its own path; None when it stays where it is.
        limits: along that path.
        blend: the blend into it, which is the first part of its path.
        blends: whether it ends in a blend into the next motion.
        exit: highest (ds/dt)² at its end that the motions after it allow.
        back: highest (ds/dt)² at each node of its limits.
        axes: way of the external axes along the path; None if they stay where they are.
    """

    key: int
    segment: Segment
    path: Path | None
    limits: Limits | None
    blend: Blend | None = None
    blends: bool = False
    exit: float = -1.0
    back: tuple[float, ...] = ()
    axes: Path | None = None

    @property
    def length(self) -> float:
        """Length of its path between the blends, the blend into it included."""
        return self.path.end if self.path is not None else 0.0


def append(
    queue: tuple[Entry, ...], key: int, segment: Segment, at: float, speed: float
) -> tuple[Entry, ...]:
    """Put a motion at the end of the queue, and blend the last one into it where that can be.

    Args:
        queue: the queue, the running motion first.
        key: of the new motion.
        segment: the new motion.
        at: distance along the path of the running motion.
        speed: highest ds/dt there by the law that it follows.

    Returns:
        The new queue.
    """
    axes = segment.axes.path if segment.axes is not None else None
    new = Entry(key, segment, segment.path, segment.limits, axes=axes)
    corner = blend(queue[-1].segment, segment) if queue else None
    if corner is not None:
        joined = _settle((*queue[:-1], _leave(queue[-1], corner), _enter(new, corner)))
        running = joined[0]
        if running.path is None or running.limits is None:
            return joined
        if at < running.path.end and speed * speed <= allowed(running.limits, running.back, at):
            return joined
    return _settle((*queue, new))


def _leave(entry: Entry, corner: Blend) -> Entry:
    assert entry.path is not None
    assert entry.limits is not None
    end = corner.leave + (entry.blend.enter if entry.blend is not None else 0.0)
    return replace(
        entry,
        path=entry.path.slice(0.0, end),
        limits=entry.limits.slice(0.0, end),
        blends=True,
        exit=-1.0,
        axes=entry.axes.slice(0.0, end) if entry.axes is not None else None,
    )


def _enter(entry: Entry, corner: Blend) -> Entry:
    assert entry.path is not None
    assert entry.limits is not None
    axes = entry.axes
    if axes is not None and corner.axes is not None:
        axes = corner.axes.then(axes.slice(corner.enter, axes.end))
    return replace(
        entry,
        path=corner.path.then(entry.path.slice(corner.enter, entry.path.end)),
        limits=corner.limits.then(entry.limits.slice(corner.enter, entry.path.end)),
        blend=corner,
        axes=axes,
    )


def _settle(queue: tuple[Entry, ...]) -> tuple[Entry, ...]:
    """Carry from the last motion to the first how fast each may end."""
    settled = list(queue)
    exit_ = 0.0
    for i in range(len(queue) - 1, -1, -1):
        entry = queue[i]
        if entry.exit == exit_:
            break  # nothing changed for this one, nor for those before it
        if entry.limits is None:
            settled[i] = replace(entry, exit=exit_)
            exit_ = 0.0
            continue
        back = tuple(backward(entry.limits, exit_))
        settled[i] = replace(entry, exit=exit_, back=back)
        exit_ = back[0] / entry.blend.ratio**2 if entry.blend is not None else 0.0
    return tuple(settled)
