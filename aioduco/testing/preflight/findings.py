"""Find the problems that a run shows, from its recorded data. Pure."""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence


#: every kind of finding
KINDS = (
    *("unreachable", "joint limit", "singularity", "envelope", "collision", "self-collision"),
    *("collision of the tool", "wrong mode", "full queue", "starved stream", "bad blend"),
    *("unknown tool", "endless wait", "forgotten await", "motion after a stop"),
    *("blocked event loop", "failed task", "refused", "error", "not reached"),
)

#: for each kind, a pattern of its error texts: the controller's errors have no codes
_SAYS: tuple[tuple[str, str], ...] = (
    ("collision", r"检测到碰撞|position deviation"),
    ("envelope", r"beyond the envelope|lead back from|its envelope"),
    ("starved stream", r"no data for|StreamStarved|starved"),
    ("full queue", r"queue of motions is full|TrackPoolFull|no room"),
    ("unknown tool", r"there is no (tool|work object)|no tool "),
    ("singularity", r"singular"),
    ("joint limit", r"\blimits?\b|SetPointTooFar|joints_list|joint \d"),
    ("unreachable", r"reach"),
    ("bad blend", r"blend|\bradius\b"),
    ("wrong mode", r"not enabled|in state|safety stop|is stopping|\bmode\b|is running|under way"),
)
#: names of stops on the wire, and of calls that show that the program wants to move again
_STOPS = ("stop", "abort")
_AGAIN = ("enable", "power_on", "reset_collision", "resume")
#: beginnings of the names of motions, and of streams, on the wire
_MOTIONS = ("move", "tcp_move", "wobj_move", "spline")
_STREAMS = ("servo", "speed")
#: states of a task that failed
FAILED = ("ERROR", "ILLEGAL", "PARAMETER_MISMATCH")
#: time after a collision within which it explains a failed task [s]
_SOON = 0.5


@dataclass(frozen=True, slots=True)
class PreflightFinding:
    """One problem of a program.

    Attributes:
        kind: one of `KINDS`.
        text: description.
        time: the program's time since its start [s].
        file: path of the program's file; empty if the line is not known.
        line: number of the line, from 1; 0 if it is not known.
        function: name of the function with the line.
        caller: file and line from which that function was called; empty if unknown.
        sample: number of the sample that shows it, for a picture; -1 for none.
    """

    kind: str
    text: str
    time: float
    file: str = ""
    line: int = 0
    function: str = ""
    caller: str = ""
    sample: int = -1

    def __str__(self) -> str:
        where = f"{self.file}:{self.line}: " if self.line else ""
        called = f" (called from {self.caller})" if self.caller else ""
        return f"{where}{self.kind}: {self.text}{called}"

    def as_json(self) -> dict[str, Any]:
        """The finding as values for JSON."""
        return asdict(self)


def findings(
    run: Mapping[str, Any],
    *,
    allowed: Sequence[str] = (),
    more: Iterable[PreflightFinding] = (),
) -> tuple[PreflightFinding, ...]:
    """Find the problems of a run.

    Args:
        run: recorded data from the child process.
        allowed: names of bodies that the arm may touch.
        more: further findings.

    Returns:
        The findings, in the order of time: one for each kind and line, which says how many others
        there are, as of the motions of a loop.
    """
    contacts = tuple(_contacts(run, allowed))
    touched = [one.time for one in contacts]
    found = [
        *contacts, *_failures(run, touched), *_blends(run), *_after_stops(run),
        *_notes(run, touched), *more,
    ]  # fmt: skip
    found.sort(key=lambda one: one.time)
    seen: dict[tuple[str, int, str, str], PreflightFinding] = {}
    texts: dict[tuple[str, int, str, str], set[str]] = {}
    for one in found:
        key = (one.kind, one.line, one.file if one.line else one.text, one.caller)
        seen.setdefault(key, one)
        texts.setdefault(key, set()).add(one.text)
    return tuple(
        one if (others := len(texts[key]) - 1) == 0
        else replace(one, text=f"{one.text}; and {others} more of this line")
        for key, one in seen.items()
    )  # fmt: skip


def end_of(call: Mapping[str, Any]) -> str:
    """How a motion ended. The controller calls one that blended into the next interrupted."""
    if call["impossible"] or call["replaced"]:
        return "not possible" if call["impossible"] else "not tried"
    end = call["state"].lower()
    if call["state"] == "INTERRUPT":
        end = "blended" if call["radius"] > 0.0 else "interrupted"
    slowed = call["slowed"]
    return end if slowed == 1.0 else f"{end}, slowed by the envelope to {slowed:.0%}".lstrip(", ")


