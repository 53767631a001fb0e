"""The examples of other systems, tested with the clients of these systems."""

from __future__ import annotations

import asyncio
import json
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import AsyncIterator, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import anyio
import pytest
from example_modules import EXAMPLES, example
from ports import free_port

import aioduco
from aioduco.sim import Simulator
from aioduco.testing import FaultProxy, HalfOpen, HoldReply, eventually, eventually_async

FAR = [1.5, -0.2, 1.4, 0.0, -1.5, 0.0]

pytestmark = pytest.mark.slow


def need(name: str) -> Any:
    return pytest.importorskip(name, reason="needs pip install 'aioduco[examples]'")


@pytest.fixture
def sim() -> Iterator[Simulator]:
    with Simulator() as sim:
        yield sim


@pytest.fixture
async def robot(sim: Simulator) -> AsyncIterator[aioduco.Robot]:
    async with aioduco.connect(sim.host, sim.port) as robot:
        await robot.bring_up()
        yield robot


def test_a_web_service_with_a_stop(sim: Simulator) -> None:
    need("fastapi")
    client_of = need("starlette.testclient").TestClient
    with client_of(example("service_fastapi").service(sim.host, sim.port)) as client:
        assert client.get("/state").json()["robot"] == "ENABLE"
        assert client.post("/move", json={"to": "nowhere"}).status_code == 404
        assert client.post("/move", json={"to": "left", "v": 99}).status_code == 422
        assert client.post("/move", json={"to": "left", "v": 0.2}).status_code == 202
        eventually(lambda: sim.view.moving)
        assert client.post("/move", json={"to": "home"}).status_code == 409
        assert client.post("/stop").json() == {"arm": "stands"}
        assert not sim.view.moving
        eventually(lambda: not client.get("/state").json()["tasks"])
        assert client.get("/state").json()["last"]["state"] == "STOPPED"
    assert not sim.view.moving


def test_a_web_service_starts_one_of_several_motions_that_are_asked_for_at_once(
    sim: Simulator,
) -> None:
    need("fastapi")
    client_of = need("starlette.testclient").TestClient
    with client_of(example("service_fastapi").service(sim.host, sim.port)) as client:

        def move(to: str) -> int:
            return int(client.post("/move", json={"to": to, "v": 0.1}).status_code)

        with ThreadPoolExecutor(6) as threads:
            answers = list(threads.map(move, ["left", "right", "home"] * 2))
    assert sorted(answers) == [202, *[409] * 5]


async def test_a_web_service_starts_nothing_that_was_asked_for_before_a_stop(
    sim: Simulator,
) -> None:
    need("fastapi")
    httpx = need("httpx")
    with FaultProxy(sim.host, sim.port) as proxy:
        app = example("service_fastapi").service(proxy.host, proxy.port)
        client = httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://arm")
        async with app.router.lifespan_context(app), client:
            proxy.on("movej2", HalfOpen(seconds=0.5))
            moves = []
            for to in ("left", "right"):  # the second one waits for the first one
                moves.append(asyncio.create_task(client.post("/move", json={"to": to})))
                await eventually_async(lambda: proxy.calls("movej2"))
                await anyio.wait_all_tasks_blocked()
            assert (await client.post("/stop")).json() == {"arm": "stands"}
            answers = [(await move).status_code for move in moves]
            assert answers == [503, 503]
            assert len(proxy.calls("movej2")) == 1
            assert not sim.view.moving


def test_a_client_that_never_ends_its_request_does_not_keep_the_arm_moving(sim: Simulator) -> None:
    need("uvicorn")
    httpx = need("httpx")
    port = free_port()
    program = f"import service_fastapi; service_fastapi.serve({sim.host!r}, {sim.port}, {port})"

    def accepted() -> bool:
        try:
            answer = httpx.post(f"http://127.0.0.1:{port}/move", json={"to": "left", "v": 0.02})
        except httpx.TransportError:
            return False
        return bool(answer.status_code == 202)

    with subprocess.Popen([sys.executable, "-c", program], cwd=EXAMPLES) as served:
        eventually(accepted)
        eventually(lambda: sim.view.moving)
        with socket.create_connection(("127.0.0.1", port)) as client:
            client.sendall(b"POST /move HTTP/1.1\r\nHost: arm\r\nContent-Length: 9\r\n\r\n{")
            served.send_signal(signal.SIGINT)
            assert served.wait(15.0) == 0
            assert not sim.view.moving


async def says(variable: Any, text: str) -> None:
    """Until a variable of the server has a text with this in it."""
    while not (value := await variable.read_value()) or text not in value:  # noqa: ASYNC110 - only asking tells
        await asyncio.sleep(0)


def opc_ua_client(endpoint: str) -> Any:
    """A client that waits for a busy machine.

    Its watchdog asks the server, too: it is answered behind the calls of its session.
    """
    client_of = need("asyncua.client.client").Client
    return client_of(endpoint, timeout=60.0, watchdog_intervall=60.0)


