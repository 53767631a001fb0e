"""The same program under many seeded variations, on Dask's distributed scheduler."""

from __future__ import annotations

import contextlib
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.errors import MissingExtra
from aioduco.testing.preflight.runner import (
    PreflightError,
    PreflightSettings,
    preflight,
    refuse_frozen,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


#: number of retries of a variation whose worker has died: that is not the variation's fault
_RETRIES = 10


@dataclass(frozen=True, slots=True)
class VariationResult:
    """Result of one variation.

    Attributes:
        seed: seed that repeats the variation.
        findings: the findings, each as values for JSON.
        duration: the program's own time [s].
        error: why the variation could not be run; empty if it could.
    """

    seed: int
    findings: tuple[dict[str, Any], ...]
    duration: float
    error: str = ""

    @property
    def ok(self) -> bool:
        """Whether nothing was found."""
        return not (self.findings or self.error)


@dataclass(frozen=True, slots=True)
class SweepReport:
    """Results of all variations.

    Attributes:
        results: one for each seed, in the order of seeds.
    """

    results: tuple[VariationResult, ...]

    @property
    def failed(self) -> tuple[VariationResult, ...]:
        """Results with findings, or of variations that could not be run."""
        return tuple(one for one in self.results if not one.ok)

    @property
    def durations(self) -> dict[str, float]:
        """Percentiles of the program's own time, without variations that could not be run [s]."""
        times = [one.duration for one in self.results if not one.error]
        if not times:
            return {}
        return {f"p{p}": float(np.percentile(times, p)) for p in (5, 50, 95, 100)}

    def __str__(self) -> str:
        times = ", ".join(f"{name} {value:.2f} s" for name, value in self.durations.items())
        return f"{len(self.failed)} of {len(self.results)} variations failed; duration {times}"

    def as_json(self) -> dict[str, Any]:
        """The report as values for JSON."""
        return {
            "schema": 1, "durations": self.durations,
            "results": [asdict(one) for one in self.results],
        }  # fmt: skip


def sweep(
    program: str,
    arguments: Sequence[str],
    settings: PreflightSettings,
    runs: int,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    done: Callable[[VariationResult], object] = lambda _: None,
) -> SweepReport:
    """Run variations of a program on a cluster.

    Args:
        program: file or module of the program; on a remote cluster it must have the same path, and
            it runs in the same folder as here.
        arguments: arguments of the program.
        settings: cell and settings; `vary` names the varied quantities, `seed` is the first seed.
        runs: number of variations.
        workers: processes of the local cluster; None for one per processor.
        scheduler: address of a cluster's scheduler; None for a cluster on this computer.
        done: called with each result when it is ready.

    Returns:
        All results.

    Raises:
        MissingExtra: distributed is not installed.
        ParameterError: `vary` has an unknown name.
        PreflightError: the cluster would run on this computer, and this program is frozen.
    """
    with MissingExtra.named("sweeps", "sweep"):
        import distributed  # noqa: PLC0415 - an extra
    dask: Any = distributed  # some of its functions have no types
    options = {**settings.plain(), "cwd": settings.cwd or str(Path.cwd())}
    seeds = range(settings.seed, settings.seed + runs)
    with contextlib.ExitStack() as stack:
        if scheduler is None:
            refuse_frozen()
            # With None as the dashboard's address, its server would use port 8787.
            cluster = dask.LocalCluster(
                n_workers=workers, threads_per_worker=1, processes=True, host="127.0.0.1",
                dashboard_address="127.0.0.1:0", worker_dashboard_address=None,
            )  # fmt: skip
            scheduler = stack.enter_context(cluster)
        client = stack.enter_context(dask.Client(scheduler))
        futures = [
            client.submit(
                _one, program, list(arguments), options, seed, pure=False, retries=_RETRIES
            )
            for seed in seeds
        ]
        results = []
        for _, result in dask.as_completed(futures, with_results=True):
            results.append(result)
            done(result)
    results.sort(key=lambda one: one.seed)
    return SweepReport(tuple(results))


def _one(program: str, arguments: list[str], options: dict[str, Any], seed: int) -> VariationResult:
    """Run one variation, on a worker."""
    settings = replace(PreflightSettings(**options), seed=seed)
    try:
        report = preflight(program, arguments, settings, quiet=True)
    except PreflightError as error:
        return VariationResult(seed, (), 0.0, str(error))
    found = tuple(one.as_json() for one in report.findings)
    return VariationResult(seed, found, report.duration)
