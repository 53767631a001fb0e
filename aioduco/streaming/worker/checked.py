"""Conversion of a stream's set-points into configurations that the envelope's checker takes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from aioduco.envelope.checker import EnvelopeChecker
from aioduco.streaming.shared.space import POSE_SPACE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco._wire.connection import Connection
    from aioduco.envelope.limits import Crossing
    from aioduco.streaming.shared.config import EnvelopeSettings, WorkerConfig
    from aioduco.streaming.shared.space import Config

__all__ = ["CheckedPath", "EnvelopeSpace"]

_STEP = 0.02  # length of one checked step between two points [m, rad]
_MOST_STEPS = 500


class EnvelopeSpace:
    """Converts set-points of a stream into configurations that an `EnvelopeChecker` takes.

    Args:
        envelope: the envelope, and the frames of the set-points.
        config: the configuration of the stream.
        connection: connection over which the arm's position is read.
        turn: orientation of the tool at the start, for steps that are not given in its frame;
            empty for others.
    """

    def __init__(
        self,
        envelope: EnvelopeSettings,
        config: WorkerConfig,
        connection: Connection,
        turn: Config = (),
    ) -> None:
        sent, timeout = config.sent, config.options.timeout
        self.checker: EnvelopeChecker = EnvelopeChecker(envelope.packed, by_tip=not sent.in_joints)
        self._in_joints = sent.in_joints
        self._base = POSE_SPACE.decode(envelope.wobj)
        self._turn = turn
        if not sent.in_joints:
            joints = connection.call("get_actual_joints_position", (), timeout)
            self.checker.seed = tuple(joints[:6])
        if sent.meaning == "step":
            name, *args = envelope.tip
            tip = POSE_SPACE.decode(connection.call(name, tuple(args), timeout))
            self._base = POSE_SPACE.composed(self._base, tip)

    def seen(self, config: Config) -> Sequence[float]:
        """A set-point as joints, or as the pose of the tool's tip in the base frame."""
        if self._in_joints:
            return config
        if self._turn:
            # convert from the axes of another frame to those of the tool
            back = POSE_SPACE.offset(self._turn, (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0))
            config = POSE_SPACE.composed(POSE_SPACE.composed(back, config), self._turn)
        x, y, z, w, a, b, c = POSE_SPACE.composed(self._base, config)
        return (
            *(1 - 2 * (b * b + c * c), 2 * (a * b - w * c), 2 * (a * c + w * b)),
            *(2 * (a * b + w * c), 1 - 2 * (a * a + c * c), 2 * (b * c - w * a)),
            *(2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b)),
            *(x, y, z),
        )


class CheckedPath:
    """Checks the straight lines between the points through which the controller plans a motion.

    Args:
        config: the configuration of a stream with an envelope.
        connection: connection over which the arm's position is read.
        start: the arm's position, as six numbers of the wire.
    """

    def __init__(
        self, config: WorkerConfig, connection: Connection, start: Sequence[float]
    ) -> None:
        assert config.envelope is not None
        self._space = config.sent.space
        self._place = EnvelopeSpace(config.envelope, config, connection)
        self._last = self._space.decode(start)
        self._seen = self._place.seen(self._last)
        self._begun = False

    def add(self, values: Sequence[float]) -> Crossing | None:
        """Take the next point, and return the limit that the line to it crosses, if any."""
        checker, space = self._place.checker, self._space
        if not self._begun:
            self._begun = True
            if found := checker.begin(self._seen):
                return found
        target = space.decode(values)
        way = space.difference(self._last, target)
        count = min(_MOST_STEPS, max(1, math.ceil(max(map(abs, way)) / _STEP)))
        for number in range(1, count + 1):
            share = number / count
            there = self._place.seen(space.moved(self._last, tuple(share * w for w in way)))
            # The controller chooses the speed here, so limits with the action "slow" do not apply.
            if found := checker.sweep(self._seen, there, 0.0):
                return found
            self._seen = there
        self._last = target
        return None
