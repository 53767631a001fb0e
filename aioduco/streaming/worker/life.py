"""The state of a stream, and why it ends. Pure.

WAITING     nothing has been sent yet.
FOLLOWING   the program sends, and the arm follows.
HOLDING     the program is late, and the arm waits for it.
DECELERATING  the end is decided and its reason known. The arm comes to rest.
ENDED       nothing more is sent.

The state never goes back from DECELERATING or ENDED, and the first reason and its text stay. But of
a stream that its program has closed, what ends it before the arm is at its end is the reason.
"""

from __future__ import annotations

from aioduco.streaming.shared.words import Reason, StreamState


class Life:
    """State of a stream, and the reason for its end.

    Attributes:
        state: state of the stream.
        reason: why it ends; NONE before.
        text: more about the reason; empty if there is nothing to add.
        closing: whether the program sends no more.
    """

    def __init__(self) -> None:
        self.state: StreamState = StreamState.WAITING
        self.reason: Reason = Reason.NONE
        self.text: str = ""
        self.closing: bool = False

    def following(self) -> None:
        """Note that the arm follows."""
        self.state = StreamState.FOLLOWING

    def holding(self) -> None:
        """Note that the program is late, and the arm waits for it."""
        self.state = StreamState.HOLDING

    def ended(self) -> None:
        """Note that the arm has come to rest, as was decided."""
        self.state = StreamState.ENDED

    def close(self) -> None:
        """Follow all that was sent, then end: the program sends no more."""
        self.closing = True

    def brake(self, reason: Reason, text: str = "") -> bool:
        """Come to rest at once, then end.

        Returns:
            Whether the arm must be brought to rest now, for this reason.
        """
        if self.state is StreamState.WAITING:
            self.end(reason, text)
        if self.state >= StreamState.DECELERATING:
            return False
        self.state, self.reason, self.text = StreamState.DECELERATING, reason, text
        return True

    def end(self, reason: Reason, text: str = "") -> None:
        """Send nothing more: the arm is stopped by another caller, or cannot be reached."""
        self.state = StreamState.ENDED
        if self.reason in (Reason.NONE, Reason.CLOSED):
            self.reason, self.text = reason, text
