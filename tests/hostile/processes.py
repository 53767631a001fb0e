"""What starts each process of this package: bodies of programs, to be formatted."""

from __future__ import annotations

GUARD = """
    async with aioduco.connect({host!r}, {port}, guard="process") as robot:
        await robot.motion.movej2({HOME}, v=1.0, a=1.0)
"""
STREAM = """
    async with aioduco.connect({host!r}, {port}) as robot:
        async with robot.servo.joints(v=1.0, a=5.0, rate=100) as stream:
            await stream.send({HOME})
"""
PLANNER = """
    from aioduco.planning import Planner, Scene
    async with Planner(Scene()) as planner:
        await planner.plan({HOME}, aioduco.Joints.of({HOME}))
"""
PICTURES = """
    from aioduco.planning import Scene
    assert Scene().picture({HOME}, width=20, height=20).shape == (20, 20, 3)
"""
SIMULATOR = """
    from aioduco.sim.simulator import Simulator
    async with Simulator.spawn() as sim:
        assert sim.port
"""
TAP = """
    from aioduco.recording.tap import Tap
    with Tap({host!r}, {port}) as tap:
        async with aioduco.connect(tap.host, tap.port) as robot:
            await robot.motion.movej2({HOME}, v=1.0, a=1.0)
"""
