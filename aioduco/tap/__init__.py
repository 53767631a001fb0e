"""What any client and any controller say to each other, seen from between them."""

from __future__ import annotations

from aioduco.tap.conversation import TapNote, TappedCall
from aioduco.tap.tap import Tap

__all__ = ["Tap", "TapNote", "TappedCall"]
