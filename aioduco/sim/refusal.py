"""How a handler refuses a call whose result has no room for a refusal."""

from __future__ import annotations


class Refusal(Exception):
    """The call is answered with a Thrift application error that carries this text."""
