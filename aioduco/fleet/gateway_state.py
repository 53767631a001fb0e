"""What a gateway knows of its arms and decides on stops. Pure: no I/O and no clock."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from aioduco.fleet.reports import (
    ArmReport,
    ArmStopped,
    GatewayReport,
    MessageRefused,
    StopReport,
    StopRequest,
)

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["GatewayState", "StopOrder"]


@dataclass(frozen=True, slots=True)
class StopOrder:
    """A stop that is to be carried out.

    Attributes:
        number: of this order.
        arms: names of arms that are to be told now.
    """

    number: int
    arms: tuple[str, ...]


class GatewayState:
    """The arms of a gateway, and stops that are under way.

    Guarantees:
    - Each stop that was asked for is carried out for each arm that it names and that is connected,
      also while another one is under way: it is never taken for done before.
    - Each order is answered once, when what became of each of its arms is known.

    Args:
        name: of the gateway.
        arms: names of its arms.
    """

    def __init__(self, name: str, arms: Iterable[str]) -> None:
        self.name = name
        self._arms = {arm: ArmReport(arm) for arm in arms}
        #: names of the arms that stops can be sent to
        self._connected: set[str] = set()
        #: when what is known of an arm was read [s]
        self._read: dict[str, float] = {}
        self._orders = itertools.count(1)
        self._reports = itertools.count(1)
        #: by order: its request's note, the arms that are open, and what is known of the others
        self._open: dict[int, tuple[str, set[str], list[ArmStopped]]] = {}

    def opened(self, arm: str) -> None:
        """A robot is open: stops can be sent to it from now on."""
        self._connected.add(arm)
        self.answers(arm)

    def closed(self, arm: str, why: str) -> None:
        """A robot is not open any more, or could not be opened."""
        self._connected.discard(arm)
        self.silent(arm, why)

    def answers(self, arm: str) -> None:
        """A controller answers."""
        self._arms[arm] = replace(self._arms[arm], link="up", error="")

    def silent(self, arm: str, why: str) -> None:
        """A controller does not answer. A stop is sent to it nevertheless, while it is open."""
        self._arms[arm] = replace(self._arms[arm], link="lost", error=why)

    def sampled(self, arm: str, report: ArmReport, at: float) -> None:
        """The state of an arm was read.

        Args:
            arm: its name.
            report: what was read; its link is not looked at.
            at: when [s].
        """
        before = self._arms[arm]
        self._arms[arm] = replace(report, name=arm, link=before.link, error=before.error)
        self._read[arm] = at

    def stop(self, data: bytes) -> StopOrder:
        """A stop is asked for: whom to stop. An order without arms is answered by `report_of`.

        Args:
            data: the message; one that cannot be read stops all arms.
        """
        note = ""
        try:
            request = StopRequest.decode(data)
        except MessageRefused as error:
            request, note = StopRequest(), f"all arms were stopped, since {error}"
        names = [arm for arm in self._arms if request.arms is None or arm in request.arms]
        tell = tuple(arm for arm in names if arm in self._connected)
        away = [
            ArmStopped(arm, f"not connected: {self._arms[arm].error or 'not yet'}")
            for arm in names
            if arm not in tell
        ]
        number = next(self._orders)
        self._open[number] = (note, set(tell), away)
        return StopOrder(number, tell)

    def stopped(self, order: int, arm: str, error: str = "") -> None:
        """What became of one arm of an order.

        Args:
            order: its number.
            arm: name of the arm.
            error: why it is not known that it stands; empty if it stands.
        """
        _, left, done = self._open[order]
        left.remove(arm)
        done.append(ArmStopped(arm, error))

    def report_of(self, order: int) -> StopReport | None:
        """The answer to an order, once; None while something of it is open."""
        note, left, done = self._open[order]
        if left:
            return None
        del self._open[order]
        return StopReport(self.name, tuple(sorted(done, key=lambda arm: arm.name)), note)

    def report(self, now: float) -> GatewayReport:
        """The state of all arms.

        Args:
            now: the time, on the clock of `sampled` [s].
        """
        arms = tuple(
            replace(arm, seconds=max(0.0, now - self._read.get(arm.name, now)))
            for arm in self._arms.values()
        )
        return GatewayReport(self.name, next(self._reports), arms)
