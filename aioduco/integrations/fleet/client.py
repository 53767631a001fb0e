"""Observe and stop a fleet, from any of its computers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Self

import anyio

from aioduco._process.copying import Uncopied
from aioduco._process.reporting import BackgroundLogger
from aioduco.errors import ParameterError
from aioduco.integrations.fleet.link import FleetLink
from aioduco.integrations.fleet.proof import challenge, proves, read_keys
from aioduco.integrations.fleet.reports import (
    GatewayReport,
    MessageRefused,
    StopReport,
    StopRequest,
)
from aioduco.integrations.fleet.settings import FleetSettings, settings_given
from aioduco.models.ranges import TIMEOUT

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable


_log = BackgroundLogger(__name__)

#: seconds to wait for gateways, if the settings expect none
_FOUND: Final = 1.0


@dataclass(frozen=True, slots=True)
class FleetView:
    """Known state of a fleet.

    Attributes:
        gateways: the newest report of each present gateway.
        missing: gateways that are expected but not present, or present but silent.
    """

    gateways: tuple[GatewayReport, ...]
    missing: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class FleetStop:
    """Result of a stop.

    Attributes:
        reports: the answers of the gateways. Of a gateway whose key is known, only its proven one.
            Of several gateways of one name, one report with the arms of all that have answered.
        missing: gateways that are expected, or were present, and did not answer. One that has a
            report, too, is one of several of its name, of which not all have answered.
        unproven: gateways whose answer may be of anyone, since there is no key for its proof; and
            those in whose name there was an answer without the right proof.
        unknown: requested arms that no gateway has.
    """

    reports: tuple[StopReport, ...]
    missing: tuple[str, ...]
    unknown: tuple[str, ...]
    unproven: tuple[str, ...] = ()

    @property
    def confirmed(self) -> bool:
        """Whether it is confirmed that all requested arms stand: proven by each gateway's key."""
        failed = any(arm.error for report in self.reports for arm in report.arms)
        answered = {report.gateway for report in self.reports}
        lacking = failed or self.missing or self.unknown or answered & {*self.unproven}
        return bool(self.reports) and not lacking


