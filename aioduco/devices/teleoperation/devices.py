"""Input devices as plain files of Linux: a terminal, /dev/input/js*, /dev/hidraw*."""

from __future__ import annotations

import copy
import errno
import math
import os
import select
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Protocol, Self

from aioduco._process.copying import Uncopied
from aioduco._process.platform import has_device_files, single_keys
from aioduco.devices.teleoperation.gamepad import Gamepad
from aioduco.devices.teleoperation.keyboard import Keyboard
from aioduco.devices.teleoperation.reading import HELD, STANDING, Reading
from aioduco.devices.teleoperation.spacemouse import SpaceMouse
from aioduco.errors import ParameterError

_MAKERS = {0x046D: "Logitech", 0x256F: "3Dconnexion"}  # SpaceMice have been sold by both
_MOST = 4096
#: reads at a time, and reports: a person or a device causes a few between two readings
_READS, _REPORTS = 16, 256
#: seconds between two readings from which on what came meanwhile may be long past
_UNREAD = 0.5
#: seconds after which nothing counts as held: a finite time for what came before the first reading
_LONG_PAST = HELD.high + 1.0


class _Meaning(Protocol):
    """Interprets the bytes of a device."""

    def feed(self, data: bytes, now: float) -> None: ...
    def reading(self, now: float) -> Reading: ...


