"""What the benchmark of streams asks for, line by line, and whether it was reached."""

from __future__ import annotations

from typing import Any

#: p99 of lateness that a paced stream may have [µs]
LATE = 250.0


def judged(results: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Each line: what is asked for, what was found, and whether that is enough."""
    rows: dict[str, dict[str, Any]] = {}

    def line(name: str, asked: str, found: object, reached: bool) -> None:
        rows[name] = {"asked": asked, "found": found, "reached": bool(reached)}

    def beside_noise(name: str, worker: dict[str, Any], bare: dict[str, Any]) -> None:
        # What a loop that only sleeps would have had in as many ticks, and the chance in that.
        noise = bare["beyond_2ms"] * worker["ticks"] / bare["ticks"]
        line(
            f"{name}: ticks later than 2 ms; by the machine's noise",
            "as many, within 3 sigma",
            f"{worker['beyond_2ms']}; {noise:.0f}",
            worker["beyond_2ms"] <= noise + 3 * (noise + 1) ** 0.5,
        )

    best = results["greatest_rate"]["process"]
    line(
        "greatest servoj rate, to thriftpy2 called directly",
        "at least 0.9",
        best["to_thriftpy2"],
        best["to_thriftpy2"] >= 0.9,
    )
    if best["to_apache"]:
        line(
            "greatest servoj rate, to the Apache client as shipped",
            "at least 300",
            best["to_apache"],
            best["to_apache"] >= 300,
        )
    for load in ("idle", "busy"):
        figures = results["pacing"][load]
        worker, bare = figures["process"], figures["bare"]
        line(
            f"servoj at 1 kHz, loop {load}: lateness p99 [µs]",
            f"at most {LATE:g}",
            worker["late_p99_us"],
            worker["late_p99_us"] <= LATE,
        )
        beside_noise(f"servoj at 1 kHz, loop {load}", worker, bare)
    busy = results["pacing"]["busy"]
    for name in ("thread", "loop"):
        ratio = round(busy[name]["late_p99_us"] / busy["process"]["late_p99_us"], 1)
        line(
            f"the same load: p99 of the {name}, to the process",
            "collapses: above 10",
            ratio,
            ratio > 10,
        )
    for load, figures in results["realtime_queue"].items():
        starved = figures["process"]["starved_cycles"]
        line(
            f"realtime queue at 1 kHz, {load}: cycles without a point", "none", starved, not starved
        )
    smooth = results["upsampling"]["ruckig"]
    line(
        "30 Hz targets at 500 Hz: jerk, to its limit",
        "at most 1",
        round(smooth["jerk"] / smooth["jerk_limit"], 4),
        smooth["jerk"] <= smooth["jerk_limit"] * 1.001,
    )
    line(
        "30 Hz targets at 500 Hz: acceleration, to the bare steps'",
        "at most 0.2",
        smooth["to_bare_steps"],
        smooth["to_bare_steps"] <= 0.2,
    )
    end = results["killed"]
    line(
        "program killed: ticks from 0.4 rad/s to rest, 40 by the limit",
        "38 to 42, then a stop",
        round(end["ticks_to_rest"]),
        38 <= end["ticks_to_rest"] <= 42 and end["step_at_the_end_rad"] == 0 and end["stops"] >= 1,
    )
    line(
        "program killed: processes and shared memory left",
        "none",
        end["left"],
        end["left"] == 0,
    )
    largest = max(results["memory"].values())
    line("memory of a worker's process [MB]", "at most 34", largest, largest <= 34)
    simulator = results["simulator"]
    line(
        "simulator, servoj at 1 kHz, loop busy: lateness p99 [µs]",
        f"at most {LATE:g}",
        simulator["servoj"]["late_p99_us"],
        simulator["servoj"]["late_p99_us"] <= LATE,
    )
    beside_noise(
        "simulator, servoj at 1 kHz, loop busy",
        simulator["servoj"],
        simulator["bare, beside servoj"],
    )
    line(
        "simulator, realtime queue at 1 kHz, loop busy, one stall of 300 ms: empty queues",
        "none, and no fault",
        simulator["realtime"]["drained"],
        simulator["realtime"]["drained"] == 0 and not simulator["realtime"]["faults"],
    )
    line(
        "simulator, program killed: the arm stands",
        "yes",
        "yes" if simulator["killed"]["stands"] else "no",
        simulator["killed"]["stands"],
    )
    return rows