async def test_an_opc_ua_client_moves_and_stops_it(robot: aioduco.Robot, sim: Simulator) -> None:
    need("asyncua")
    module = example("server_opcua")
    endpoint = f"opc.tcp://127.0.0.1:{free_port()}"
    async with module.served(robot, endpoint), opc_ua_client(endpoint) as client:
        await (
            robot.rearm_heartbeat()
        )  # making the server holds the loop, on a busy machine for long
        space = await client.get_namespace_index(module.NAMESPACE)
        arm = await client.nodes.objects.get_child(f"{space}:Arm")
        refused = await arm.call_method(f"{space}:Move", FAR[:5], 0.3)
        assert "6" in refused or "six" in refused
        assert await arm.call_method(f"{space}:Move", FAR, 0.3) == ""
        moving = await arm.get_child(f"{space}:Moving")
        while not await moving.read_value():  # noqa: ASYNC110 - only asking tells
            await asyncio.sleep(0)
        await arm.call_method(f"{space}:Stop")
        assert not sim.view.moving
        state = await arm.get_child(f"{space}:State")
        assert await state.read_value() == "ENABLE"
        failed = await arm.get_child(f"{space}:Failed")
        await says(failed, "stopped")
        # accepted by the controller, which tells by the motion's end that it is not carried out
        sim.emergency_stop()
        await eventually_async(lambda: sim.view.emergency_stop)
        assert await arm.call_method(f"{space}:Move", FAR, 0.3) == ""
        await says(failed, "not allowed")


async def test_an_opc_ua_server_that_held_the_loop_moves_the_arm(
    sim: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It counted as hung, and all motions were refused from then on."""
    need("asyncua.client.client")
    module = example("server_opcua")
    async with aioduco.connect(sim.host, sim.port, loop_stall_limit=2.0, heartbeat=20.0) as robot:
        await robot.bring_up()

        class Holding(module.Server):  # type: ignore[misc, name-defined]  # of a module that is loaded
            async def init(self) -> None:
                await super().init()
                while (beats := robot.statistics().heartbeat) is None or not beats.stalls:
                    pass

        monkeypatch.setattr(module, "Server", Holding)
        async with module.served(robot, f"opc.tcp://127.0.0.1:{free_port()}"):
            await robot.motion.movej2(FAR, v=3.0, a=10.0)


async def test_an_opc_ua_client_s_stop_does_not_wait_for_the_answer_to_its_move(
    sim: Simulator,
) -> None:
    """The calls of a session are served one after the other."""
    need("asyncua")
    module = example("server_opcua")
    endpoint = f"opc.tcp://127.0.0.1:{free_port()}"
    with FaultProxy(sim.host, sim.port) as proxy:
        async with aioduco.connect(proxy.host, proxy.port, call_timeout=60.0) as robot:
            await robot.bring_up()
            async with module.served(robot, endpoint), opc_ua_client(endpoint) as client:
                await robot.rearm_heartbeat()  # as above
                space = await client.get_namespace_index(module.NAMESPACE)
                arm = await client.nodes.objects.get_child(f"{space}:Arm")
                proxy.on("movej2", HoldReply())
                move = asyncio.create_task(arm.call_method(f"{space}:Move", FAR, 0.3))
                await eventually_async(lambda: sim.view.moving)
                stop = asyncio.create_task(arm.call_method(f"{space}:Stop"))
                await eventually_async(lambda: proxy.calls("stop") and not sim.view.moving)
                assert not stop.done()  # the answer that is missing may still begin the motion
                proxy.cut()
                await stop
                assert await move == ""
                await says(await arm.get_child(f"{space}:Failed"), "")


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[int]:
    """An MQTT broker of another maker; its port."""
    need("amqtt")
    program = shutil.which("amqtt", path=str(Path(sys.executable).parent))
    assert program is not None
    port = free_port()
    config = tmp_path / "broker.yaml"
    config.write_text(
        f"listeners:\n  default:\n    type: tcp\n    bind: 127.0.0.1:{port}\n"
        "plugins:\n  amqtt.plugins.authentication.AnonymousAuthPlugin:\n"
        "    allow_anonymous: true\n",
        encoding="utf-8",
    )
    with subprocess.Popen(
        [program, "-c", str(config)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as process:
        try:
            eventually(lambda: _listens(port), 60.0)
            yield port
        finally:
            process.kill()


def _listens(port: int) -> bool:
    with socket.socket() as sock:
        return sock.connect_ex(("127.0.0.1", port)) == 0


async def test_a_broker_is_told_and_stops_it(
    broker: int, robot: aioduco.Robot, sim: Simulator
) -> None:
    aiomqtt = need("aiomqtt")
    module = example("telemetry_mqtt")
    bridge = asyncio.create_task(module.bridge(robot, "127.0.0.1", broker))
    try:
        async with aiomqtt.Client("127.0.0.1", broker) as client:
            await client.subscribe("duco/#")
            told: dict[str, Any] = {}
            async for message in client.messages:
                told[str(message.topic)] = message.payload
                if {"duco/joints", "duco/state"} <= set(told):
                    break
            assert json.loads(told["duco/state"])[0] == "ENABLE"
            assert json.loads(told["duco/joints"]) == pytest.approx(sim.joints.array, abs=1e-2)
            task = await robot.motion.movej2(FAR, v=0.2, a=1.0).start()
            await eventually_async(lambda: sim.view.moving)
            await client.publish("duco/stop", qos=1)
            with pytest.raises(aioduco.TaskStopped):
                await task
            assert not sim.view.moving
    finally:
        bridge.cancel()
        with pytest.raises(asyncio.CancelledError):
            await bridge
