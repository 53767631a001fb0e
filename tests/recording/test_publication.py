"""A robot published live: what a reader gets, and that no reader delays the program.

The watcher is another maker's client of WebSocket, which reads by the schemas that it is sent.
"""

from __future__ import annotations

import base64
import json
import logging
import socket
import struct
import threading
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from client.bench import HOME, Bench
from for_each import for_each
from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Subprotocol

import aioduco
import aioduco.sync
from aioduco.recording import Publication, read
from aioduco.testing import eventually_async
from recording.mcap_records import decoded

_DATA = struct.Struct("<BIQ")


class Watcher:
    """Reads channels as Foxglove does."""

    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection
        self.name = ""
        self.channels: dict[str, dict[str, Any]] = {}

    async def greet(self, topics: set[str]) -> None:
        """Hear what there is, until all of the topics are offered."""
        while not topics <= self.channels.keys():
            said = json.loads(await self._connection.recv())
            if said["op"] == "serverInfo":
                self.name = said["name"]
                assert said["capabilities"] == [], "watchers only watch"
            elif said["op"] == "advertise":
                self.channels |= {each["topic"]: each for each in said["channels"]}

    async def subscribe(self, *topics: str) -> None:
        """Ask for channels; messages then carry the number of their place here."""
        self._topics = topics
        wanted = [
            {"id": number, "channelId": self.channels[topic]["id"]}
            for number, topic in enumerate(topics)
        ]
        await self._connection.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))

    async def next(self) -> tuple[str, int, Any]:
        """The next message: its topic, its time [ns], and what it says."""
        while True:
            said = await self._connection.recv()
            if isinstance(said, str):
                continue
            kind, number, at = _DATA.unpack_from(said)
            assert kind == 1
            topic = self._topics[number]
            return topic, at, self._decoded(topic, said[_DATA.size :])

    def _decoded(self, topic: str, data: bytes) -> Any:
        channel = self.channels[topic]
        if channel["encoding"] == "json":
            return json.loads(data)
        return decoded(base64.b64decode(channel["schema"]), channel["schemaName"], data)


@asynccontextmanager
async def watching(publication: Publication, *topics: str) -> AsyncIterator[Watcher]:
    async with connect(
        publication.url, subprotocols=[Subprotocol("foxglove.sdk.v1")]
    ) as connection:
        watcher = Watcher(connection)
        await watcher.greet(set(topics))
        await watcher.subscribe(*topics)
        yield watcher


def publishers() -> list[str]:
    return [thread.name for thread in threading.enumerate() if "publication" in thread.name]


async def test_a_watcher_reads_what_the_robot_does(robot: aioduco.Robot, bench: Bench) -> None:
    topics = ("/joint_states", "/tf", "/state", "/io", "/commands", "/tasks")
    async with (
        robot.publish(0, forces=False) as publication,
        watching(publication, *topics) as watcher,
    ):
        assert watcher.name == f"aioduco {bench.host}:{bench.port}"
        await robot.motion.movej2(HOME, v=1.0, a=1.0)
        seen: dict[str, Any] = {}
        while seen.keys() < set(topics) or not seen["/tasks"]["done"]:
            topic, at, said = await watcher.next()
            seen[topic] = said
            assert abs(time.time_ns() - at) < 600e9, "times are the wall's"
    status = (await robot.feed.latest()).status
    joints = seen["/joint_states"].joints
    assert [joint.name for joint in joints] == [f"joint_{number}" for number in range(1, 7)]
    assert [joint.position for joint in joints] == pytest.approx([*status.joints], abs=1e-5)
    (tcp,) = [each for each in seen["/tf"].transforms if each.child_frame_id == "tcp"]
    place = [tcp.translation.x, tcp.translation.y, tcp.translation.z]
    assert place == pytest.approx([status.pose.x, status.pose.y, status.pose.z], abs=1e-5)
    assert seen["/state"]["robot"] == "ENABLE"
    assert seen["/io"]["digital_inputs"] == [True] * 16
    assert seen["/commands"]["function"] == "movej2"
    assert seen["/tasks"]["outcome"] == "FINISHED"


