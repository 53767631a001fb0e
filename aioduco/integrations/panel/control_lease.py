"""Which page commands the arm, and for how long: a state machine without I/O or a clock.

Guarantees:
- At most one page commands: the page that presented the token while no other page commanded.
- The arm moves only while a button is held down. A hold is valid for `hold_limit` after the sending
  time of the newest state that the page confirmed: a page that is silent, slow or late by more ends
  the motion.
- The end of a lease ends its motion. No new lease is given until that is completed.
- A stop is never refused, and the held motion does not resume after it.
- What comes late moves nothing: a button, an action or an output is refused if the state that its
  page saw is older than `hold_limit`, as after an outage of the network.
"""

from __future__ import annotations

import enum
import hmac
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias

if TYPE_CHECKING:
    from aioduco.integrations.panel.page_requests import HoldMotion


class LeasePhase(enum.Enum):
    """State of the lease."""

    FREE = "free"
    OPENING = "opening"
    HELD = "held"
    ENDING = "ending"


@dataclass(frozen=True, slots=True)
class RefusePage:
    """Do nothing, and send the page the reason.

    Attributes:
        page: the page.
        reason: text for the page.
        wrong_token: whether the page presented a wrong token, which is logged.
    """

    page: int
    reason: str
    wrong_token: bool = False


@dataclass(frozen=True, slots=True)
class BeginLease:
    """Open a robot for commands: a page holds the lease."""

    page: int


@dataclass(frozen=True, slots=True)
class EndLease:
    """Stop the motion of the lease, and close its robot.

    Attributes:
        reason: text for the pages.
    """

    reason: str


@dataclass(frozen=True, slots=True)
class BeginMotion:
    """Start the motion of a button that is held down."""

    motion: HoldMotion


@dataclass(frozen=True, slots=True)
class EndMotion:
    """End the motion of a button.

    Attributes:
        reason: text for the pages; empty if the button was released.
    """

    reason: str = ""


LeaseEffect: TypeAlias = RefusePage | BeginLease | EndLease | BeginMotion | EndMotion

#: seconds after a wrong token for which the page's next ones are not looked at
_TOKEN_PAUSE: Final = 1.0
_NOT_YOURS = "this page does not command: take control first"


