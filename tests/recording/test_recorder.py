"""What is recorded, at which cost, and how a recording ends."""

from __future__ import annotations

import asyncio
import logging
import os
import random
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import anyio
import foxglove
import pytest
from client.bench import HOME, Bench, under_way
from interpreter import python

import aioduco
import aioduco.sync
from aioduco.errors import TaskStopped
from aioduco.models.enums import TaskState
from aioduco.recording import RecordedRun, channels, read, writer
from aioduco.recording.moving_gaps import MovingGaps
from aioduco.recording.recorder import Recording
from aioduco.sim import Simulator
from aioduco.testing import eventually, eventually_async


def data(run: RecordedRun, topic: str) -> list[dict[str, Any]]:
    return [message.data for message in run.messages(topic)]


def recorders() -> list[str]:
    return [thread.name for thread in threading.enumerate() if "recording" in thread.name]


async def test_every_command_and_task_is_recorded_with_its_end(
    robot: aioduco.Robot, bench: Bench, tmp_path: Path
) -> None:
    async with robot.record(tmp_path / "run.mcap") as recording:
        assert recording.running
        await robot.motion.movej2(HOME, v=1.0, a=1.0)
        await robot.io.set_standard_digital_out(3, True)
        bench.motion_time = 60.0
        task = await robot.motion.movel([0.4, 0, 0.5, 3, 0, 0], v=0.1, a=0.5).start()
        await robot.stop()
        with pytest.raises(aioduco.TaskStopped):
            await task
        bench.answer("set_standard_digital_out", -1)
        with pytest.raises(aioduco.Refused):
            await robot.io.set_standard_digital_out(3, False)
        bench.ends = TaskState.ERROR
        task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        bench.errors = ["E 7"]
        bench.arrive()
        with pytest.raises(aioduco.TaskFailed):
            await task
    assert recording.over
    assert recording.error is None
    run = read(recording.path)
    assert run.complete
    commands = {message.data["function"]: message for message in run.messages("/commands")}
    assert set(commands) == {"movej2", "set_standard_digital_out", "movel", "stop"}
    called = [each for each in data(run, "/commands") if each["function"] == "movej2"]
    assert called[0]["arguments"][:4] == [HOME, 1.0, 1.0, 0.0]
    assert called[0]["result"] >= 1000
    assert all(each["duration"] > 0.0 and each["error"] == "" for each in called)
    # a stop whose answer takes long is sent on another lane, too
    assert "stop" in [each["lane"] for each in data(run, "/commands") if each["function"] == "stop"]
    tasks = data(run, "/tasks")
    ends = [(each["name"], each["outcome"]) for each in tasks if each["done"]]
    assert ends == [("movej2", "FINISHED"), ("movel", "STOPPED"), ("movej2", "FAILED")]
    assert tasks[-1]["errors"] == ["E 7"]
    first = [each["state"] for each in tasks if each["id"] == called[0]["result"]]
    assert first[0] == "IDLE"
    assert first[-1] == "FINISHED"
    assert "RUNNING" in first
    times = [message.time for message in run.messages()]
    assert times == sorted(times)
    assert run.metadata["address"] == f"{bench.host}:{bench.port}"


