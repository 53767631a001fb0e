"""`ros2 run aioduco_driver driver`: what `aioduco ros2` runs."""

import sys

from aioduco.cli import main as aioduco


def main() -> None:
    """Run the driver until a signal."""
    sys.argv[1:1] = ["ros2"]
    aioduco()
