"""From the ring of the program's set-points to those of the wire, within the limits."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from aioduco.streaming.rates import Rates
from aioduco.streaming.shared import Status
from aioduco.streaming.source import Source
from aioduco.streaming.space import POSE_SPACE
from aioduco.streaming.upsample import Follower

if TYPE_CHECKING:
    from aioduco._wire.connection import Connection
    from aioduco.streaming.ring import SetPoint
    from aioduco.streaming.shared import Block
    from aioduco.streaming.space import Config

__all__ = ["Feed"]


class Feed:
    """Set-points from the shared ring through limits: what servo, speed and realtime share.

    Args:
        connection: the lane's connection, open.
        block: the shared block.
    """

    def __init__(self, connection: Connection, block: Block) -> None:
        config = block.config
        self._config = config
        self._connection = connection
        self._block = block
        self._space = config.sent.space
        self._meaning = config.sent.meaning
        self._before = POSE_SPACE.decode((0.0,) * 6)
        self._period = 1 / config.feeding.rate
        self.source: Source = Source(
            self._space,
            self._period,
            hold=config.feeding.hold,
            interval=config.feeding.interval,
            paced=not config.feeding.latest,
            reach=tuple(config.feeding.reach),
            rates=self._meaning == "speed",
        )
        self._follower: Follower | Rates | None = None
        self._sent: tuple[float, ...] | None = None
        self._next = block.ring.newest if config.feeding.latest else block.ring.take
        self._age = block.histograms["age"].record

    def begin(self) -> bool:
        """Find out where the arm is, once there is a first set-point.

        Returns:
            Whether the stream has begun.
        """
        if self._follower is not None:
            return True
        if not self._block.ring.level:
            return False
        limits, space = self._config.sent.limits, self._space
        if self._meaning == "speed":
            self._follower = Rates(space, limits, self._period)
        else:
            way, start = self._config.feeding.upsample, space.decode(self._actual())
            self._follower = Follower(way, space, limits, self._period, start)
        self.source.begin(self._follower)
        return True

    def _actual(self) -> list[float]:
        """Where the arm is; steps count from there, so for them that is zero."""
        if self._meaning == "step":
            return [0.0] * 6
        name, *args = self._config.sent.read
        timeout = self._config.options.timeout
        actual: list[float] = self._connection.call(name, tuple(args), timeout)
        return actual

    def step(self) -> tuple[float, ...] | None:
        """The next set-point for the controller; None when there is nothing to send."""
        config = self.source.step(self._take)
        if config is None:
            return None
        self._sent = self.values(config)
        return self._sent

    def resting(self) -> tuple[float, ...]:
        """The set-point at which the arm stays as it is; only after `begin`."""
        assert self._follower is not None
        return self.values(self._follower.config)

    def values(self, config: Config) -> tuple[float, ...]:
        """The six numbers of the wire."""
        if self._meaning == "speed":
            return config
        if self._meaning == "place":
            return self._space.encode(config)
        before, self._before = self._before, config
        return POSE_SPACE.encode(POSE_SPACE.offset(before, config))

    def _take(self) -> SetPoint | None:
        point = self._next()
        if point is not None:
            self._age(time.monotonic_ns() - point.stamp)
        return point

    def publish(self) -> None:
        """Write what the program wants to know into the shared block."""
        status, ring = self._block.status, self._block.ring
        status[Status.STARVED] = self.source.starved
        status[Status.TAKEN] = ring.read
        status[Status.OVERWRITTEN] = ring.overwritten
        if self._follower is not None:
            status[Status.LIMITED] = self._follower.limited
        if self._sent is not None:
            self._block.report.overwrite(self._sent, time.monotonic_ns())
