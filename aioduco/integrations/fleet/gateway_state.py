"""State of a gateway's arms, and its decisions on stops. Pure: no I/O and no clock."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from aioduco.integrations.fleet.reports import (
    ArmReport,
    ArmStopped,
    GatewayReport,
    MessageRefused,
    StopReport,
    StopRequest,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping


_WITHHELD: Final = (
    "the gateway stood still, and its heartbeat is withheld: it does not supervise the arm"
)


@dataclass(frozen=True, slots=True)
class StopOrder:
    """A stop to carry out.

    Attributes:
        gateway: name of the gateway.
        arms: names of the arms to which the stop must be sent now.
        away: the other arms that it names: no stop can be sent to them.
        note: the error in the request; empty if there was none.
    """

    gateway: str
    arms: tuple[str, ...]
    away: tuple[ArmStopped, ...]
    note: str

    def report(self, errors: Mapping[str, str]) -> StopReport:
        """The answer to it.

        Args:
            errors: for each of `arms`, why it is not confirmed that it stands; empty if it stands.
        """
        told = (*self.away, *(ArmStopped(arm, errors[arm]) for arm in self.arms))
        return StopReport(self.gateway, tuple(sorted(told, key=lambda arm: arm.name)), self.note)


class GatewayState:
    """The arms of a gateway.

    Each requested stop is sent to each connected arm that it names, also while another stop is in
    progress: a request never counts as done because of an earlier one.

    Args:
        name: name of the gateway.
        arms: names of its arms.
    """

    def __init__(self, name: str, arms: Iterable[str]) -> None:
        self.name = name
        self._arms = {arm: ArmReport(arm) for arm in arms}
        #: names of the arms to which stops can be sent
        self._connected: set[str] = set()
        #: names of the arms to which the heartbeat is withheld
        self._unsupervised: set[str] = set()
        #: when the state of each arm was read [s]
        self._read: dict[str, float] = {}
        self._reports = itertools.count(1)

    def opened(self, arm: str) -> None:
        """A robot was opened: from now on, stops can be sent to it."""
        self._connected.add(arm)
        self._unsupervised.discard(arm)
        self.connection_restored(arm)

    def closed(self, arm: str, why: str) -> None:
        """A robot was closed, or could not be opened."""
        self._connected.discard(arm)
        self.connection_lost(arm, why)

    def connection_restored(self, arm: str) -> None:
        """A controller answers."""
        self._arms[arm] = replace(self._arms[arm], link="up", error="")

    def connection_lost(self, arm: str, why: str) -> None:
        """A controller does not answer. Stops are still sent to it while its robot is open."""
        self._arms[arm] = replace(self._arms[arm], link="lost", error=why)

    def heartbeat_withheld(self, arm: str, *, withheld: bool) -> None:
        """Whether the heartbeat to a controller ended, as the gateway's own program stood still."""
        (self._unsupervised.add if withheld else self._unsupervised.discard)(arm)

    def sampled(self, arm: str, report: ArmReport, at: float) -> None:
        """The state of an arm was read.

        Args:
            arm: name of the arm.
            report: the state that was read; its link and error are ignored.
            at: time of the reading [s].
        """
        before = self._arms[arm]
        self._arms[arm] = replace(report, name=arm, link=before.link, error=before.error)
        self._read[arm] = at

    def stop(self, data: bytes) -> StopOrder:
        """Return the order for a requested stop.

        Args:
            data: the message; a message that cannot be read stops all arms.
        """
        note = ""
        try:
            request = StopRequest.decode(data)
        except MessageRefused as error:
            request, note = StopRequest(), f"all arms were stopped, since {error}"
        names = [arm for arm in self._arms if request.arms is None or arm in request.arms]
        away = tuple(
            ArmStopped(arm, f"not connected: {self._arms[arm].error or 'not yet'}")
            for arm in names
            if arm not in self._connected
        )
        tell = tuple(arm for arm in names if arm in self._connected)
        return StopOrder(self.name, tell, away, note)

    def report(self, now: float) -> GatewayReport:
        """The state of all arms.

        Args:
            now: the time, on the clock of `sampled` [s].
        """
        arms = []
        for arm in self._arms.values():
            seconds = max(0.0, now - self._read.get(arm.name, now))
            if arm.link == "up" and arm.name in self._unsupervised:
                arms.append(replace(arm, link="lost", error=_WITHHELD, seconds=seconds))
            else:
                arms.append(replace(arm, seconds=seconds))
        return GatewayReport(self.name, next(self._reports), tuple(arms))
