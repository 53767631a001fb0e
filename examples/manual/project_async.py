"""The manual's example on programs (1.3.4), by `aioduco`."""

from __future__ import annotations

import anyio
from cabinet import run

import aioduco


async def files_of_the_project(robot: aioduco.Robot) -> dict[str, aioduco.FileKind]:
    """1.3.4-1: the files in the folder of programs of the project that is loaded."""
    project_path = await robot.program.get_current_project()
    return await robot.program.get_files_list(project_path + "program")


async def main(host: str, port: int) -> dict[str, object]:
    async with aioduco.connect(host, port) as robot:
        return {"1.3.4-1": await files_of_the_project(robot)}


if __name__ == "__main__":
    run(lambda host, port: anyio.run(main, host, port))
