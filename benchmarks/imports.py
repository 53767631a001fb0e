"""What the imports cost, in fresh interpreters that take turns.

    python benchmarks/imports.py [--quick] [--save]

    dependencies    import numpy, anyio
    package         import aioduco
    name            from aioduco import connect
    connect         import aioduco, and the first connect(): all that a robot needs is loaded then

Each figure is the median of the times within the interpreters, without their own start. A program
that calls its first connect() on a running event loop holds it up for what `connect` takes more
than `package`; one that imports the name at its top has a part of that behind it.
"""

from __future__ import annotations

import statistics
import subprocess
import sys

from _common import arguments, print_table, write_results

WHAT = {
    "dependencies": "import numpy, anyio",
    "package": "import aioduco",
    "name": "from aioduco import connect",
    "connect": "import aioduco; aioduco.connect('192.0.2.1')",
}

#: most of `import aioduco`, in times of its dependencies
LIMIT = 1.25

TIMED = """
import time
begin = time.perf_counter()
{}
print(time.perf_counter() - begin)
"""


def once(code: str) -> float:
    """The milliseconds that some code takes in an interpreter of its own."""
    done = subprocess.run(
        [sys.executable, "-P", "-c", TIMED.format(code)], capture_output=True, text=True, check=True
    )
    return float(done.stdout) * 1e3


def main() -> int:
    options = arguments(__doc__, "imports")
    times: dict[str, list[float]] = {name: [] for name in WHAT}
    for code in WHAT.values():
        once(code)  # writes what is compiled
    for _ in range(5 if options.quick else 25):
        for name, code in WHAT.items():
            times[name].append(once(code))
    medians = {name: statistics.median(each) for name, each in times.items()}
    ratios = {name: round(each / medians["dependencies"], 2) for name, each in medians.items()}
    columns = ("what", "median ms", "least ms", "ratio")
    rows = [(WHAT[name], medians[name], min(times[name]), ratios[name]) for name in WHAT]
    print_table("Imports, in fresh interpreters", columns, rows)
    print(f"import aioduco: {ratios['package']} of its dependencies; to reach: at most {LIMIT}")
    if options.save:
        figures = {name: round(each, 1) for name, each in medians.items()}
        results = {"limit": LIMIT, "median_ms": figures, "ratios": ratios}
        print(f"written: {write_results('imports', results)}")
    return 0 if ratios["package"] <= LIMIT else 1


if __name__ == "__main__":
    sys.exit(main())