class InputDevice(Uncopied):
    """An input device that is read without blocking. Use it in `with`, also several times.

    Args:
        meaning: interprets its bytes, such as `Gamepad`; each `with` begins with a copy of it.
        path: file of the device; None: an open descriptor is used.
        descriptor: the open descriptor; it stays open at the end.
        whole: whether each read returns exactly one report.
    """

    def __init__(
        self,
        meaning: _Meaning,
        path: str | Path | None = None,
        descriptor: int = -1,
        *,
        whole: bool = False,
    ) -> None:
        self._fresh = self._meaning = meaning
        self._path = path
        self._descriptor = descriptor
        self._whole = whole
        self._read_at = -math.inf

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self._path or 'of a terminal'}>"

    def __enter__(self) -> Self:
        """Open it.

        Raises:
            ParameterError: there is no such device, it may not be read, the system is not Linux, or
                it is open already.
        """
        _require_files(self._path)
        if self._path is not None:
            if self._descriptor >= 0:
                raise ParameterError("device", repr(self), "closed: it is open already")
            try:
                self._descriptor = os.open(self._path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
            except OSError as exc:
                raise ParameterError(
                    "device", str(self._path), f"a device that can be read ({exc.strerror})"
                ) from exc
        # without what the device did the last time, such as its end
        self._meaning = copy.deepcopy(self._fresh)
        self._read_at = -math.inf
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        if self._path is not None and self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1

    def read(self, now: float) -> Reading:
        """Read and interpret the bytes that the device has sent; never blocks.

        If the device is gone (unplugged, a closed terminal), the reading is not `held`, and `done`.
        If it sends more than can be read at a time (a file, a stuck key), the newest bytes are not
        known: the reading is not `held`, as if it was let go. What came before the first reading,
        or in more than 0.5 s without one, counts as of the begin of that time: a key or a cap is
        `held` only if it sends further bytes, since it may have been let go meanwhile.

        Args:
            now: time of any clock that does not go back [s].

        Raises:
            ParameterError: it is not open.
        """
        if self._descriptor < 0:
            raise ParameterError("device", repr(self), "open: use it in `with`")
        came = now
        if now - self._read_at > _UNREAD:
            came = max(self._read_at, now - _LONG_PAST)
        self._read_at = now
        waits = select.poll()  # select() takes no descriptor above 1023
        waits.register(self._descriptor, select.POLLIN)
        for _ in range(_REPORTS if self._whole else _READS):
            if not waits.poll(0):
                break
            try:
                data = os.read(self._descriptor, 64 if self._whole else _MOST)
            except BlockingIOError:
                break
            except OSError as exc:
                if exc.errno not in (errno.ENODEV, errno.EIO, errno.EBADF):
                    raise
                data = b""
            self._meaning.feed(data, came)
            if not data:
                break
        else:
            return self._meaning.reading(now)._replace(axes=STANDING, held=False)
        return self._meaning.reading(now)


def _require_files(path: str | Path | None) -> None:
    if not has_device_files():
        raise ParameterError(
            "device",
            str(path or "a descriptor"),
            "read on Linux: this system has no files of devices. Lead the arm by a program of your "
            "own, with `robot.stream`, or from a machine with Linux",
        )


class KeyboardDevice(InputDevice):
    """The keys of a terminal, or of a substitute such as a pipe.

    Args:
        descriptor: descriptor to read; None: standard input.
        keys: interprets the keys; None: with the default times.
    """

    def __init__(self, descriptor: int | None = None, keys: Keyboard | None = None) -> None:
        self._single_keys = ExitStack()
        super().__init__(keys or Keyboard(), descriptor=-1 if descriptor is None else descriptor)

    def __enter__(self) -> Self:
        """Set the terminal to return each key at once, without echo.

        Raises:
            ParameterError: there is no standard input, or the system has no terminal that can be
                read in this way.
        """
        _require_files("keyboard")
        super().__enter__()
        if self._descriptor < 0:
            self._descriptor = _standard_input()
        if os.isatty(self._descriptor):
            self._single_keys.enter_context(single_keys(self._descriptor))
        return self

    def __exit__(self, *_: object) -> None:
        """Restore the terminal's settings."""
        self._single_keys.close()


def _standard_input() -> int:
    """The descriptor of standard input; a closed one, or one in memory, has none."""
    try:
        return sys.stdin.fileno()
    except (AttributeError, OSError, ValueError) as exc:
        raise ParameterError(
            "device", "keyboard", "a terminal: there is no standard input"
        ) from exc


class GamepadDevice(InputDevice):
    """A gamepad.

    Args:
        path: file of the gamepad.
        pad: interprets its events; None: the buttons of an Xbox gamepad.
    """

    def __init__(self, path: str | Path = "/dev/input/js0", pad: Gamepad | None = None) -> None:
        super().__init__(pad or Gamepad(), path)


class SpaceMouseDevice(InputDevice):
    """A SpaceMouse.

    Args:
        path: file of the SpaceMouse; None: the first one that is found.
        mouse: interprets its reports; None: the cap is the dead-man switch.

    Raises:
        ParameterError: no SpaceMouse is found.
    """

    def __init__(self, path: str | Path | None = None, mouse: SpaceMouse | None = None) -> None:
        found = _space_mouse() if path is None else path
        super().__init__(mouse or SpaceMouse(), found, whole=True)


def _space_mouse(root: Path = Path("/sys/class/hidraw")) -> str:
    """The file of the first SpaceMouse, from the kernel's description of each HID device."""
    for found in sorted(root.glob("hidraw*")):
        try:
            lines = (found / "device" / "uevent").read_text(errors="replace").splitlines()
        except OSError:
            continue
        said = {name: value for name, _, value in (line.partition("=") for line in lines)}
        _, _, ids = said.get("HID_ID", "").partition(":")
        maker = int(ids.partition(":")[0] or "0", 16)
        name = said.get("HID_NAME", "").lower()
        if maker in _MAKERS and any(word in name for word in ("space", "3dconnexion")):
            return f"/dev/{found.name}"
    raise ParameterError("device", "spacemouse", "plugged in: none is under /sys/class/hidraw")


def open_device(kind: str, path: str | None = None) -> InputDevice:
    """Make a device of a kind; entering it opens it.

    Args:
        kind: "keyboard", "gamepad" or "spacemouse".
        path: file of the device; None: the usual one.

    Raises:
        ParameterError: there is no such kind, or no such device.
    """
    match kind:
        case "keyboard":
            return KeyboardDevice()
        case "gamepad":
            return GamepadDevice() if path is None else GamepadDevice(path)
        case "spacemouse":
            return SpaceMouseDevice(path)
    raise ParameterError("device", kind, "keyboard, gamepad or spacemouse")
