"""The report as one HTML page, without scripts and external resources."""

from __future__ import annotations

import base64
import io
from html import escape
from importlib import resources
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.errors import RenderError
from aioduco.kinematics import arm as arm_of
from aioduco.sim.scene import mounting_of
from aioduco.sim.view.camera import towards
from aioduco.sim.view.render import PictureProcess
from aioduco.testing.preflight.findings import FAILED, end_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from aioduco.testing.preflight.runner import PreflightReport


_WIDTH, _LEFT, _ROW = 960, 210, 22
#: largest number of pictures on a page, and their size [pixels]
_PICTURES, _SIZE = 8, (480, 360)
_COLOURS = ("#0b6e99", "#c2571a", "#3a8f3a", "#8a3fa0", "#b8860b", "#555555")


def page(report: PreflightReport) -> str:
    """The page of a report, with the arm at each finding: without OpenGL it says why not."""
    found = len(report.findings)
    verdict = (
        '<b class="ok">Nothing was found.</b>' if report.ok
        else f'<b class="bad">{found} {"finding" if found == 1 else "findings"}.</b>'
    )  # fmt: skip
    tried = (
        f"{report.duration:.1f} s of the program on a {report.cell['model']}, "
        f"tried in {report.took:.1f} s."
    )
    command = " ".join([report.program, *report.arguments])
    sections = [
        f"<h1>Preflight of <code>{escape(command)}</code></h1>",
        f"<p>{verdict} {tried}{_seed(report)}</p>",
        _findings(report),
        _pictures(report),
        "<h2>Timeline</h2>", _timeline(report),
        "<h2>Joint speeds, share of the limit</h2>", _speeds(report),
        "<h2>Smallest margins</h2>",
        _table(
            ("from", "which", "margin", "time [s]", "line"),
            ((m.of, m.what, _amount(m.value, m.unit), f"{m.time:.2f}", _at(m.file, m.line))
             for m in report.margins),
        ),
        "<h2>Motions and commands</h2>",
        _table(
            ("line", "call", "start [s]", "duration [s]", "end"),
            ((_at(c["where"]["file"], c["where"]["line"]), c["text"], f"{c['begin']:.2f}",
              f"{c['ended'] - c['started']:.2f}" if c["ended"] >= 0 else "", _end(c))
             for c in report.motions),
        ),
        "<h2>Contacts</h2>",
        _table(
            ("what", "from [s]", "to [s]", ""),
            ((" touches ".join(c["pair"]), f"{c['time']:.2f}", f"{c['end']:.2f}",
              "under force control" if c["meant"] else "") for c in report.contacts),
        ),
        "<h2>Inputs and outputs</h2>",
        _table(
            ("signal", "time [s]", "state"),
            ((c["signal"], f"{c['time']:.2f}", "on" if c["value"] else "off") for c in report.io),
        ),
    ]  # fmt: skip
    text = resources.files("aioduco.testing.preflight").joinpath("page.html").read_text("utf-8")
    title = escape(f"Preflight of {Path(report.program).name}")
    return Template(text).substitute(title=title, body="".join(sections))


def _seed(report: PreflightReport) -> str:
    return f" Seed {report.variation['seed']}." if any(list(report.variation.values())[1:]) else ""


def _findings(report: PreflightReport) -> str:
    if report.ok:
        return ""
    return "<h2>Findings</h2>" + _table(
        ("line", "kind", "what", "time [s]"),
        ((_at(f.file, f.line), f.kind, f.text, f"{f.time:.2f}") for f in report.findings),
    )


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows]
    if not lines:
        return "<p>None.</p>"
    head = "".join(f"<th>{escape(each)}</th>" for each in heads)
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    return f'<div class="wide"><table><tr>{head}</tr>{body}</table></div>'


def _at(file: str, line: int) -> str:
    return f"{Path(file).name}:{line}" if line else ""


def _amount(value: float, unit: str) -> str:
    return f"{value:.3f} {unit}" if unit else f"{value:.0%}"


def _end(call: dict[str, Any]) -> str:
    return f"{end_of(call)} {call['impossible'] or call['message']}".strip() or call["error"]