class ControlLease:
    """The lease of one panel.

    Args:
        token: secret that a page must present to command; empty if no page may command.
        hold_limit: seconds for which a hold is valid after the sending time of the newest state
            that the page confirmed.
        page_limit: seconds without a keep-alive message or a button press of its page after which a
            lease ends.

    Attributes:
        phase: state of the lease.
        holder: the page that has the lease; None for no page.
        motion: the motion of the held button, until its end is observed; None for none.
    """

    def __init__(self, token: str, *, hold_limit: float, page_limit: float) -> None:
        self._token = token.encode()
        self._hold_limit = hold_limit
        self._page_limit = page_limit
        self.phase: LeasePhase = LeasePhase.FREE
        self.holder: int | None = None
        self.motion: HoldMotion | None = None
        self._ending_motion = False
        self._heard_at = 0.0
        self._seen_at = 0.0
        self._stops = 0
        self._barred: dict[int, float] = {}

    def __repr__(self) -> str:  # never with the token
        return f"<ControlLease {self.phase.value}, page {self.holder}>"

    # -- the lease -------------------------------------------------------------------------------

    def take(self, page: int, token: str, now: float) -> LeaseEffect:
        """A page asks for the lease.

        Args:
            page: the page.
            token: the token that it presents; compared in constant time.
            now: the time [s].
        """
        if not self._token:
            return RefusePage(page, "this panel only watches")
        if now < self._barred.get(page, now):
            return RefusePage(page, "wait a second after a wrong token")
        # as bytes: `compare_digest` accepts only ASCII strings
        if not hmac.compare_digest(token.encode("utf-8", "replace"), self._token):
            self._barred[page] = now + _TOKEN_PAUSE
            return RefusePage(page, "wrong token: nothing was moved", wrong_token=True)
        if self.phase is LeasePhase.ENDING:
            return RefusePage(page, "the lease before is ending: try again when the arm stands")
        if self.phase is not LeasePhase.FREE:
            return RefusePage(page, "another page commands")
        self.phase, self.holder = LeasePhase.OPENING, page
        self._heard_at = now
        return BeginLease(page)

    def opened(self) -> None:
        """The robot of the lease is open."""
        if self.phase is LeasePhase.OPENING:
            self.phase = LeasePhase.HELD

    def gone(self, page: int) -> LeaseEffect | None:
        """A page was closed."""
        self._barred.pop(page, None)
        return self.release(page, "its page is gone")

    def release(self, page: int, reason: str = "control was given back") -> LeaseEffect | None:
        """A page gives the lease back."""
        return self._end(reason) if page == self.holder else None

    def closed(self) -> None:
        """The motion of the lease has stopped, and its robot is closed."""
        self.phase, self.holder, self.motion = LeasePhase.FREE, None, None
        self._ending_motion = False

    def lost(self, reason: str) -> LeaseEffect | None:
        """The robot of the lease has failed."""
        return self._end(reason)

    def _end(self, reason: str) -> EndLease | None:
        if self.phase in {LeasePhase.FREE, LeasePhase.ENDING}:
            return None
        self.phase = LeasePhase.ENDING
        self.holder = None
        self._ending_motion = self.motion is not None
        return EndLease(reason)

    # -- requests of its page --------------------------------------------------------------------

    def refusal(self, page: int) -> RefusePage | None:
        """Refusal for a page that may not command now; None if it may."""
        if page != self.holder:
            return RefusePage(page, _NOT_YOURS)
        if self.phase is not LeasePhase.HELD:
            return RefusePage(page, "the robot is still being opened")
        return None

    def too_old(self, page: int, seen_at: float, now: float) -> RefusePage | None:
        """Refusal for a page that acts on a state of long ago; None if that is new enough.

        Args:
            page: the page.
            seen_at: when the state that the page saw last was sent [s].
            now: the time [s].
        """
        if now - seen_at > self._hold_limit:
            return RefusePage(page, "what this page shows is too old to move by")
        return None

    def press(self, page: int, motion: HoldMotion, seen_at: float, now: float) -> LeaseEffect:
        """A page presses a button that moves the arm while it is held down.

        Args:
            page: the page.
            motion: the motion of the button.
            seen_at: when the state that the page saw last was sent [s].
            now: the time [s].
        """
        refused = self.refusal(page)
        if refused is not None:
            return refused
        if self._stops:
            return RefusePage(page, "the arm is being stopped")
        if self.motion is not None:
            return RefusePage(page, "the motion before has not ended yet")
        if (refused := self.too_old(page, seen_at, now)) is not None:
            return refused
        self.motion, self._ending_motion = motion, False
        self._heard_at, self._seen_at = now, seen_at
        return BeginMotion(motion)

    def beat(self, page: int, seen_at: float, now: float, *, down: bool) -> LeaseEffect | None:
        """A keep-alive message of a page arrives.

        Args:
            page: the page.
            seen_at: when the state that the page saw last was sent [s].
            now: the time [s].
            down: whether its button is still held down.
        """
        if page != self.holder:
            return None
        self._heard_at = now
        if not down:
            return self.button_released(page)
        self._seen_at = max(self._seen_at, seen_at)
        return None

    def button_released(self, page: int) -> LeaseEffect | None:
        """A page reports that its button was released."""
        return self._end_motion("") if page == self.holder else None

    def motion_ended(self) -> None:
        """The motion of the button has ended: the arm stands, or a stop was sent."""
        self.motion, self._ending_motion = None, False

    def _end_motion(self, reason: str) -> EndMotion | None:
        if self.motion is None or self._ending_motion:
            return None
        self._ending_motion = True
        return EndMotion(reason)

    # -- stops and time-outs ---------------------------------------------------------------------

    def stop(self) -> LeaseEffect | None:
        """A page stops the arm, with or without the lease. Nothing starts until `stop_ended`.

        Returns:
            The end of the button's motion, if there is one.
        """
        self._stops += 1
        return self._end_motion("the arm was stopped")

    def stop_ended(self) -> None:
        """A stop was completed, or failed."""
        self._stops -= 1

    def due(self, now: float) -> LeaseEffect | None:
        """Apply the time-outs.

        Args:
            now: the time [s].
        """
        if self.holder is not None and now - self._heard_at > self._page_limit:
            return self._end("its page was silent")
        if self.motion is not None and now - self._seen_at > self._hold_limit:
            return self._end_motion("its page was silent or late: hold the button again")
        return None
