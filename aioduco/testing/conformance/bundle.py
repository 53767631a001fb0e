"""The report of a controller as one file to send: without secrets, names and numbers of devices.

Nothing of the computer's files, environment or network is collected. What the report and the
controller say is searched, too, since a controller's texts may contain anything.
"""

from __future__ import annotations

import dataclasses
import getpass
import importlib.metadata
import ipaddress
import json
import os
import platform
import re
import zipfile
from typing import TYPE_CHECKING, Any, Final

from aioduco import __version__
from aioduco.kinematics import models
from aioduco.models.address import parse_address

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from re import Match

    from aioduco.testing.conformance.controller_report import ControllerReport


_README: Final = """\
A report of `aioduco check --bundle`. It contains:
  report.md, report.json  what was checked, what the controller did, what the simulated one does
  controller.json         its software, the type of its arm, its states and errors
  computer.json           the system, Python, and versions of packages
Addresses, names of hosts, users and folders, tokens, keys and numbers of devices were replaced by
words in angle brackets{ids}. Read it before you send it.
"""
#: packages whose versions matter to the project
_PACKAGES: Final = ("anyio", "mujoco-core", "mujoco", "numpy", "ruckig", "thriftpy2", "typer")
_SERIAL: Final = "<serial number>"

_KEY_BLOCK = re.compile(r"-----BEGIN [^-]+-----.*?(?:-----END [^-]+-----|\Z)", re.DOTALL)
_NAMED = re.compile(
    r"(?i)\b(bearer\s+|(?:[\w-]*(?:token|passw\w*|passphrase|secret|credential\w*|api[_-]?key|"
    r"authorization|cookie)|key|pwd|pass|user(?:name)?|login|account)[\"']?\s*[=:]\s*)"
    r"(?:bearer\s+)?(\"[^\"]*\"|'[^']*'|[^\s,;]+)"
)
_IN_URL = re.compile(r"(?<=://)[^\s/@]+@")
_MAIL = re.compile(r"[\w.+-]+@[\w-]+(?:\.[\w-]+)*")
_HOME = re.compile(r"(?i)((?:/home/|/users/))[^\s/\\\"']+")
_WINDOWS_HOME = re.compile(r"(?i)([a-z]:\\+users\\+)[^/\\\"'\r\n]+")  # names with blanks, too
_WEB_TOKEN = re.compile(r"\beyJ[\w-]+(?:\.[\w-]*){1,4}")
_NUMBERED = re.compile(
    r"(?i)\b((?:s/?n|serial(?:[ _-]?(?:number|no\.?))?)[\s:=#\"']+)(?=[\w-]*\d)[\w-]+"
)
_MAC = re.compile(r"\b(?:[0-9A-Fa-f]{2}[:-]){5}[0-9A-Fa-f]{2}\b")
_IPV4 = re.compile(r"(?<![A-Za-z\d.])(?:\d{1,3}\.){3}\d{1,3}(?!\.?\d)")
_IPV6 = re.compile(r"(?<![\w:])[0-9A-Fa-f:]*:[0-9A-Fa-f:]*:[0-9A-Fa-f:.]*(?![\w:])")
_WORD = re.compile(r"(?<![\w.])[A-Za-z0-9][A-Za-z0-9_+/=-]{6,}(?![\w]|\.\d)")
_DIGITS = re.compile(r"(?<![\w.])\d{8,}(?![\w.]*\d)")