async def test_it_has_the_channels_of_a_recording(robot: aioduco.Robot, tmp_path: Path) -> None:
    """And both at once see forces until the last of them has ended."""
    async with robot.record(tmp_path / "run.mcap") as recording:
        async with robot.publish(0) as publication:
            await eventually_async(lambda: publication.statistics().sent > 3)
            async with watching(publication, "/joint_states") as watcher:
                offered = {name: one["schemaName"] for name, one in watcher.channels.items()}
        await robot.wait_for(lambda sample: sample.read_forces is not None)
        await eventually_async(lambda: recording.statistics().written > 10)
    run = read(recording.path)
    assert set(run.topics) <= offered.keys()
    assert offered["/joint_states"] == "foxglove.JointStates"
    assert offered["/log"] == "foxglove.Log"
    await robot.wait_for(lambda sample: sample.read_forces is None)


@pytest.mark.slow
async def test_a_watcher_that_reads_nothing_holds_up_nobody(robot: aioduco.Robot) -> None:
    publication = await robot.publish(0, forces=False).start()
    with socket.create_connection(("127.0.0.1", publication.port)) as deaf:
        deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        key = base64.b64encode(bytes(16)).decode()
        lines = ("GET / HTTP/1.1", "Host: x", "Upgrade: websocket", "Connection: Upgrade")
        more = (f"Sec-WebSocket-Key: {key}", "Sec-WebSocket-Version: 13")
        last = ("Sec-WebSocket-Protocol: foxglove.sdk.v1", "", "")
        deaf.sendall("\r\n".join((*lines, *more, *last)).encode())
        assert deaf.recv(12) == b"HTTP/1.1 101"
        async with watching(publication, "/log") as watcher:
            # far more than sockets and queues hold
            for number in range(300):
                publication.handler.emit(
                    logging.LogRecord("a", logging.INFO, "f", number, "x" * 100_000, (), None)
                )
            line = None
            while line != 299:
                _, _, said = await watcher.next()
                line = said.line
        await robot.io.get_standard_digital_out(1)
        await publication.stop()
        assert publication.over
        assert publication.error is None
    await eventually_async(lambda: not publishers())


async def test_nothing_of_a_publication_stays_behind(robot: aioduco.Robot) -> None:
    publication = robot.publish(0, forces=False)
    assert "not started" in repr(publication)
    async with publication:
        assert publishers() == ["aioduco-publication"]
        port = publication.port
        assert repr(publication) == f"<Publication ws://127.0.0.1:{port} running>"
        with pytest.raises(aioduco.RecordingError, match=f"127.0.0.1:{port}"):
            await robot.publish(port).start()
    await eventually_async(lambda: not publishers())
    # not the same port: another program of this computer may have it by now
    async with robot.publish(0, forces=False):
        assert publishers() == ["aioduco-publication"]
    supervisor = robot._supervisor
    assert not any(lane.observers for lane in supervisor.lanes)


@for_each("port, host", [(-1, "127.0.0.1"), (70_000, "127.0.0.1"), (0, "")])
async def test_what_cannot_be_listened_on_is_refused(port: int, host: str) -> None:
    with pytest.raises(aioduco.ParameterError):
        aioduco.connect("192.0.2.1").publish(port, host=host)


def test_a_program_that_waits_publishes_too(bench: Bench) -> None:
    with aioduco.sync.connect(bench.host, bench.port, heartbeat=None) as robot:
        with robot.publish(0, forces=False) as publication:
            assert publication.running
            assert publication.url == f"ws://127.0.0.1:{publication.port}"
            with socket.create_connection(("127.0.0.1", publication.port)):
                pass
        assert repr(publication) == f"<Publication {publication.url} ended>"
        assert publication.statistics().dropped == 0