async def test_gaps_while_the_arm_moved_are_counted_and_reported(
    robot: aioduco.Robot, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with robot.record(tmp_path / "run.mcap") as recording:
        await eventually_async(lambda: recording.statistics().written > 3)
        recording._gaps.sampled(1.0, [0.0] * 6)
        recording._gaps.sampled(1.5, [0.1] * 6)
    assert recording.statistics().longest_gap >= 0.5
    assert recording.statistics().gaps >= 1

    def lines() -> list[str]:
        return [each.message for each in caplog.records if "without a sample" in each.message]

    await eventually_async(lambda: bool(lines()))
    assert f"aioduco play {recording.path} --check" in lines()[0]
    assert read(recording.path)._texts["aioduco.end"]["gaps"] != "0"


async def test_a_call_that_fails_is_recorded_with_its_error(
    robot: aioduco.Robot, bench: Bench, tmp_path: Path
) -> None:
    gate = bench.hold("get_standard_digital_out", True)
    async with robot.record(tmp_path / "run.mcap") as recording:
        async with anyio.create_task_group() as group:
            group.start_soon(robot.io.get_standard_digital_out, 1)
            await eventually_async(lambda: bool(bench.received("get_standard_digital_out")))
            group.cancel_scope.cancel()
        gate.set()
    (call,) = data(read(recording.path), "/commands")
    assert call["function"] == "get_standard_digital_out"
    assert call["result"] is None
    assert call["error"].startswith("CancelledError")


async def test_states_events_and_log_lines_are_recorded(
    robot: aioduco.Robot, bench: Bench, tmp_path: Path
) -> None:
    own = logging.getLogger("a.program")
    async with robot.record(tmp_path / "run.mcap") as recording:
        own.addHandler(recording.handler)
        own.warning("part %d is missing", 7)
        own.removeHandler(recording.handler)
        await eventually_async(lambda: recording.statistics().written > 3)
        with robot.events.subscribe() as events:
            bench.emergency_stop = True
            async for event in events:
                if isinstance(event, aioduco.events.EmergencyStopPressed):
                    break
    run = read(recording.path)
    assert "EmergencyStopPressed" in [each["event"] for each in data(run, "/events")]
    (line,) = data(run, "/log")
    assert (line["level"], line["name"]) == ("WARNING", "a.program")
    assert line["message"] == "part 7 is missing"
    assert line["file"] == __file__
    assert data(run, "/io")[0]["digital_inputs"] == [True] * 16
    states = data(run, "/state")
    assert [states[0]["emergency_stop"], states[-1]["emergency_stop"]] == [False, True]
    assert states[0]["robot"] == "ENABLE"


@pytest.mark.slow
@pytest.mark.parametrize(
    "text", ["lone \ud800", "/parts/t\udce9l", "\x1b[2J", "a\0b", "超限 \u2028"]
)
async def test_no_text_of_a_program_ends_a_recording(
    robot: aioduco.Robot, tmp_path: Path, text: str
) -> None:
    async with robot.record(tmp_path / "run.mcap") as recording:
        recording.handler.emit(logging.LogRecord(text, 30, text, 1, text, (), None))
        await eventually_async(lambda: recording.statistics().written > 3)
        robot.events.tell(aioduco.events.ConnectionGone(time.monotonic(), text))
        before = recording.statistics().written
        await eventually_async(lambda: recording.statistics().written > before)
    assert recording.error is None
    run = read(recording.path)
    assert run.complete
    assert data(run, "/log")[0]["message"] == text.encode("utf-8", "replace").decode()
    assert data(run, "/events")


async def test_a_line_without_a_place_is_recorded(robot: aioduco.Robot, tmp_path: Path) -> None:
    """Those of libraries in other languages have none: they ended the recording."""
    nothing: Any = None
    async with robot.record(tmp_path / "run.mcap") as recording:
        line = logging.LogRecord("other", 20, nothing, nothing, "a line", (), None)
        recording.handler.emit(line)
    assert recording.error is None
    (line_read,) = data(read(recording.path), "/log")
    assert (line_read["message"], line_read["file"], line_read["line"]) == ("a line", "", 0)


@pytest.mark.slow
def test_a_line_that_python_would_show_is_shown_although_it_is_recorded(tmp_path: Path) -> None:
    code = (
        "import logging, aioduco.sync\n"
        "from client.bench import Bench\n"
        "quiet = dict(lag_limit=None, heartbeat=None)\n"
        "with Bench() as b, aioduco.sync.connect(b.host, b.port, **quiet) as robot:\n"
        "    with robot.record('run.mcap'), robot.record('other.mcap'):\n"
        "        logging.getLogger('aioduco.x').warning('seen once')\n"
        "        logging.getLogger('aioduco.x').info('not seen')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])},
        capture_output=True,
        text=True,
        check=True,
        timeout=100,
    )
    assert done.stderr == "seen once\n"
    (line,) = data(read(tmp_path / "run.mcap"), "/log")
    assert line["message"] == "seen once"


@pytest.mark.slow
async def test_a_stream_is_recorded_with_its_set_points_and_its_lateness(tmp_path: Path) -> None:
    with Simulator() as sim:
        async with aioduco.connect(
            sim.host, sim.port, state_rate=100, clock=sim.clock, record=tmp_path / "run.mcap"
        ) as robot:
            await robot.bring_up()
            start = list(await robot.state.get_actual_joints_position())
            async with robot.servo.joints(v=1.0, a=1.0, hold=10.0) as stream:
                for number in range(20):
                    await stream.send([start[0] + 1e-4 * number, *start[1:]])
                    await anyio.sleep(0.01)
            figures = stream.statistics()
            assert robot.recording is not None
            await robot.recording.stop()
            path = robot.recording.path
    run = read(path)
    last = data(run, "/streams")[-1]
    assert (last["stream"], last["state"], last["sent"]) == ("servoj", "ENDED", figures.sent)
    assert last["lateness"]["p99"] == figures.lateness.p99
    points = [each["point"] for each in data(run, "/stream_setpoints")]
    assert points
    # Where the program was late, the stream went on a little, to come to rest within its limits.
    assert all(abs(point[0] - start[0]) <= 0.01 for point in points)
    seen = run.arrays("/joint_setpoints")["position"]
    assert seen[-1][0] == pytest.approx(points[-1][0], abs=5e-4)


async def test_nothing_of_a_recording_stays_behind(robot: aioduco.Robot, tmp_path: Path) -> None:
    logger = logging.getLogger("aioduco")
    handlers = list(logger.handlers)
    for _ in range(3):
        async with robot.record(tmp_path / "run.mcap"):
            await robot.wait_for(lambda sample: sample.read_forces is not None)
            assert recorders() == ["aioduco-recording"]
    assert recorders() == []
    assert logger.handlers == handlers
    await robot.wait_for(lambda sample: sample.read_forces is None)
    supervisor = robot._supervisor
    assert not any(lane.observers for lane in supervisor.lanes)
    assert not supervisor.stop_coordinator.follower.observers
    # a file that exists is kept
    for name in ("run.mcap", "run-1.mcap", "run-2.mcap"):
        assert read(tmp_path / name).complete


async def test_a_folder_is_no_file_that_exists(bench: Bench, tmp_path: Path) -> None:
    async with aioduco.connect(bench.host, bench.port) as robot:
        with pytest.raises(aioduco.RecordingError, match="Is a directory"):
            await robot.record(tmp_path).start()
    assert not tmp_path.with_name(f"{tmp_path.name}-1").exists()


async def test_closing_the_robot_ends_its_recordings(bench: Bench, tmp_path: Path) -> None:
    robot = aioduco.connect(bench.host, bench.port, record=tmp_path / "a.mcap")
    assert robot.recording is None
    async with robot:
        other = await robot.record(tmp_path / "b.mcap").start()
        with pytest.raises(aioduco.RobotStateError, match="once"):
            await other.start()
        bench.motion_time = 60.0
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    assert recorders() == []
    for name in ("a.mcap", "b.mcap"):
        run = read(tmp_path / name)
        assert run.complete
        # the stop on the way out is in it
        assert data(run, "/commands")[-1]["function"] == "stop"
        assert data(run, "/tasks")[-1]["outcome"] == "STOPPED"


async def test_each_recording_ends_also_if_closing_is_cancelled_while_another_ends(
    bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: set[Recording] = set()

    async def cancelled(self: Recording) -> None:
        if self not in begun:
            begun.add(self)
            closing.cancel()
        await stop(self)

    async def close() -> None:
        async with aioduco.connect(bench.host, bench.port) as robot:
            for name in "ab":
                await robot.record(tmp_path / f"{name}.mcap").start()

    stop = Recording._stop
    monkeypatch.setattr(Recording, "_stop", cancelled)
    closing = asyncio.create_task(close())
    with pytest.raises(asyncio.CancelledError):
        await closing
    assert recorders() == []
    assert all(read(tmp_path / f"{name}.mcap").complete for name in "ab")


async def test_two_tasks_may_close_a_robot_and_find_its_recording_ended(
    bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    held = anyio.Event()

    async def late(self: Recording) -> None:
        monkeypatch.setattr(Recording, "_stop", stop)
        await held.wait()
        await stop(self)

    stop = Recording._stop
    robot = aioduco.connect(bench.host, bench.port, record=tmp_path / "a.mcap")
    await robot.open()
    monkeypatch.setattr(Recording, "_stop", late)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(robot.aclose)
        await eventually_async(lambda: Recording._stop is stop)
        await robot.aclose()
        held.set()
        assert robot.recording is not None
        assert robot.recording.over
    assert read(tmp_path / "a.mcap").complete


async def test_a_recording_whose_start_is_cancelled_is_over(
    robot: aioduco.Robot, bench: Bench, tmp_path: Path
) -> None:
    """Its writer has not begun yet: closing the robot must not wait for that."""
    recording = robot.record(tmp_path / "a.mcap")
    gate = bench.hold("get_robot_type", ["", ""])
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(recording.start)
        await eventually_async(lambda: bool(bench.received("get_robot_type")))
        tasks.cancel_scope.cancel()
    await recording.stop()
    assert recording.over
    gate.set()


async def test_a_file_that_cannot_be_made_is_said_before_the_program_begins(
    bench: Bench, tmp_path: Path
) -> None:
    with pytest.raises(aioduco.RecordingError, match="No such file"):
        async with aioduco.connect(bench.host, bench.port, record=tmp_path / "no" / "a.mcap"):
            pytest.fail("the robot was opened")
    assert recorders() == []
    async with aioduco.connect(bench.host, bench.port) as robot:
        for path in (7, ""):
            with pytest.raises(aioduco.ParameterError, match="name of a file"):
                robot.record(path)  # type: ignore[arg-type]  # what it refuses
        with pytest.raises(aioduco.RecordingError, match="cannot be written"):
            await robot.record(tmp_path / "no" / "a.mcap").start()
        await robot.state.get_robot_state()


@pytest.mark.parametrize("step", ["open_mcap", "metadata", "flush", "_write_out"])
def test_a_file_that_cannot_be_begun_leaves_nothing(
    step: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    for _ in range(2):  # the second time with the channels that the first one has released
        free = len(channels._free)
        with monkeypatch.context() as patched:
            places = {"open_mcap": foxglove, "_write_out": writer.RecordingWriter}
            patched.setattr(places.get(step, channels.FileChannels), step, full)
            begun = writer.RecordingWriter(tmp_path / "run.mcap", dict)
            begun.begin({"clock_offset": "0"}, lambda: None, lambda: None)
            assert begun.join(60.0)
        assert isinstance(begun.error, OSError)
        assert len(channels._free) == max(free, 1)
        assert not list(tmp_path.iterdir())
    again = writer.RecordingWriter(tmp_path / "run.mcap", dict)
    again.begin({"clock_offset": "0"}, lambda: None, lambda: None)
    again.finish()
    assert again.join(60.0)
    assert read(tmp_path / "run.mcap").complete


@pytest.mark.parametrize("wall", [-(10**15), 1 << 62])
def test_a_computer_whose_clock_is_not_set_says_so(
    wall: int, bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with aioduco.sync.connect(bench.host, bench.port) as robot:
        monkeypatch.setattr(time, "time_ns", lambda: wall)
        with pytest.raises(aioduco.RecordingError, match="before 1970 or after 2106: set it"):
            robot.record(tmp_path / "a.mcap").start()
        with pytest.raises(aioduco.RecordingError, match="before 1970 or after 2106: set it"):
            robot.publish(0).start()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("step", [-3600.0, 3600.0, 60.0 * 365 * 86400])
async def test_a_clock_that_is_set_moves_no_log_line(
    step: float, robot: aioduco.Robot, tmp_path: Path
) -> None:
    """The last step is that of a computer without a clock of its own, which gets the time."""
    async with robot.record(tmp_path / "run.mcap") as recording:
        line = logging.LogRecord("a.program", logging.WARNING, "", 1, "here", (), None)
        line.created -= step  # it was made before the step, and is handled after it
        recording.handler.emit(line)
    run = read(recording.path)
    assert (recording.error, run.complete) == (None, True)
    (time_of_line,) = [each.time for each in run.messages("/log")]
    assert -0.1 < time_of_line < run.duration + 0.1 < 60.0


def test_in_programs_that_wait(bench: Bench, tmp_path: Path) -> None:
    with aioduco.sync.connect(bench.host, bench.port, record=tmp_path / "a.mcap") as robot:
        with robot.record(tmp_path / "b.mcap", forces=False) as recording:
            robot.motion.movej2(HOME, v=1.0, a=1.0)
            assert recording.running
            assert not recording.over
        whole = robot.recording
        assert whole is not None
        assert whole.running
    assert whole.over
    assert "ended" in repr(whole)
    for path in (whole.path, recording.path):
        assert data(read(path), "/tasks")[-1]["outcome"] == "FINISHED"


@pytest.mark.slow
async def test_a_disk_that_hangs_delays_no_call_and_what_is_dropped_is_counted(
    robot: aioduco.Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gate, wrote = threading.Event(), threading.Event()
    write = os.write

    def hang(file: int, some: Any) -> int:
        if threading.current_thread().name == "aioduco-recording":
            wrote.set()
            gate.wait(60.0)
        written: int = write(file, some)
        return written

    async with robot.record(tmp_path / "run.mcap") as recording:
        monkeypatch.setattr(os, "write", hang)
        monkeypatch.setattr(writer, "_QUEUE_LIMIT", 10)
        await eventually_async(wrote.is_set)
        for _ in range(30):
            await robot.io.get_standard_digital_out(1)
        assert recording.statistics().dropped >= 20
        gate.set()
        await eventually_async(lambda: recording.statistics().size > 5000)
    run = read(recording.path)
    assert run.complete
    assert len(data(run, "/commands")) <= 11


_FULL = """
import resource, signal, sys
import aioduco
import anyio

async def main(port, path):
    # without a heartbeat, which a busy machine may lose: then no motion is sent
    options = {"state_rate": 200, "record": path, "heartbeat": None}
    async with aioduco.connect("127.0.0.1", port, **options) as robot:
        figures = robot.recording.statistics
        while robot.feed.statistics().samples < 20:
            await anyio.sleep(0.001)
        before = figures().size
        while figures().size == before:  # a chunk with those states
            await anyio.sleep(0.001)
        full = figures().size + 5_000
        sys.dont_write_bytecode = True  # Python would cut off what it writes, too
        resource.setrlimit(resource.RLIMIT_FSIZE, (full, full))
        while robot.recording.running:
            await robot.state.get_robot_state()
            await anyio.sleep(0.001)
        await robot.motion.movej2([0, 0, 1.5, 0, -1.5, 0], v=1.0, a=1.0)
        error = robot.recording.error
        assert isinstance(error, OSError), error
        print(type(error).__name__, figures().size, full, figures().written)

anyio.run(main, int(sys.argv[1]), sys.argv[2])
"""


@pytest.mark.slow
def test_a_full_disk_ends_the_recording_and_not_the_program(bench: Bench, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    done = python("-c", _FULL, str(bench.port), str(path))
    assert done.returncode == 0, done.stderr
    assert "ended early" in done.stderr
    name, size, full, written = done.stdout.split()
    assert name == "OSError"
    # It is cut off behind its last whole chunk.
    assert path.stat().st_size == int(size) <= int(full)
    run = read(path)
    assert not run.complete
    assert run.topics["/joint_states"] > 10
    assert sum(run.topics.values()) == int(written)


_KILLED = """
import sys
import aioduco
import anyio

async def main(port, path):
    async with aioduco.connect("127.0.0.1", port, state_rate=200, record=path) as robot:
        with robot.feed.subscribe() as samples:
            async for _ in samples:
                # whose size is noted first
                saved = robot.recording._file._saved
                print(robot.recording.statistics().size, saved, flush=True)

anyio.run(main, int(sys.argv[1]), sys.argv[2])
"""


#: samples after which its program is killed: the first one, then at random over some chunks;
#: `benchmarks/recording.py` kills a hundred
_MOMENTS = [1, *(random.Random(number).randint(2, 400) for number in range(5))]


@pytest.mark.slow
@pytest.mark.parametrize("lines", _MOMENTS)
def test_what_was_written_before_a_kill_is_read(bench: Bench, tmp_path: Path, lines: int) -> None:
    """How much that is depends on the machine: `benchmarks/recording.py` measures it."""
    path = tmp_path / "run.mcap"
    command = [sys.executable, "-c", _KILLED, str(bench.port), str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        told = [program.stdout.readline() for _ in range(lines)]
        program.kill()
    size, saved = map(int, told[-1].split())
    assert path.stat().st_size >= size
    run = read(path)
    assert not run.complete
    assert run.metadata["address"].endswith(str(bench.port))
    # no clock: the two programs may stand still for any time
    assert sum(run.topics.values()) >= saved
    assert run.topics.get("/joint_states", 0) > 0 or not saved


@pytest.mark.slow
def test_an_interpreter_that_ends_with_a_recording_ends_it(bench: Bench, tmp_path: Path) -> None:
    code = (
        "import aioduco.sync, os, sys\n"
        f"robot = aioduco.sync.connect('127.0.0.1', {bench.port})\n"
        "robot.open()\n"
        f"recording = robot.record({str(tmp_path / 'run.mcap')!r}).start()\n"
        "robot.io.get_standard_digital_out(1)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=100, capture_output=True)
    eventually((tmp_path / "run.mcap").exists)
    run = read(tmp_path / "run.mcap")
    assert run.complete
    assert data(run, "/commands")[0]["function"] == "get_standard_digital_out"


async def test_what_an_observer_raises_stands_between_nothing(
    bench: Bench, robot: aioduco.Robot, caplog: pytest.LogCaptureFixture
) -> None:
    def fails(_: object) -> None:
        raise ZeroDivisionError

    end = robot._supervisor.observe(fails, fails)
    task = await under_way(bench, robot)
    await robot.stop()
    with pytest.raises(TaskStopped):
        await task
    assert not bench.moving()
    end()
    await eventually_async(lambda: "an observer failed" in caplog.text)


def test_times_without_samples_count_where_the_arm_moved() -> None:
    gaps = MovingGaps()
    q = [0.0] * 6
    gaps.sampled(1.0, q)
    gaps.sampled(9.0, q)  # it stood: nothing is missing
    assert (gaps.longest, gaps.count) == (0.0, 0)
    gaps.sampled(9.05, [0.0] * 5 + [0.1])
    assert gaps.longest == pytest.approx(0.05)
    assert gaps.count == 0
    gaps.sampled(9.25, [0.0] * 5 + [0.2])
    assert gaps.longest == pytest.approx(0.2)
    assert gaps.count == 1
    gaps.sampled(9.26, [0.0] * 5 + [0.21])
    assert gaps.longest == pytest.approx(0.2)