class Redaction:
    """Replaces what must not be sent.

    Args:
        known: words to replace, each with what stands in its place.
        ids: keep numbers that may be those of a device.
    """

    def __init__(self, known: Iterable[tuple[str, str]] = (), *, ids: bool = False) -> None:
        longest_first = sorted(known, key=lambda pair: -len(pair[0]))
        self._known = [
            # with the domain behind the name of a computer
            (
                re.compile(rf"(?<!\w){re.escape(word)}(?:\.[a-z][\w-]*)*(?!\w)", re.IGNORECASE),
                instead,
            )
            for word, instead in longest_first
            if len(word) > 1
        ]
        self._ids = ids
        self._arms = {re.sub(r"[^a-z0-9]", "", name) for name in models()}

    def text(self, text: str) -> str:
        """A text without what must not be sent."""
        for pattern, instead in self._known:
            text = pattern.sub(instead, text)
        text = _KEY_BLOCK.sub("<key>", text)
        text = _WEB_TOKEN.sub("<secret>", text)
        text = _NAMED.sub(r"\1<secret>", text)
        text = _IN_URL.sub("<user>@", text)
        text = _MAIL.sub("<mail>", text)
        text = _HOME.sub(r"\1<user>", text)
        text = _WINDOWS_HOME.sub(r"\1<user>", text)
        text = _MAC.sub("<mac>", text)
        text = _IPV4.sub("<address>", text)
        text = _IPV6.sub(_address, text)
        if not self._ids:
            text = _NUMBERED.sub(rf"\1{_SERIAL}", text)
        text = _WORD.sub(self._word, text)
        return text if self._ids else _DIGITS.sub(_SERIAL, text)

    def value(self, value: Any) -> Any:
        """A value in the types of JSON, with all its texts treated so."""
        if isinstance(value, str):
            return self.text(value)
        if isinstance(value, dict):
            return {self.text(str(key)): self.value(each) for key, each in value.items()}
        if isinstance(value, list | tuple):
            return [self.value(each) for each in value]
        return value

    def _word(self, found: Match[str]) -> str:
        """A word with many digits: the number of a device, or, if it is long, a key."""
        word = found[0]
        bare = re.sub(r"[^a-z0-9]", "", word.lower())
        digits = sum(each.isdigit() for each in word)
        letters = sum(each.isalpha() for each in word)
        if bare in self._arms or not letters:
            return word
        if len(word) >= 20 and (digits >= 2 or len(word) >= 32) and "_" not in word.strip("_"):
            return "<secret>"
        if len(word) >= 20 and digits >= 4:
            return "<secret>"
        return _SERIAL if digits >= 4 and not self._ids else word


def _address(found: Match[str]) -> str:
    try:
        ipaddress.IPv6Address(found[0].rstrip("."))
    except ValueError:
        return found[0]
    return "<address>"


def write_bundle(
    path: str | os.PathLike[str],
    report: ControllerReport,
    controller: Mapping[str, Any],
    *,
    ids: bool = False,
) -> None:
    """Write a report and what belongs to it as one ZIP file.

    Args:
        path: the file; an existing one is replaced.
        report: the report.
        controller: what the controller says of itself, in the types of JSON. `host`, `port`, `name`
            and, unless asked for, `serial_number` are left out.
        ids: keep the numbers of devices.

    Raises:
        OSError: it cannot be written.
    """
    redaction = Redaction(_known(report, controller, ids=ids), ids=ids)
    left_out = {"host", "port", "name", *(() if ids else ("serial_number",))}
    told = {key: each for key, each in controller.items() if key not in left_out}
    shown = dataclasses.replace(
        report,
        address="<controller>",
        version=redaction.text(report.version),
        results=tuple(
            dataclasses.replace(each, found=redaction.text(each.found)) for each in report.results
        ),
    )
    files = {
        "README.txt": _README.format(ids=", but for the numbers of devices" if ids else ""),
        "report.md": shown.markdown(),
        "report.json": shown.json(),
        "controller.json": _json(redaction.value(told)),
        "computer.json": _json(redaction.value(_computer())),
    }
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as bundle:
        for name, text in files.items():
            bundle.writestr(zipfile.ZipInfo(name), text)  # without the times of this computer


def _known(
    report: ControllerReport, controller: Mapping[str, Any], *, ids: bool
) -> list[tuple[str, str]]:
    """What is known not to be for others."""
    host, _ = parse_address(report.address)
    found = [(host, "<controller>"), (platform.node(), "<computer>"), *_users()]
    found.append((str(controller.get("host", "")), "<controller>"))
    found.append((str(controller.get("name", "")), "<robot>"))
    if not ids:
        found.append((str(controller.get("serial_number", "")), _SERIAL))
    return found


def _users() -> list[tuple[str, str]]:
    try:
        user = getpass.getuser()
    except (OSError, KeyError):  # an unknown user id
        user = ""
    return [(os.path.expanduser("~"), "<home>"), (user, "<user>")]  # noqa: PTH111 - as a text


def _computer() -> dict[str, Any]:
    versions = {}
    for name in _PACKAGES:
        try:
            versions[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
    return {
        "aioduco": __version__,
        "python": platform.python_version(),
        "system": platform.system(),
        "release": platform.release(),
        "machine": platform.machine(),
        "processors": os.cpu_count(),
        "packages": versions,
    }


def _json(value: Any) -> str:
    return json.dumps(value, indent=2, ensure_ascii=False) + "\n"