def _timeline(report: PreflightReport) -> str:
    """Bars of motions, steps of outputs, marks of findings, over the program's time."""
    motions = [call for call in report.motions if call["started"] >= 0.0]
    names = [*dict.fromkeys((call["where"]["line"], call["name"]) for call in motions)][:30]
    signals = [*dict.fromkeys(change["signal"] for change in report.io)]
    scale = _scale(report)
    parts = []
    for row, (line, name) in enumerate(names):
        parts.append(_label(row, f"line {line}  {name}"))
        for call in motions:
            if (call["where"]["line"], call["name"]) == (line, name):
                end = call["ended"] if call["ended"] >= 0.0 else report.duration
                wrong = call["state"] in FAILED or call["impossible"]
                colour = "#b3261e" if wrong else _COLOURS[0]
                parts.append(_bar(scale, row, call["started"], end, colour))
    for row, signal in enumerate(signals, len(names)):
        parts.append(_label(row, signal))
        changes = [change for change in report.io if change["signal"] == signal]
        ends = [change["time"] for change in changes[1:]] + [report.duration]
        parts += [
            _bar(scale, row, change["time"], end, _COLOURS[2])
            for change, end in zip(changes, ends, strict=True) if change["value"]
        ]  # fmt: skip
    height = (len(names) + len(signals)) * _ROW + 8
    for finding in report.findings:
        x = scale(finding.time)
        parts.append(
            f'<line x1="{x:.1f}" x2="{x:.1f}" y1="0" y2="{height}" stroke="#b3261e" '
            f'stroke-dasharray="3 3"><title>{escape(str(finding))}</title></line>'
        )
    return _svg(parts, height, report)


def _speeds(report: PreflightReport) -> str:
    times, speeds = report.samples["time"], np.abs(report.samples["qd"])
    if not len(times):
        return "<p>The arm did not move.</p>"
    shares = speeds / np.array(arm_of(report.cell["model"]).velocity)
    scale, height = _scale(report), 140
    # of each stretch the largest speed: a short motion of a long program is shown, too
    starts = np.arange(0, len(times), max(1, len(times) // 600))
    times, shares = times[starts], np.maximum.reduceat(shares, starts)
    parts = [_label(0, "100 %"), _label(5, "0 %")]
    for joint in range(6):
        points = " ".join(
            f"{scale(float(t)):.1f},{height - 6 - (height - 12) * min(float(s), 1.0):.1f}"
            for t, s in zip(times, shares[:, joint], strict=True)
        )
        parts.append(
            f'<polyline fill="none" stroke="{_COLOURS[joint]}" stroke-width="1.4" '
            f'points="{points}">'
            f"<title>joint {joint + 1}</title></polyline>"
            f'<text x="{90 + 18 * joint}" y="{height / 2}" style="fill:{_COLOURS[joint]}">'
            f"J{joint + 1}</text>"
        )
    return _svg(parts, height, report)


def _scale(report: PreflightReport) -> Any:
    width = (_WIDTH - _LEFT - 10) / max(report.duration, 1e-3)
    return lambda time: _LEFT + time * width


def _svg(parts: Sequence[str], height: float, report: PreflightReport) -> str:
    ends = (
        f'<text x="{_LEFT}" y="{height + 14}">0 s</text>'
        f'<text x="{_WIDTH - 8}" y="{height + 14}" text-anchor="end">{report.duration:.1f} s</text>'
    )
    size = f'viewBox="0 0 {_WIDTH} {height + 20}" width="100%"'
    return f'<div class="wide"><svg {size}>{"".join(parts)}{ends}</svg></div>'


def _label(row: int, text: str) -> str:
    return f'<text x="0" y="{row * _ROW + 15}">{escape(text)}</text>'


def _bar(scale: Any, row: int, begin: float, end: float, colour: str) -> str:
    wide = max(scale(end) - scale(begin), 1.5)
    return (
        f'<rect x="{scale(begin):.1f}" y="{row * _ROW + 4}" width="{wide:.1f}" height="14" rx="2" '
        f'fill="{colour}"><title>{begin:.2f} s to {end:.2f} s</title></rect>'
    )


def _pictures(report: PreflightReport) -> str:
    positions, times = report.samples["positions"], report.samples["time"]
    if not len(positions) or len(positions) != len(times):
        return ""
    shown = [
        (min(int(np.searchsorted(times, finding.time)), len(times) - 1), str(finding))
        for finding in report.findings[: _PICTURES - 1]
    ]
    shown.append((len(times) - 1, f"the end of the last motion, at {times[-1]:.2f} s"))
    world, cell = report.world(), report.cell
    arm = arm_of(cell["model"])
    mounting = mounting_of(cell.get("mounting") or "floor", arm, cell.get("pedestal") or 0.0)
    camera = towards(arm, mounting)
    studio = PictureProcess(world.drawn)
    try:
        figures = [
            f'<figure><img width="{_SIZE[0] - 20}" alt="the arm" src="data:image/png;base64,'
            f'{_png(studio.picture(positions[sample], *_SIZE, camera))}">'
            f"<figcaption>{escape(text)}</figcaption></figure>"
            for sample, text in shown
        ]
    except (RenderError, ImportError) as error:
        return f"<p>No pictures: {escape(str(error))}</p>"
    finally:
        studio.close()
    return "<h2>Pictures</h2>" + "".join(figures)


def _png(picture: Any) -> str:
    from PIL import Image  # noqa: PLC0415 - needs an extra

    file = io.BytesIO()
    Image.fromarray(picture).quantize(64).save(file, "png", optimize=True)
    return base64.b64encode(file.getvalue()).decode("ascii")
