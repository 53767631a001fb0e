"""The panel's view of an arm and its twin: both in one scene, and a line of text."""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np
import pytest
from cli_runner import CliRunner

import aioduco
from aioduco.cli.app import app
from aioduco.envelope import Envelope, Zone
from aioduco.integrations.panel.twin_view import parted_text, twin_text
from aioduco.planning import Scene
from aioduco.sim import Simulator
from aioduco.sim.scene import Sphere, Table
from aioduco.sim.twin.data import TwinSample
from aioduco.sim.twin.limits import TwinLimits
from aioduco.sim.twin.monitor import TwinFigures, TwinMonitor
from aioduco.supervision.events import TwinDiverged
from aioduco.testing import eventually_async

try:
    from aioduco.integrations.panel import Panel
    from aioduco.integrations.panel.arm_scene import ArmScene
    from integrations.panel.test_panel import PATIENT, page_of
except ImportError:  # without the extra
    pytest.skip("needs pip install 'aioduco[panel]'", allow_module_level=True)
HOME = (0.0, -0.3, 1.8, 0.0, -1.57, 0.0)
ARM = aioduco.kinematics.arm("gcr5_910")


def parted(**estimate: float) -> TwinDiverged:
    return TwinDiverged(
        1.0, "torque", "flange", 0.5, 2.03, 1.0, "kg", "payload", estimate, "report"
    )


def test_the_line_says_the_differences_or_what_has_parted() -> None:
    assert twin_text(TwinFigures(), None, None) == "its twin has not begun yet"
    known = TwinFigures(mass=-0.001, force=3.04, friction=0.125, position=0.0001)
    text = (
        "differences from its twin: payload 0.00 kg, force 3.0 N, friction 12 %, position 0.10 mm"
    )
    assert twin_text(known, None, None) == text
    event = parted(**{"mass [kg]": 2.274})
    said = "arm and twin have parted: torque at flange, probably payload (mass [kg] 2.27)"
    assert twin_text(known, event, None) == parted_text(event) == said
    assert parted_text(parted()).endswith("probably payload")
    assert "RuntimeError" in twin_text(known, event, RuntimeError("RuntimeError: gone"))


def sample(expected: tuple[float, ...], speeds: tuple[float, ...]) -> TwinSample:
    zeros = (0.0,) * 6
    values: dict[str, Any] = dict.fromkeys(TwinSample._fields, 0) | {
        "time": 1.0, "joints": HOME, "speeds": zeros, "expected": expected,
        "expected_speeds": speeds, "external": None, "force": None, "pose": None, "led": False,
        "collision": 0,
    }  # fmt: skip
    return TwinSample(**values)


def test_the_twin_is_behind_the_set_points_by_the_normal_lag() -> None:
    limits = TwinLimits.of(ARM)
    monitor = TwinMonitor(ARM, limits, commands=False)
    speeds = (0.5, 0.0, 0.0, 0.0, 0.0, -0.2)
    monitor.sample(sample(HOME, speeds))
    wanted = np.array(HOME) - np.array(limits.lag) * np.array(speeds)
    np.testing.assert_allclose(monitor.joints, wanted)


@pytest.mark.cases(1)
@pytest.mark.parametrize("which", ["told", "aim", "twin"])
def test_what_differs_from_the_arm_is_drawn_where_it_is(which: str) -> None:
    """What it was told, where the sliders point, and its twin."""
    with contextlib.closing(ArmScene(ARM, None, None, twin=True)) as scene:
        apart = (0.1, *HOME[1:])
        for shown in (HOME, apart, HOME, apart):
            others: dict[str, Any] = {"told": HOME, "aim": None, which: shown}
            scene.show(HOME, **others)
            root, links = scene._arms[which]
            assert root.visible is (shown is apart)
        np.testing.assert_allclose(links[0].wxyz, (np.cos(0.05), 0.0, 0.0, np.sin(0.05)), atol=1e-6)


