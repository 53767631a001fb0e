"""The simulator's process under a fuzzer: `pytest tests/sim/test_hostile.py --frames 1000000`."""

from __future__ import annotations

import math
import time
from collections import Counter
from importlib import import_module
from pathlib import Path
from typing import Any

import psutil
import pytest

from aioduco.sim import Simulator
from aioduco.testing import eventually

from .hostile import Fuzzer, percentiles
from .raw import RawClient

#: what the process may take besides what it had after its first calls
ROOM = 64 << 20


def peak(pid: int) -> int:
    """The most memory that a process has ever had, or has, where the system does not count."""
    status = Path(f"/proc/{pid}/status")
    if not status.exists():
        rss: int = psutil.Process(pid).memory_info().rss
        return rss
    lines = dict(line.split(":", 1) for line in status.read_text().splitlines() if ":" in line)
    return int(lines["VmHWM"].split()[0]) << 10


@pytest.mark.slow
@pytest.mark.timeout(0)
def test_a_server_that_is_sent_anything_goes_on(
    pytestconfig: pytest.Config, totals: Counter[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    frames: int = pytestconfig.getoption("frames")
    seed: int = pytestconfig.getoption("seed")
    with Simulator.spawn(speed=math.inf) as sim:
        process = psutil.Process(sim.pid)
        with RawClient(sim.port) as client:
            for name in ("power_on", "enable"):
                assert client.call(name, block=True) == 4
        Fuzzer(sim.port, 500, seed + 1).run()  # what every code path takes once
        before, threads = peak(sim.pid), process.num_threads()
        began = time.monotonic()
        outcome = Fuzzer(sim.port, frames, seed).run()
        took = time.monotonic() - began
        grown = peak(sim.pid) - before
        assert not outcome.wrong, outcome.wrong[:5]
        assert sum(outcome.frames.values()) == frames
        assert outcome.enabled, "the frames found no arm that could move"
        assert grown < ROOM
        eventually(lambda: process.num_threads() <= threads)
        with RawClient(sim.port) as client:
            assert client.call("power_off", block=True) == 4
            assert client.call("get_robot_state")[0] == 4
    totals.update({"hostile frames": frames})
    if pytestconfig.getoption("frames_save"):
        figures: dict[str, Any] = {
            "command": f"pytest tests/sim/test_hostile.py --frames {frames} --seed {seed} "
            "--frames-save",
            "fuzzer": "a seeded mutator of valid frames, see tests/sim/hostile.py",
            "frames": dict(outcome.frames),
            "answers": dict(outcome.answers),
            "crashes": 0,
            "hangs": 0,
            "seconds": round(took, 1),
            "peak_memory_MB": round((before + grown) / 1e6, 1),
            "grown_memory_MB": round(grown / 1e6, 1),
            "probes_of_another_connection": len(outcome.probes),
            "batches_that_found_the_arm_enabled": outcome.enabled,
            "probe_ms": percentiles(outcome.probes),
        }
        monkeypatch.syspath_prepend(pytestconfig.rootpath / "benchmarks")
        import_module("_common").write_results("hostile", figures)


@pytest.mark.slow
def test_a_frame_that_claims_gigabytes_takes_no_memory() -> None:
    """Sizes are refused before anything is kept for them; so is a body that only goes on."""
    head = b"\x80\x01\x00\x01\x00\x00\x00\x04stop\x00\x00\x00\x01"
    most = (2**31 - 1).to_bytes(4, "big")
    claims = {
        "text": b"\x0b\x00\x01" + most,
        "list of texts": b"\x0f\x00\x01\x0b" + most,
        "list of numbers": b"\x0f\x00\x01\x04" + most,
        "map": b"\x0d\x00\x01\x0b\x0b" + most,
        "name": b"",
    }
    with Simulator.spawn() as sim:
        with RawClient(sim.port) as client:
            client.call("get_robot_state")
        before = peak(sim.pid)
        for claim, body in claims.items():
            with RawClient(sim.port) as client:
                client.sock.sendall((head if body else head[:4] + most) + body)
                client.sock.settimeout(10)
                assert client.ended(), claim
        with RawClient(sim.port) as client:
            # A text of a permitted size, and then fields without an end.
            client.sock.sendall(head + b"\x0b\x00\x01" + (1 << 19).to_bytes(4, "big"))
            with pytest.raises(ConnectionError):
                pour(client)
        assert peak(sim.pid) - before < 16 << 20


def pour(client: RawClient) -> None:
    """Send fields until the server has had enough, or 64 MiB."""
    for _ in range(4096):
        client.sock.sendall(b"\x02" * (1 << 14))


@pytest.mark.slow
def test_idle_and_slow_connections_do_not_delay_a_stop() -> None:
    """A byte of a message a second is what a slow client sends; here each gets its next at once."""
    with Simulator.spawn() as sim, RawClient(sim.port) as client:
        for name in ("power_on", "enable"):
            assert client.call(name, block=True) == 4
        alone = stop_of_a_motion(client, 0.5)
        idle = [RawClient(sim.port) for _ in range(500)]
        slow = [RawClient(sim.port) for _ in range(50)]
        try:
            frames = [one.encode("movej2", [0.5] * 6, 1.0, 1.0, 0.0, True) for one in slow]
            for number in range(5):
                for one, frame in zip(slow, frames, strict=True):
                    one.sock.sendall(frame[number : number + 1])
            assert stop_of_a_motion(client, -0.5) < 2.0 * alone + 0.5
            assert all(one.call("get_robot_state") for one in (idle[0], idle[-1]))
        finally:
            for one in (*idle, *slow):
                one.close()
        eventually(lambda: psutil.Process(sim.pid).num_threads() < 20)


def stop_of_a_motion(client: RawClient, goal: float) -> float:
    """Stop a motion of the first joint in its middle; how long that took [s]."""
    joints = [goal, 0.0, 1.57, 0.0, -1.57, 0.0]
    assert client.call("movej2", joints, 0.5, 2.0, 0.0, False) >= 1000
    eventually(lambda: client.call("robotmoving"))
    began = time.monotonic()
    assert client.call("stop", block=True) == 4
    took = time.monotonic() - began
    assert client.call("robotmoving") is False
    assert abs(client.call("get_actual_joints_position")[0] - goal) > 0.1
    return took
