"""Sixteen programs in the manner of public ones run as they do at an arm."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from aioduco.sim import Simulator

from . import (
    blocking_blends,
    force_search,
    hand_485,
    heartbeat,
    http_handler,
    jog_home,
    keyboard_jog,
    laboratory,
    painting,
    servoj_250hz,
    speedl_upon_speedl,
    status_parser,
    two_reads,
    wafer_cell,
    wrapper,
)
from .conftest import Make

Start = Callable[..., Simulator]

#: the quick run takes the first make, for which nothing has to be generated
pytestmark = pytest.mark.cases(1)

FINISHED, INTERRUPT = 4, 5
FAST = float("inf")


@pytest.fixture
def sim(request: pytest.FixtureRequest) -> Iterator[Simulator]:
    """A simulated controller, on the wall's clock unless a test says otherwise."""
    options: dict[str, Any] = getattr(request, "param", {})
    with Simulator(**options) as running:
        yield running


def simulator(**options: Any) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("sim", [options], indirect=True, ids=[""])


# How late a beat may come decides how busy a machine may be: what the slack is by default is tested
# with the heartbeat itself.
@pytest.mark.slow
@simulator(heartbeat_slack=20.0)
def test_a_heartbeat_once_a_second(make: Make, sim: Simulator) -> None:
    assert heartbeat.main(make.cobot, sim.host, sim.port) == [FINISHED, FINISHED]
    assert set(sim.forgiven) <= {"late heartbeat"}


@pytest.mark.slow
def test_keys_jog_the_tool(make: Make, sim: Simulator) -> None:
    answers, moved = keyboard_jog.main(make.cobot, sim.host, sim.port, "wwwwrrrrrrrrrrd")
    assert min(answers) >= 1000
    assert sorted(abs(one) for one in moved) == pytest.approx([0.002, 0.008, 0.02], abs=1e-3)


@pytest.mark.slow
def test_servoj_at_250_hz(make: Make, sim: Simulator) -> None:
    answers, goal, reached = servoj_250hz.main(make.cobot, sim.host, sim.port)
    assert min(answers) >= 1000
    assert reached == pytest.approx(goal, abs=0.01)
    assert goal[0] == pytest.approx(0.3)


@pytest.mark.slow
@simulator(speed=FAST)
def test_a_search_along_one_axis_ends_where_it_is_told(make: Make, sim: Simulator) -> None:
    state, lifted = force_search.main(make.cobot, sim.host, sim.port)
    assert state == FINISHED
    assert lifted == pytest.approx(0.05, abs=0.01)


@pytest.mark.slow
@simulator(speed=FAST)
def test_rows_of_paint(make: Make, sim: Simulator) -> None:
    states, levels = painting.main(make.cobot, make.op, sim.host, sim.port)
    assert states == [FINISHED] * 6
    assert levels == [True, False] * 3


@pytest.mark.slow
def test_blocking_calls_go_on_when_they_blend(make: Make, sim: Simulator) -> None:
    states, apart = blocking_blends.main(make.cobot, sim.host, sim.port)
    assert states == [INTERRUPT] * 3
    assert apart < 1e-3


@simulator(speed=FAST)
def test_requests_move_the_arm_from_another_thread(make: Make, sim: Simulator) -> None:
    moved, seen = http_handler.main(make.cobot, sim.host, sim.port)
    assert moved == {"state": FINISHED}
    assert seen["joints"] == pytest.approx([0.4, 0.0, 1.57, 0.0, -1.57, 0.0], abs=2e-3)


@simulator(speed=FAST)
def test_speeds_that_no_arm_reaches(make: Make, sim: Simulator) -> None:
    states, apart = wrapper.main(make.cobot, sim.host, sim.port)
    assert states == [FINISHED, FINISHED]
    assert apart < 1e-3
    assert sim.forgiven


@pytest.mark.slow
@simulator(status_port=0)
def test_frames_of_the_status_port(make: Make, sim: Simulator) -> None:
    assert sim.status_port is not None
    last = status_parser.main(make.cobot, sim.host, sim.port, sim.status_port)
    assert last["frames"] > 1
    assert (last["state"], last["error"]) == ((6,), (0,))
    assert last["tcp"] == pytest.approx(last["pose"], abs=2e-3)


@pytest.mark.slow
@simulator(status_port=0, speed=FAST)
def test_a_wafer_cell_whose_sources_agree(make: Make, sim: Simulator) -> None:
    assert sim.status_port is not None
    seen = wafer_cell.main(make.cobot, sim.host, sim.port, sim.status_port)
    assert list(seen) == ["cassette", "aligner", "chuck"]
    assert [station.cup for station in seen.values()] == [True, True, False]
    for station in seen.values():
        # a joint may still swing by some hundredths of a milliradian
        assert max(station[:3]) < 1e-3


@simulator(speed=FAST)
def test_a_laboratorys_command_line(make: Make, sim: Simulator) -> None:
    lines = ["state", "wake", "state", "go rack 30", "where", "up 20", "where", "valve 2 on"]
    lines += ["go home 200", "errors"]
    asleep, woken, awake, went, low, up, high, valve, refused, errors = laboratory.main(
        make.cobot, sim.host, sim.port, lines
    )
    assert (asleep[0], woken, awake) == (4, FINISHED, [6, 0, 5, 1])
    assert (went, up, valve, refused) == (FINISHED, FINISHED, True, 8)
    assert sum((a - b) ** 2 for a, b in zip(low, high, strict=True)) == pytest.approx(400, rel=0.02)
    assert "must be" in errors[-1]


@pytest.mark.slow
def test_jogging_then_home(make: Make, sim: Simulator) -> None:
    """What follows speed_stop waits for the stop, and is not refused."""
    state, apart = jog_home.main(make.cobot, sim.host, sim.port)
    assert state == FINISHED
    assert apart < 1e-3


@pytest.mark.slow
def test_two_reads_and_a_set_point_at_250_hz(make: Make, sim: Simulator) -> None:
    answers, goal, reached, fastest = two_reads.main(make.cobot, sim.host, sim.port)
    assert min(answers) >= 1000
    assert goal == pytest.approx(0.2)
    assert reached == pytest.approx(goal, abs=0.01)
    assert fastest > 0.05


@simulator(speed=FAST, gripper="dh_pge")
def test_a_hand_by_raw_rs_485(make: Make, sim: Simulator) -> None:
    reached, state = hand_485.main(make.cobot, sim.host, sim.port)
    assert reached == pytest.approx([0, 700], abs=30)
    assert state == [1, 1, 0]


@pytest.mark.slow
def test_speedl_upon_speedl(make: Make, sim: Simulator) -> None:
    stick = [0.5, 1.0, 1.0, 0.5, 0.2, 0.5, 1.0, 0.5]
    (stopped, *states), tasks, lifted = speedl_upon_speedl.main(
        make.cobot, sim.host, sim.port, stick
    )
    assert (stopped, states) == (FINISHED, [INTERRUPT] * 7 + [FINISHED])
    assert tasks == sorted(set(tasks))
    assert lifted > 1e-3
    assert not sim.moving


@pytest.mark.interop
@pytest.mark.timeout(900)
def test_a_hardware_interface_in_cpp(hardware_interface: Path, sim: Simulator) -> None:
    done = subprocess.run(
        [str(hardware_interface), sim.host, str(sim.port)],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    goal, reached = map(float, done.stdout.split())
    assert goal == pytest.approx(0.3)
    assert reached == pytest.approx(goal, abs=0.01)