class FleetClient(Uncopied):
    """Observes and stops a fleet; an asynchronous context manager. It listens on no address.

    Args:
        settings: settings of the fleet. The client also connects to the addresses of `listen`, so
            that a gateway's file can be used on its own computer.

    Raises:
        FleetFileError: the file of keys is wrong, or it is no `FleetSettings`.
    """

    def __init__(self, settings: FleetSettings) -> None:
        self._settings = settings_given(settings)
        self._keys = read_keys(settings.keys) if settings.keys else {}
        self._link = FleetLink(settings, listens=False)
        self._present: set[str] = set()
        #: the newest report of each gateway, and when it came on the event loop's clock [s]
        self._reports: dict[str, tuple[float, GatewayReport]] = {}
        self._changed = anyio.Event()

    async def __aenter__(self) -> Self:
        """Connect.

        Raises:
            MissingExtra: the extra `fleet` is not installed.
            FleetFileError: an address is none, or Zenoh's own file is wrong.
            ConnectError: no router answers.
            RobotStateError: it is connected already.
        """
        await self._link.__aenter__()
        self._present.clear()  # what was seen the last time may be gone
        self._reports.clear()
        try:
            self._link.watch_gateways(self._presence_changed)
            self._link.watch_states(self._report_received)
        except BaseException:  # also a panic of Zenoh, which is no Exception
            await self._link.__aexit__(None, None, None)
            raise
        return self

    async def __aexit__(self, *exc: Any) -> None:
        await self._link.__aexit__(*exc)

    def _presence_changed(self, gateway: str, there: bool) -> None:
        if there:
            self._present.add(gateway)
        else:
            self._present.discard(gateway)
            self._reports.pop(gateway, None)
        self._wake()

    def _report_received(self, gateway: str, data: bytes) -> None:
        try:
            report = GatewayReport.decode(data)
        except MessageRefused:
            return  # counts as silent, and so as missing
        if report.gateway == gateway:
            self._reports[gateway] = anyio.current_time(), report
            self._wake()

    def _wake(self) -> None:
        changed, self._changed = self._changed, anyio.Event()
        changed.set()

    def _missing(self, found: Iterable[str]) -> tuple[str, ...]:
        return tuple(sorted((self._present | {*self._settings.expect}) - {*found}))

    async def status(self, timeout: float = 3.0) -> FleetView:
        """Wait until every gateway has reported once more, and return the state of the fleet.

        Args:
            timeout: time after which gateways without a report since the call are missing [s].

        Raises:
            ParameterError: the time is not above 0.
        """
        TIMEOUT("timeout", timeout)
        begin = anyio.current_time()
        await self._until(lambda: not self._view(begin).missing, timeout)
        return self._view(begin)

    @property
    def view(self) -> FleetView:
        """Known state of the fleet at this moment, however old: each arm has its age."""
        return self._view(-math.inf)

    def _view(self, since: float) -> FleetView:
        """The state by reports that came since then, on the event loop's clock [s]."""
        now = anyio.current_time()
        found = [
            report.older(now - came) for came, report in self._reports.values() if came >= since
        ]
        found.sort(key=lambda report: report.gateway)
        return FleetView(tuple(found), self._missing(report.gateway for report in found))

    async def stop(
        self,
        arms: Iterable[str] | None = None,
        timeout: float = 6.0,
        *,
        waiting: Callable[[FleetStop], object] | None = None,
    ) -> FleetStop:
        """Stop arms, and wait until all gateways have answered.

        Each gateway gets the request as soon as it is discovered, also during the wait.

        Args:
            arms: names of the arms, or the name of one; None for all.
            timeout: time after which gateways without an answer are missing [s]. A gateway answers
                after 5 s if one of its controllers does not answer: with the default it still says
                which arms stand.
            waiting: called with what is known by then as soon as a gateway has answered, and
                others have not; an exception of it is logged.

        Raises:
            ParameterError: the time is not above 0, or no arm is named; nothing was sent.
        """
        TIMEOUT("timeout", timeout)
        named = (arms,) if isinstance(arms, str) else arms  # its letters are no arms
        try:
            names = None if named is None else frozenset(named)
        except TypeError:
            names = frozenset()
        if names is not None and not names:  # it would be confirmed that none of them moves
            raise ParameterError("arms", named, "names of arms, or None for all of the fleet")
        request = StopRequest(names).encode()
        riddle = challenge()
        answers: dict[str, StopReport] = {}
        unproven: set[str] = set()
        asked: set[str] = set()  # of those present
        ever: set[str] = set()
        ended: set[str] = set()
        told: set[str] = set()  # to `waiting`

        def answered(gateway: str, data: bytes, proof: bytes) -> None:
            key = self._keys.get(gateway)
            proven = key is not None and proves(key, riddle, request, data, proof)
            try:
                report = StopReport.decode(data)
            except MessageRefused:
                return
            if report.gateway != gateway:
                return
            if not proven:
                unproven.add(gateway)
            if proven or key is None:
                before = answers.get(gateway)
                answers[gateway] = report if before is None else _joined(before, report)
            self._wake()

        def all_answered(gateway: str) -> None:
            ended.add(gateway)
            self._wake()

        def missing() -> set[str]:
            return {*self._missing(answers), *(ever - (answers.keys() & ended))}

        def over() -> bool:
            asked.intersection_update(self._present)  # one that comes back may be a new process
            for gateway in sorted(self._present - asked):
                asked.add(gateway)
                ever.add(gateway)
                ended.discard(gateway)
                self._link.ask_for_stop(gateway, request, riddle, timeout, answered, all_answered)
            lacking, done = missing(), answers.keys() & ended
            if waiting is not None and lacking and done - told:
                told.update(done)
                _tell(waiting, known())
            return not lacking

        def known() -> FleetStop:
            found = {arm.name for report in answers.values() for arm in report.arms}
            unknown = tuple(sorted((names or frozenset()) - found))
            reports = tuple(answers[name] for name in sorted(answers))
            lies = unproven - {name for name in answers if name in self._keys}
            return FleetStop(reports, tuple(sorted(missing())), unknown, tuple(sorted(lies)))

        await self._until(over, timeout)
        return known()

    async def _until(self, over: Callable[[], bool], timeout: float) -> None:
        begin = anyio.current_time()
        # Without expected gateways, their number is not known.
        enough = begin if self._settings.expect else begin + min(_FOUND, timeout)
        with anyio.move_on_after(timeout):
            while True:
                changed = self._changed
                done = over()
                if done and self._present and anyio.current_time() >= enough:
                    return
                limit = enough if done and self._present else begin + timeout
                with anyio.CancelScope(deadline=limit):
                    await changed.wait()


def _tell(waiting: Callable[[FleetStop], object], known: FleetStop) -> None:
    """Call what a stop calls while it waits: if it fails, later gateways are asked nevertheless."""
    try:
        waiting(known)
    except Exception:
        _log.exception("what a stop calls while it waits failed")


def _joined(one: StopReport, other: StopReport) -> StopReport:
    """Two answers in one name as one: an arm stands if none of them says that it does not."""
    arms = {arm.name: arm for arm in one.arms}
    for arm in other.arms:
        if arm.error or arm.name not in arms:
            arms[arm.name] = arm
    note = "; ".join(filter(None, (one.note, other.note)))
    return StopReport(one.gateway, tuple(arms[name] for name in sorted(arms)), note)