def running(calls: Sequence[Mapping[str, Any]], time: float) -> Mapping[str, Any] | None:
    """The program's call whose task ran at a time, or was the last one before it."""
    of_tasks = [call for call in calls if call["where"] and 0.0 <= call["started"] <= time]
    return max(of_tasks, key=lambda call: call["started"], default=None)


def _made(
    kind: str, text: str, time: float, where: Mapping[str, Any] | None, sample: int = -1
) -> PreflightFinding:
    return PreflightFinding(kind, text, time, **(where or {}), sample=sample)


def _kind(text: str, otherwise: str) -> str:
    return next((kind for kind, says in _SAYS if re.search(says, text)), otherwise)


def _contacts(run: Mapping[str, Any], allowed: Sequence[str]) -> Iterator[PreflightFinding]:
    for contact in run["contacts"]:
        one, other = contact["pair"]
        if contact["meant"] or one in allowed or other in allowed:
            continue
        call = running(run["calls"], contact["time"])
        if (
            other.startswith("link")
            or other in ("base", "the flange")
            or (one.startswith("link") and other == "the tool")
        ):
            kind = "self-collision"
        else:
            kind = "collision of the tool" if one == "the tool" else "collision"
        text = f"{one} touches {other}"
        yield _made(kind, text, contact["time"], call and call["where"], contact["sample"])


def _failures(run: Mapping[str, Any], touched: Sequence[float]) -> Iterator[PreflightFinding]:
    for call in run["calls"]:
        if call["impossible"] and call["where"]:
            kind = _kind(call["impossible"], "failed task")
            yield _made(kind, f"{call['text']}: {call['impossible']}", call["begin"], call["where"])
        if call["where"] is None or call["state"] not in FAILED:
            continue
        kind = _kind(call["message"], "failed task")
        if kind == "collision" and _soon(touched, call["ended"]):
            continue
        # the cause of a starved stream is the line at which the program is meanwhile
        where = (kind == "starved stream" and call["meanwhile"]) or call["where"]
        yield _made(kind, f"{call['text']}: {call['message']}", call["ended"], where)


def _soon(touched: Sequence[float], time: float) -> bool:
    """Whether a contact that is a finding explains a failure at a time."""
    return any(0.0 <= time - each < _SOON for each in touched)


def _blends(run: Mapping[str, Any]) -> Iterator[PreflightFinding]:
    motions = [call for call in run["calls"] if call["started"] >= 0.0 and call["where"]]
    for call, after in pairwise(motions):
        both = all(each["name"].startswith(_MOTIONS) for each in (call, after))
        if call["replaced"] or after["replaced"]:
            continue
        if both and call["radius"] > 0.0 and call["state"] == "FINISHED":
            text = (
                f"{call['text']} has a blend radius, but the arm stopped: the next motion came "
                "too late"
            )
            yield _made("bad blend", text, call["ended"], call["where"])


def _after_stops(run: Mapping[str, Any]) -> Iterator[PreflightFinding]:
    stop: Mapping[str, Any] | None = None
    told: set[int] = set()
    for call in run["calls"]:
        if call["where"] is None:
            continue
        if call["name"] in _STOPS:
            stop = call
            told = {call["actor"]} | {
                each["actor"] for each in run["calls"]
                if each["state"] == "STOPPED" and each["begin"] <= call["begin"] <= each["ended"]
            }  # fmt: skip
        elif call["name"] in _AGAIN:
            stop = None
        elif stop and call["started"] >= 0.0 and call["name"].startswith((*_MOTIONS, *_STREAMS)):
            if call["actor"] not in told:
                line = stop["where"]["line"]
                text = f"{call['text']} moves the arm again, which line {line} has stopped"
                yield _made("motion after a stop", text, call["begin"], call["where"])
            stop = None


def _notes(run: Mapping[str, Any], touched: Sequence[float]) -> Iterator[PreflightFinding]:
    for note in run["notes"]:
        kind = note["kind"]
        if kind == "error":
            if _explained(run, note, touched):
                continue
            kind = _kind(note["text"], "refused" if note["error"] == "Refused" else "error")
        yield _made(kind, note["text"], note["time"], note["where"])


def _explained(run: Mapping[str, Any], note: Mapping[str, Any], touched: Sequence[float]) -> bool:
    """Whether the error belongs to a task that is already a finding."""
    return any(
        call["task"] is not None
        and call["task"] == note.get("task")
        and (call["state"] in FAILED or _soon(touched, call["ended"]))
        and call["where"]
        for call in run["calls"]
    )
