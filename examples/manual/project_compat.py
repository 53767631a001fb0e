"""The manual's example on programs (1.3.4), by the vendor's class."""

from __future__ import annotations

from cabinet import run

from aioduco.compat import DucoCobot


def files_of_the_project(robot: DucoCobot) -> dict[str, int]:
    """1.3.4-1: the files in the folder of programs of the project that is loaded."""
    project_path = robot.get_current_project()
    return robot.get_files_list(project_path + "program")


def main(host: str, port: int) -> dict[str, object]:
    with DucoCobot(host, port) as robot:
        return {"1.3.4-1": files_of_the_project(robot)}


if __name__ == "__main__":
    run(main)
