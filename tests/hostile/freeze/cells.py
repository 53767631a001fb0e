"""The combinations: which processes are frozen, for how long, and what the program does."""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterator
from dataclasses import dataclass

#: what the program does; those that lead the arm through a stream have a worker
STREAMS = ("servo", "speed", "realtime", "track", "play", "plan")
SCENES = ("motion", *STREAMS, "jog", "force")
#: which processes are frozen
SETS = ("program", "worker", "guard", "all", "all-but-guard")
#: how: for so many seconds, or one of the two words
HOWS = ("0.3", "1", "3", "10", "suspended", "killed")
GUARDS = ("none", "guarded")

#: where the arm begins: joint 1 has room for a whole run, and the others are far from everything
HOME = (-2.8, 0.0, 1.5707963, 0.0, -1.5707963, 0.0)
#: how far joint 1 goes from there [rad], and how fast [rad/s]
FAR, SPEED = 5.6, 0.3
#: how long the arm stands between two short motions [s]
PAUSE = 0.3

#: duration of the simulator's cycles [s]: it is to keep up beside others on a busy machine. From
#: the realtime queue it takes one point a cycle, where a controller takes one a millisecond.
CYCLE = 0.004

#: time for which processes are frozen [s]. The limits of the package that are 1 s have passed after
#: "1", by more than the machine may be late.
SECONDS = {"0.3": 0.3, "1": 1.1, "3": 3.0, "10": 10.0, "suspended": 5.0}


def turned(angle: float) -> list[float]:
    """Where the arm is with joint 1 turned from home by an angle, `FAR` at the most [rad]."""
    return [HOME[0] + min(angle, FAR), *HOME[1:]]


@dataclass(frozen=True, slots=True)
class Cell:
    """What is tried."""

    scene: str
    frozen: str
    how: str
    guarded: bool

    @property
    def roles(self) -> frozenset[str]:
        """The processes that are frozen: of "program", "worker" and "guard"."""
        if self.frozen == "all":
            return self.present
        if self.frozen == "all-but-guard":
            return self.present - {"guard"}
        return frozenset({self.frozen})

    @property
    def present(self) -> frozenset[str]:
        """The processes that there are."""
        worker = {"worker"} if self.scene in STREAMS else set()
        return frozenset({"program"} | worker | ({"guard"} if self.guarded else set()))

    @property
    def words(self) -> tuple[str, str, str, str]:
        """A word for each dimension, by which it is chosen."""
        return self.scene, self.frozen, self.how, GUARDS[self.guarded]

    def __str__(self) -> str:
        unit = " s" if self.how[0].isdigit() else ""
        guard = "guard" if self.guarded else "no guard"
        return f"{self.scene}, {self.frozen} {self.how}{unit}, {guard}"


def cells() -> Iterator[Cell]:
    """All that there are, in their order: see `_exists`."""
    for words in itertools.product(SCENES, SETS, HOWS, (False, True)):
        if _exists(cell := Cell(*words)):
            yield cell


def _exists(cell: Cell) -> bool:
    """No process is frozen that is not there; no set twice; a computer is suspended as a whole."""
    if cell.how == "suspended":
        return cell.frozen == "all"
    if not cell.roles <= cell.present or (cell.frozen == "all-but-guard" and not cell.guarded):
        return False
    # not "all" or "all-but-guard" that is one process, which has a set of its own
    return cell.frozen in cell.roles or len(cell.roles) > 1


@dataclass(frozen=True, slots=True)
class Draw:
    """What chance decides in a run; the same for the same cell and seed.

    Attributes:
        variant: 0 or 1: each program comes in two.
        delay: for how long the arm has been moving when the processes are frozen [s].
        seconds: for how long they are frozen [s].
        killed: time from the freeze to the program's death [s]; None: it is not killed.
        order: a number for the order in which processes are frozen and thawed.
    """

    variant: int
    delay: float
    seconds: float
    killed: float | None
    order: int

    @classmethod
    def of(cls, cell: Cell, seed: int) -> Draw:
        """What is drawn for a cell.

        A program is killed late with odd seeds, when the controller misses its heartbeat before the
        others are thawed, and early with even ones, when it does not.
        """
        chance = random.Random(f"{cell} {seed}")
        late = seed % 2 == 1
        delay = chance.uniform(0.3, 1.0)
        order = chance.randrange(1 << 30)
        if cell.how != "killed":
            return cls(seed % 2, delay, SECONDS[cell.how], None, order)
        killed = chance.uniform(0.5, 2.5) if late else chance.uniform(0.05, 0.3)
        seconds = chance.uniform(4.0, 5.0) if late else chance.uniform(0.35, 0.9)
        return cls(chance.randrange(2), delay, seconds, killed, order)
