"""Results of the checks of a controller."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """Result of a check."""

    #: the same as the simulated controller
    SAME = "same"
    #: not the same: the ledger of the simulator's behaviours must be corrected
    DIFFERENT = "different"
    #: the check was not tried, or the behaviour could not be observed
    OPEN = "open"


@dataclass(frozen=True, slots=True)
class CheckResult:
    """One check.

    Attributes:
        section: heading in the ledger of the simulator's behaviours, docs/fidelity.md.
        name: what is checked.
        expected: what the simulated controller does.
        found: what this one did, or why the check was not tried.
        verdict: result of the comparison.
        took: duration of the check [s].
    """

    section: str
    name: str
    expected: str
    found: str
    verdict: Verdict
    took: float


@dataclass(frozen=True, slots=True)
class ControllerReport:
    """All checks of a controller.

    Attributes:
        address: host and port.
        version: version that the controller reports.
        moved: whether the checks that move the arm were requested.
        results: each check, in order.
    """

    address: str
    version: str
    moved: bool
    results: tuple[CheckResult, ...]

    @property
    def differences(self) -> tuple[CheckResult, ...]:
        """The checks in which the controller differs from the simulated one."""
        return tuple(each for each in self.results if each.verdict is Verdict.DIFFERENT)

    @property
    def ok(self) -> bool:
        """Whether nothing differs."""
        return not self.differences

    def json(self) -> str:
        """The report as JSON."""
        return json.dumps(asdict(self), indent=2, ensure_ascii=False) + "\n"

    def markdown(self) -> str:
        """The report as a page in Markdown: the differences first, by heading of the ledger."""
        lines = [f"# {self.version or 'Controller'} at {self.address}", "", self._counts(), ""]
        for verdict, title in (
            (Verdict.DIFFERENT, "Differs from the simulated controller"),
            (Verdict.OPEN, "Open"),
            (Verdict.SAME, "The same"),
        ):
            found = [each for each in self.results if each.verdict is verdict]
            if found:
                table = [("ledger", "what", "simulated", "here"), ("---",) * 4, *map(_row, found)]
                rows = ["| " + " | ".join(map(_cell, row)) + " |" for row in table]
                lines += [f"## {title}", "", *rows, ""]
        return "\n".join(lines)

    def __str__(self) -> str:
        lines = [f"{self.version or 'controller'} at {self.address}"]
        for each in self.results:
            lines.append(f"{each.verdict:>9}  {each.name}")
            if each.verdict is not Verdict.SAME:
                lines.append(f"{'':>11}here: {each.found}")
                lines.append(f"{'':>11}simulated: {each.expected}")
        return "\n".join([*lines, self._counts()])

    def _counts(self) -> str:
        counts = dict.fromkeys(Verdict, 0)
        for each in self.results:
            counts[each.verdict] += 1
        return ", ".join(f"{number} {verdict}" for verdict, number in counts.items())


def _row(result: CheckResult) -> tuple[str, str, str, str]:
    return result.section, result.name, result.expected, result.found


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