def test_things_and_zones_are_drawn_where_they_are() -> None:
    table = Table(at=(0.62, 0.0, 0.24), size=(0.5, 0.8), name="table")
    ball = Sphere(at=(0.0, 0.5, 0.3), radius=0.1, name="table/ball")
    zones = [
        Zone.box((0.0, 0.72, 0.55), (1.3, 0.04, 1.1)),
        Zone.sphere((0.0, 0.0, 1.0), 0.3),
        Zone.plane((0.0, 0.0, 0.02), (0.0, 0.0, 1.0)),
    ]
    around = Scene("gcr5_910", [table, ball]), Envelope("gcr5_910", *zones)
    with contextlib.closing(ArmScene(ARM, *around)) as scene:
        drawn = scene._server.scene._handle_from_node_name
        for name, place, size in (
            ("/things/0", (0.62, 0.0, 0.24), None),
            ("/things/0/0", (0.0, 0.0, -0.01), (0.5, 0.8, 0.02)),
            ("/things/1", (0.0, 0.5, 0.3), None),  # in no frame of another one
            ("/things/1/0", (0.0, 0.0, 0.0), 0.1),
            ("/base/zones/0", (0.0, 0.72, 0.55), (1.3, 0.04, 1.1)),
            ("/base/zones/1", (0.0, 0.0, 1.0), 0.3),
            ("/base/zones/2", (0.0, 0.0, 0.02), (2.4, 2.4, 0.002)),
        ):
            node: Any = drawn[name]
            assert tuple(node.position) == place
            assert getattr(node, "dimensions", getattr(node, "radius", None)) == size


@pytest.mark.slow
async def test_a_page_is_told_where_the_arm_and_its_twin_part() -> None:
    with Simulator(joints=HOME) as sim:
        async with aioduco.connect(sim.host, sim.port, heartbeat=None) as robot:
            await robot.bring_up()
        options = PATIENT | {"token": "", "twin": True, "clock": sim.clock}
        async with Panel(sim.host, sim.port, **options) as panel, page_of(panel) as page:
            assert page.all("hello")[0]["twin"]
            await eventually_async(
                lambda: "payload" in page.state["twin"]["text"], timeout=60, what="it compares"
            )
            assert not page.state["twin"]["parted"]
            sim.push((0.0, 80.0, 0.0, 0.0, 0.0, 0.0))
            await eventually_async(
                lambda: any(each["twin"]["parted"] for each in page.all("state")),
                timeout=60,
                what="the line is a warning",
            )
            await eventually_async(
                lambda: any(
                    "arm and twin have parted" in each["text"] and each["severity"] == "warning"
                    for each in page.all("event")
                ),
                timeout=60,
                what="a warning among the events",
            )
        assert not sim.tasks, "it never commands"


@pytest.mark.slow
async def test_without_a_twin_there_is_no_line() -> None:
    with Simulator(joints=HOME) as sim:
        async with Panel(sim.host, sim.port, **PATIENT) as panel, page_of(panel) as page:
            assert panel.twin is None
            assert page.state["twin"] is None


@pytest.mark.slow
def test_the_command_shows_both_arms_and_commands_nothing() -> None:
    with Simulator(joints=HOME) as sim:
        where = f"{sim.host}:{sim.port}"
        done = CliRunner().invoke(
            app, ["twin", where, "--panel", "--listen", "0", "--seconds", "1.5"]
        )
        assert done.exit_code == 0, done.output
        assert f"{where} and its twin are on http://127.0.0.1:" in done.output
        assert not sim.tasks
    refused = CliRunner().invoke(app, ["twin", where, "--panel", "--action", "stop"])
    assert refused.exit_code == 2
    assert "for a twin without" in refused.output
    nobody = CliRunner().invoke(app, ["twin", "127.0.0.1:1", "--panel", "--listen", "0"])
    assert nobody.exit_code == 1
    assert nobody.stderr.startswith("cannot connect to 127.0.0.1:1: ")
