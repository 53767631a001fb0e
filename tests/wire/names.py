"""A name server that follows a test."""

from __future__ import annotations

import socket
import threading
from typing import Any

import pytest

from .servers import PATIENCE

__all__ = ["NAME", "Names"]

NAME = "robot.test"


class Names:
    """A name server, which may hang.

    Attributes:
        addresses: what the name stands for.
        answers: whether it answers; it hangs while it does not.
        asked: how often it was asked for the name.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self._resolve = socket.getaddrinfo
        self.addresses: list[tuple[str, int]] = []
        self.answers = threading.Event()
        self.answers.set()
        self.asked = 0
        self.threads: list[threading.Thread] = []
        monkeypatch.setattr(socket, "getaddrinfo", self._look_up)

    def _look_up(self, host: str, *args: Any, **options: Any) -> Any:
        if host != NAME:
            return self._resolve(host, *args, **options)
        if options.get("flags"):
            raise socket.gaierror(socket.EAI_NONAME, "a name")
        self.asked += 1
        self.threads.append(threading.current_thread())
        assert self.answers.wait(PATIENCE)
        if not self.addresses:
            raise socket.gaierror(socket.EAI_NONAME, "Name or service not known")
        return [(socket.AF_INET, socket.SOCK_STREAM, 6, "", each) for each in self.addresses]
