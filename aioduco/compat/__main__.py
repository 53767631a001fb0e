"""Run a program that was written for the vendor's Python class: `python -m aioduco.compat`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from aioduco.compat._runner import module_exists, run


def main(arguments: list[str] | None = None) -> None:
    """Run the program that the command line names.

    Args:
        arguments: the command line; None for that of the process.
    """
    parser = argparse.ArgumentParser(
        prog="python -m aioduco.compat",
        description="Run a program that imports the vendor's class DucoCobot, unchanged: that "
        "import, and those of gen_py and thrift, give aioduco.compat.",
    )
    parser.add_argument("-m", dest="module", action="store_true", help="the program is a module")
    parser.add_argument("program", help="the program's file, or its module with -m")
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help="what is handed to it")
    options = parser.parse_args(arguments)
    if options.module and not module_exists(options.program):
        parser.error(f"{options.program} is no module in {Path.cwd()}, nor an installed one")
    if not options.module and not Path(options.program).is_file():
        parser.error(f"{options.program} is no file")
    run(options.program, options.arguments, module=options.module)


if __name__ == "__main__":
    main(sys.argv[1:])
