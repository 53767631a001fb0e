"""Assert that every call of a program conforms to the manual."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    from aioduco.sim import Simulator


@contextlib.contextmanager
def nothing_forgiven(simulator: Simulator) -> Iterator[None]:
    """Assert that the simulator forgives nothing while the block runs.

        with nothing_forgiven(duco_simulator):
            await my_program.paint(duco_robot)

    `Simulator(strict=True)` refuses such calls instead.

    Args:
        simulator: a lenient simulator, which the program in the block uses.

    Raises:
        AssertionError: It accepted calls that deviate from the manual; the message lists them.
    """
    before = simulator.forgiven
    yield
    new = {kind: count - before.get(kind, 0) for kind, count in simulator.forgiven.items()}
    found = [f"{kind}: {count} times" for kind, count in new.items() if count]
    assert not found, f"the simulator forgave {len(found)} kinds of calls: {'; '.join(found)}"
