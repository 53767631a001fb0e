"""The calls and answers between any client and any controller, recorded by a relay between them."""

from __future__ import annotations

from aioduco.recording.tap.conversation import TapNote, TappedCall
from aioduco.recording.tap.tap import Tap

__all__ = ["Tap", "TapNote", "TappedCall"]
