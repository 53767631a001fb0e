"""`python -m aioduco.supervision.guard DESCRIPTOR`: started by a program, never by hand."""

from __future__ import annotations

import sys

from aioduco.supervision.guard.process import main

main(int(sys.argv[1]))
