"""`aioduco`, for `patient.py`, which runs files."""

from aioduco.cli import main

main()
