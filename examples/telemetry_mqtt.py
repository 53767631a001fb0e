"""What an arm does, to an MQTT broker; and a stop from there.

    python telemetry_mqtt.py BROKER[:PORT]                      of a simulated arm
    python telemetry_mqtt.py BROKER[:PORT] 192.168.1.10         of a real one

Publishes `duco/joints` ten times a second, and `duco/state` and `duco/event` as they change, the
last state retained. A message on `duco/stop` stops the arm. The broker may go away and come back:
the arm does not wait for it. It is no emergency stop. Needs aiomqtt.
"""

from __future__ import annotations

import argparse
import json

import aiomqtt
import anyio

import aioduco

RATE = 10  # a second
AGAIN = 2.0  # seconds until a broker that is gone is tried again


async def publish_samples(robot: aioduco.Robot, broker: aiomqtt.Client) -> None:
    """Joints at a rate, states when they change."""
    last = None
    with robot.feed.subscribe() as samples:
        async for sample in samples:
            joints = [round(angle, 5) for angle in sample.status.joints]
            await broker.publish("duco/joints", json.dumps(joints))
            states = [sample.states.robot.name, sample.states.safety.name]
            if states != last:
                last = states
                await broker.publish("duco/state", json.dumps(states), qos=1, retain=True)


async def publish_events(robot: aioduco.Robot, broker: aiomqtt.Client) -> None:
    """What happens to the robot."""
    with robot.events.subscribe() as events:
        async for event in events:
            await broker.publish("duco/event", f"{type(event).__name__}", qos=1)


async def take_stops(robot: aioduco.Robot, broker: aiomqtt.Client) -> None:
    """Stop the arm when somebody says so."""
    await broker.subscribe("duco/stop", qos=1)
    async for _ in broker.messages:
        await robot.stop()
        print("stopped")


async def bridge(robot: aioduco.Robot, host: str, port: int) -> None:
    """Be at the broker, and come back to it."""
    while True:
        try:
            async with aiomqtt.Client(host, port) as broker, anyio.create_task_group() as tasks:
                print("at the broker")
                for part in (publish_samples, publish_events, take_stops):
                    tasks.start_soon(part, robot, broker)
        except* aiomqtt.MqttError as group:
            print(f"no broker: {group.exceptions[0]}")
        await anyio.sleep_until(anyio.current_time() + AGAIN)


async def main(broker: str, host: str, port: int) -> None:
    where, _, number = broker.partition(":")
    async with aioduco.connect(host, port, state_rate=RATE) as robot:
        await robot.bring_up()
        await bridge(robot, where, int(number or 1883))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("broker")
    parser.add_argument("host", nargs="?")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        anyio.run(main, given.broker, given.host, given.port)
    else:
        from aioduco.sim import Simulator

        with Simulator() as sim:
            anyio.run(main, given.broker, sim.host, sim.port)
