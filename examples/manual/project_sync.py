"""The manual's example on programs (1.3.4), by `aioduco.sync`."""

from __future__ import annotations

from cabinet import run

import aioduco.sync


def files_of_the_project(robot: aioduco.sync.Robot) -> dict[str, aioduco.FileKind]:
    """1.3.4-1: the files in the folder of programs of the project that is loaded."""
    project_path = robot.program.get_current_project()
    return robot.program.get_files_list(project_path + "program")


def main(host: str, port: int) -> dict[str, object]:
    with aioduco.sync.connect(host, port) as robot:
        return {"1.3.4-1": files_of_the_project(robot)}


if __name__ == "__main__":
    run(main)
