"""When samples were really taken, and what is missing between them.

A sample has the time of its reception. Its delay varies, by tens of milliseconds on a busy
computer, and an arm would shake on a path with these times. The speeds in the samples are the
controller's own: they tell the time between two samples in its cycles. A motion from rest to rest
is one chain of such times. Only the chain's place on the time axis comes from the reception.

Between two samples the arm is not known. How far it can have been from the curve through them is
bounded by the largest acceleration that the recording has elsewhere.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aioduco.recording.moving_gaps import MAX_GAP, MOVED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Array = NDArray[np.float64]


#: joint speed [rad/s], and distance of two places [rad], up to which the arm stands
STILL, SAME = 2e-3, 3e-5
#: largest share of a way that the speeds at its ends leave unexplained, in nine steps of ten
_UNEXPLAINED = 0.1
#: largest relative difference of the clocks that is a matter of delays, and no other speed
_CLOCKS = 0.1
#: time over which accelerations are computed, since speeds are rounded to 1 mrad/s [s]
_SPAN = 0.03
#: factor on the largest acceleration that is found, which lies between samples
_SURE = 1.25
#: number of gaps up to which each is told
_FEW_GAPS = 3


class RecordedGap(NamedTuple):
    """A time in which no samples of the moving arm were received.

    Attributes:
        time: when it begins, in the recording [s].
        duration: how long it is [s].
        moved: by how much the joint that turned farthest did so [rad].
        off: largest distance of a joint from the bridging curve, unless it accelerated more than in
            the rest of the recording, or turned back without need [rad]; infinite where no speeds
            are recorded.
    """

    time: float
    duration: float
    moved: float
    off: float

    def __str__(self) -> str:
        text = (
            f"{self.duration:.2f} s are missing from {self.time:.2f} s on, in which the arm moved "
            f"by {self.moved:.3f} rad"
        )
        if np.isfinite(self.off):
            text += f", known to {self.off * 1e3:.1f} mrad"
        return text


def gaps_in_words(gaps: Sequence[RecordedGap]) -> str:
    """One line about bridged gaps: each of them if they are few."""
    if len(gaps) <= _FEW_GAPS:
        return "; ".join(str(each) for each in gaps)
    longest = max(gaps, key=lambda gap: gap.duration)
    together = sum(gap.duration for gap in gaps)
    off = max(gap.off for gap in gaps)
    return (
        f"{len(gaps)} gaps of {together:.2f} s together, the longest {longest.duration:.2f} s from "
        f"{longest.time:.2f} s on; known to {off * 1e3:.1f} mrad"
    )


def is_fresh(positions: Array, velocities: Array) -> NDArray[np.bool_]:
    """Whether each sample is another one of the controller than the sample before.

    A busy controller answers twice from the same cycle. A moving arm cannot be in the same place
    twice.
    """
    same = ~np.diff(positions, axis=0).any(axis=1)
    same &= np.abs(velocities[1:]).max(axis=1) > 10 * STILL
    return np.concatenate([[True], ~same])


def steady_times(
    received: Array, positions: Array, velocities: Array
) -> tuple[Array, Array, float]:
    """Times at which samples were taken, from the speeds in them.

    Args:
        received: times of reception, rising [s]. Shape (n,).
        positions: joint angles, without samples that are not fresh [rad]. Shape (n, 6).
        velocities: joint speeds [rad/s]; NaN where they are not known. Shape (n, 6).

    Returns:
        The times [s]; the largest acceleration of each joint [rad/s²]; and the factor by which
        speeds are to be multiplied, 1 unless the controller's clock has another speed than ours. It
        is 0, and the times are those of reception, if speeds and positions do not agree.
    """
    ways, mean = np.diff(positions, axis=0), (velocities[1:] + velocities[:-1]) / 2
    square = (mean * mean).sum(axis=1)
    moving = square > (10 * STILL) ** 2
    # the time by which the arm gets from one sample to the next with the least jerk
    steps = (ways * mean).sum(axis=1) / np.where(moving, square, 1.0)
    moving &= steps > 0.0
    near = moving & (np.diff(received) < MAX_GAP)
    if not np.isfinite(velocities).all() or not moving.any():
        return received.copy(), np.full(6, np.inf), float(np.isfinite(velocities).all())
    left = np.abs(ways - mean * steps[:, None]).max(axis=1) - SAME
    share = left[near] / np.abs(ways[near]).max(axis=1)
    if not near.any() or np.quantile(share, 0.9) > _UNEXPLAINED:
        return received.copy(), np.full(6, np.inf), 0.0
    made, taken = float(steps[near].sum()), float(np.diff(received)[near].sum())
    factor = 1.0 if abs(made - taken) < _CLOCKS * taken + 0.02 else made / taken
    steps = steps / factor
    sharpest = _accelerations(steps, velocities * factor, _stretches(moving, received))
    return _placed(received, velocities * factor, steps, moving, sharpest), sharpest, factor


def gaps_between(
    received: Array, times: Array, positions: Array, velocities: Array, sharpest: Array
) -> tuple[RecordedGap, ...]:
    """The times without samples in which the arm moved.

    Args:
        received: times of reception [s]. Shape (n,).
        times: times at which the samples were taken [s]. Shape (n,).
        positions: joint angles [rad]. Shape (n, 6).
        velocities: joint speeds [rad/s]. Shape (n, 6).
        sharpest: largest acceleration of each joint in the recording [rad/s²].
    """
    ways = np.abs(np.diff(positions, axis=0)).max(axis=1)
    # the longer one: the arm may have paused, or the controller's clock may have
    lasting = np.maximum(np.diff(received), np.diff(times))
    found = []
    for at in np.flatnonzero((lasting > MAX_GAP) & (ways > MOVED)):
        duration, off = float(lasting[at]), float("inf")
        if np.isfinite(sharpest).all():
            most = np.maximum(sharpest, 1e-9)
            first, last = velocities[at], velocities[at + 1]
            # a joint that brakes or accelerates at its limit all the way has no choice of its way
            change = np.minimum(np.abs(last - first) / duration / most, 1.0)
            far = most * (1 - change**2) * duration**2 / 16
            # one that does not turn back stays between its ends, but for its way to stop
            between = np.abs(positions[at + 1] - positions[at])
            between += (first**2 + last**2) / (2 * most)
            off = float(np.minimum(far, between).max())
        found.append(RecordedGap(float(times[at]), duration, float(ways[at]), off))
    return tuple(found)


def _stretches(moving: NDArray[np.bool_], received: Array) -> list[tuple[int, int]]:
    """First and last sample of each motion, or of its part until a gap.

    Args:
        moving: whether the arm moves after each sample but the last.
        received: times of reception [s].
    """
    moving = moving & (np.diff(received) < MAX_GAP)
    edges = np.diff(np.concatenate([[0], moving.astype(int), [0]]))
    firsts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return list(zip(firsts.tolist(), ends.tolist(), strict=True))


def _accelerations(steps: Array, velocities: Array, stretches: list[tuple[int, int]]) -> Array:
    """Largest acceleration of each joint within motions, over some 30 ms [rad/s²]. Shape (6,)."""
    found = np.zeros(6)
    for first, last in stretches:
        times = np.concatenate([[0.0], np.cumsum(steps[first:last])])
        ends = np.minimum(np.searchsorted(times, times + _SPAN), last - first)
        spans = np.maximum(times[ends] - times, _SPAN)
        changes = velocities[first + ends] - velocities[first : last + 1]
        found = np.maximum(found, np.abs(changes / spans[:, None]).max(axis=0))
    return found


def _placed(
    received: Array, velocities: Array, steps: Array, moving: NDArray[np.bool_], sharpest: Array
) -> Array:
    """The times of the motions' samples, each motion as a whole, and of those between them."""
    times = received.copy()
    before: int | None = None
    pieces = _stretches(moving, received)
    for first, last in pieces:
        made = np.concatenate([[0.0], np.cumsum(steps[first:last])])
        # Samples are never early: the 25 % quantile of the offsets tells when the motion began.
        begin = float(np.quantile(received[first : last + 1] - made, 0.25))
        if before is not None:
            least, most = 0.0, np.inf
            change = np.abs(velocities[first] - velocities[before])
            if first == before + 1 and moving[before]:
                # In a gap the arm accelerates no more than elsewhere, whatever the delays say.
                middle = np.abs(velocities[first] + velocities[before]) / 2
                room = sharpest / np.maximum(middle, 1e-9) * steps[before] ** 2 / 6
                least, most = steps[before] - float(room.min()), steps[before] + float(room.min())
            else:
                # It takes its time to turn round, too.
                least = float((change / np.maximum(_SURE * sharpest, 1e-9)).max())
            begin = min(max(begin, times[before] + least), times[before] + most)
            between = slice(before + 1, first)
            times[between] = np.clip(received[between], times[before], begin)
        times[first : last + 1] = begin + made
        before = last
    first, last = pieces[0][0], pieces[-1][1]
    times[:first] = np.minimum(times[:first], times[first])
    times[last:] = np.maximum(times[last:], times[last])
    return np.maximum.accumulate(times)
