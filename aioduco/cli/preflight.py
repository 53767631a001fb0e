"""`aioduco preflight`: try a program on a simulated arm before the real arm moves."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from aioduco.cli import extras
from aioduco.cli.addresses import CellFile
from aioduco.cli.cell_file import RobotName, simulated_parts
from aioduco.cli.exit_codes import ended_by_errors, failing, write_file
from aioduco.cli.options import (
    MountingOption,
    Pedestal,
    SceneFile,
    ToolFile,
    mounting_option,
    refuse_unused,
    require_writable,
)

if TYPE_CHECKING:
    from aioduco.cli.safe_console import SafeConsole
    from aioduco.testing.preflight import PreflightReport, PreflightSettings


FOUND, NOT_RUN = 1, 2


def preflight(
    context: typer.Context,
    program: str,
    arguments: Annotated[list[str] | None, typer.Argument(show_default=False)] = None,
    module: Annotated[bool, typer.Option("-m")] = False,
    vendor: bool = False,
    cell: CellFile = None,
    robot: RobotName = None,
    model: str = "gcr5_910",
    scene: SceneFile = None,
    tool: ToolFile = None,
    mounting: MountingOption = "floor",
    pedestal: Pedestal = 0.0,
    allow: list[str] | None = None,
    reach: list[str] | None = None,
    patience: Annotated[float, typer.Option(min=1.0)] = 60.0,
    timeout: Annotated[float, typer.Option(min=1.0)] = 600.0,
    result: Annotated[Path | None, typer.Option("--json")] = None,
    html: Path | None = None,
    quiet: bool = False,
    vary: str = "",
    seed: Annotated[int, typer.Option(min=0)] = 0,
    runs: Annotated[int | None, typer.Option(min=1)] = None,
    workers: Annotated[int | None, typer.Option(min=1)] = None,
    scheduler: str | None = None,
) -> None:
    """Try a program on a simulated arm, and say what would go wrong. No arm moves.

    Exit status 0: nothing was found; 1: something was; 2: the program could not be tried; 130, 143
    Ctrl-C or SIGTERM.

    Args:
        program: File of the program, or its module with -m.
        arguments: Arguments of the program, after --.
        module: The program is a module.
        vendor: Provide the vendor's class DucoCobot by aioduco.compat.
        model: The arm.
        allow: Body that the arm may touch. Can be repeated.
        reach: host:port that the program may connect to. Can be repeated.
        patience: Time without a change after which the program hangs [s].
        timeout: Longest run, in real time [s].
        result: File for the result.
        html: File for a page with pictures.
        quiet: Do not show the program's output.
        vary: What to vary: start,latency,faults,payload,parts.
        seed: Seed of the variation; with --runs the first one.
        runs: Number of variations.
        workers: Processes of the local cluster. Default: one per processor.
        scheduler: Address of a Dask scheduler, such as tcp://host:8786.
    """
    if runs is None:
        refuse_unused(context, "--runs", "workers", "scheduler")
    else:
        refuse_unused(context, "one run, without --runs", "html", "quiet")
    if not vary:
        refuse_unused(context, "--vary", "seed")
    read = (Path(program), cell, scene, tool)
    require_writable("--json", result, *read)
    require_writable("--html", html, *read)
    extras.need("sim", *(("plot",) if html else ()), *(("sweep",) if runs else ()))
    extras.arm(model)
    from aioduco.cli.safe_console import SafeConsole  # noqa: PLC0415 - for this command alone
    from aioduco.errors import DucoError  # noqa: PLC0415
    from aioduco.testing.preflight import PreflightSettings  # noqa: PLC0415
    from aioduco.testing.preflight import preflight as run  # noqa: PLC0415

    console = SafeConsole()
    # A signal ends the program that is tried, and removes its files.
    with ended_by_errors(), failing(DucoError, OSError, code=NOT_RUN):
        parts = simulated_parts(
            cell,
            robot,
            model=model,
            scene=scene and str(scene.resolve()),
            tool=tool and str(tool.resolve()),
            mounting=mounting_option(mounting),
            pedestal=pedestal,
        )
        settings = PreflightSettings(
            **parts,
            vendor=vendor,
            module=module,
            allowed=tuple(allow or ()),
            reachable=tuple(reach or ()),
            patience=patience,
            timeout=timeout,
            vary=tuple(filter(None, vary.split(","))),
            seed=seed,
        )
        if runs is not None:
            failed = _sweep(
                console, program, arguments or [], settings, runs, workers, scheduler, result
            )
            raise typer.Exit(FOUND if failed else 0)
        report = run(program, arguments or [], settings, quiet=quiet)
    _show(console, report)
    if result is not None:
        write_file(result, json.dumps(report.as_json(), indent=2) + "\n")
    if html is not None:
        from aioduco.testing.preflight.html import page  # noqa: PLC0415 - it needs an extra

        write_file(html, page(report), errors="replace")
        console.print(f"page: {html}")
    raise typer.Exit(0 if report.ok else FOUND)


def _show(console: SafeConsole, report: PreflightReport) -> None:
    """Show what was found first: the table below it may be longer than the terminal."""
    from rich.table import Table  # noqa: PLC0415 - for this command alone

    from aioduco.testing.preflight.findings import end_of  # noqa: PLC0415

    for finding in report.findings:
        console.print(str(finding), style="bold red", soft_wrap=True)
    table = Table(title="what the program did", title_justify="left")
    for head in ("line", "call", "start [s]", "took [s]", "end"):
        table.add_column(head, justify="right" if "[s]" in head else "left")
    for call in report.motions:
        took = f"{call['ended'] - call['started']:.2f}" if call["ended"] >= 0.0 else ""
        table.add_row(_where(call["where"]), call["text"], f"{call['begin']:.2f}", took,
                      end_of(call))  # fmt: skip
    console.print(table)
    for margin in report.margins:
        console.print(f"smallest margin, {margin}")
    console.print(f"{report.duration:.1f} s of the program, tried in {report.took:.1f} s")
    if report.ok:
        console.print("nothing was found", style="green")
    else:
        count = len(report.findings)
        told = f"found: {count} {'problem' if count == 1 else 'problems'}, above the table"
        console.print(told, style="bold red")


def _where(place: dict[str, Any]) -> str:
    """Line of a call, and the line from which its function was called."""
    line = f"{Path(place['file']).name}:{place['line']}"
    file, _, number = place["caller"].rpartition(":")
    return f"{line}, from {Path(file).name}:{number}" if file else line


def _sweep(
    console: SafeConsole,
    program: str,
    arguments: list[str],
    settings: PreflightSettings,
    runs: int,
    workers: int | None,
    scheduler: str | None,
    result: Path | None,
) -> bool:
    """Run the variations with a progress bar; return whether any failed."""
    from rich.progress import MofNCompleteColumn, Progress, TimeElapsedColumn  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415

    from aioduco.testing.preflight.sweep import sweep  # noqa: PLC0415 - it needs an extra

    columns = (*Progress.get_default_columns(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console) as progress:
        bar = progress.add_task("variations", total=runs)

        def done(_: Any) -> None:
            progress.advance(bar)

        swept = sweep(
            program, arguments, settings, runs, workers=workers, scheduler=scheduler, done=done
        )
    if swept.failed:
        table = Table(title="variations that failed", title_justify="left")
        for head in ("seed", "line", "kind", "what"):
            table.add_column(head)
        for one in swept.failed:
            for finding in one.findings or ({"line": 0, "kind": "not run", "text": one.error},):
                line = str(finding["line"] or "")
                table.add_row(str(one.seed), line, finding["kind"], finding["text"])
        console.print(table)
        console.print("--seed N without --runs repeats one of them")
    console.print(str(swept))
    if result is not None:
        write_file(result, json.dumps(swept.as_json(), indent=2) + "\n")
    return bool(swept.failed)
