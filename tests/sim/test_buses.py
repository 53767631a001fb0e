"""RS-485, CAN and Modbus, with scripted peers (manual 1.3.6 and 1.3.9)."""

from __future__ import annotations

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from aioduco.models.enums import TaskState
from aioduco.sim.cabinet.modbus import ModbusSlave, RtuSlave, ScriptedGripper, crc16
from aioduco.sim.cabinet.ports import CanPort, SerialPort
from aioduco.sim.simulator import Simulator

from .conftest import Aside, Connect, Program


@pytest.fixture
def program(sim: Simulator, connect: Connect) -> Program:
    """A program whose robot has no power: none of this needs any."""
    return connect(sim)


class Echo:
    """Sends back what it gets."""

    def receive(self, data: bytes) -> bytes:
        return data


class Node:
    """Answers each CAN frame by one with the next identifier."""

    def receive(self, id: int, data: bytes) -> list[tuple[int, bytes]]:  # noqa: A002 - CAN's name
        return [(id + 1, data[::-1])]


def signed(data: bytes) -> list[int]:
    return [byte - 256 if byte > 127 else byte for byte in data]


def rtu(body: bytes) -> bytes:
    return body + crc16(body)


# -- serial --------------------------------------------------------------------------------------


@pytest.mark.parametrize("tool", [False, True])
def test_bytes_go_to_the_peer_and_its_answer_is_read(
    sim: Simulator, program: Program, tool: bool
) -> None:
    prefix = "tool_" if tool else ""
    (sim.cabinet.tool_serial if tool else sim.cabinet.serial).peer = Echo()

    def call(name: str, *args: object) -> object:
        return getattr(program, prefix + name)(*args)

    assert call("read_raw_data_485", 10) == []
    assert call("write_raw_data_485", [-1, 1, 2]) is True
    assert call("read_raw_data_485", 2) == [-1, 1]
    assert call("read_raw_data_485", 2) == [2]
    assert call("write_raw_data_485_h", [1, 2, 3], [-1, -1]) is True
    assert call("read_raw_data_485_h", [-1, -1], 6) == []
    assert call("read_raw_data_485_h", [-1, -1], 5) == [-1, -1, 1, 2, 3]
    assert call("write_raw_data_485_ht", [1, 2], [-1, 1], [1, -1]) is True
    assert call("read_raw_data_485_ht", [-1, 1], [1, -1]) == [-1, 1, 1, 2, 1, -1]
    assert call("write_data_485", [5, 6]) is True
    assert call("read_data_485") == [5, 6]
    assert call("write_raw_data_485", []) is False


def test_frames_are_found_behind_other_bytes_and_wait_until_they_are_complete() -> None:
    port = SerialPort()
    port.arrive(b"..<ab")
    assert port.read_between(b"<", b">") == b""
    assert port.read_framed(b"<", 4) == b""
    port.arrive(b">rest")
    assert port.read_between(b"<", b">") == b"<ab>"
    assert port.read_framed(b"st", 2) == b"st"
    assert (port.read_framed(b"", 1), port.read_between(b"", b">"), port.read(-1)) == (b"",) * 3
    port.arrive(b"x" * 5000)
    assert len(port.read()) == 4096


def test_an_answer_may_take_its_time(sim: Simulator, program: Program) -> None:
    port = SerialPort()
    port.peer, port.delay = Echo(), 0.1
    assert port.write(b"a", 5.0)
    assert port.write(b"b", 5.05)
    port.advance(5.09)
    assert port.read() == b""
    port.advance(5.1)
    assert port.read() == b"a"
    port.advance(6.0)
    assert port.read() == b"b"
    sim.cabinet.tool_serial.peer, sim.cabinet.tool_serial.delay = Echo(), 0.12
    begin = sim.time
    program.tool_write_data_485([7])
    sim.wait_until(lambda: program.tool_read_data_485() == [7])
    assert sim.time - begin > 0.11


@pytest.mark.parametrize("name", ["set_baudrate_485", "set_baudrate_can"])
def test_rates_are_set(sim: Simulator, program: Program, name: str) -> None:
    assert getattr(program, name)(9600, True) == TaskState.FINISHED
    assert getattr(program, name)(0, True) == TaskState.PARAMETER_MISMATCH
    port = sim.cabinet.serial.baudrate if name.endswith("485") else sim.cabinet.can.bitrate
    assert port == 9600


# -- CAN -----------------------------------------------------------------------------------------


def test_can_frames_need_somebody_who_acknowledges_them(sim: Simulator, program: Program) -> None:
    assert program.write_raw_data_can(5, [1, 2]) is False
    sim.cabinet.can.peer = Node()
    assert program.read_raw_data_can() == []
    assert program.write_raw_data_can(5, [1, -2]) is True
    assert program.read_raw_data_can() == [6, -2, 1]
    assert program.write_data_can(0x1FF, []) is True
    assert program.read_data_can() == [0]  # 0x200: the lowest byte
    for id_, data in ((-1, [1]), (2**29, [1]), (1, [0] * 9)):
        assert program.write_raw_data_can(id_, data) is False
    with pytest.raises(ValueError, match="no CAN frame"):
        CanPort().arrive(1, bytes(9))


# -- Modbus RTU ----------------------------------------------------------------------------------


def test_a_slave_answers_frames_of_its_unit() -> None:
    slave = RtuSlave(
        3,
        coils={0: True, 1: False, 2: True},
        inputs={7: True},
        registers={1: 2, 2: 0},
        input_registers={5: 9},
    )
    answers = {
        bytes([3, 1, 0, 0, 0, 3]): bytes([3, 1, 1, 0b101]),
        bytes([3, 2, 0, 7, 0, 1]): bytes([3, 2, 1, 1]),
        bytes([3, 3, 0, 1, 0, 2]): bytes([3, 3, 4, 0, 2, 0, 0]),
        bytes([3, 4, 0, 5, 0, 1]): bytes([3, 4, 2, 0, 9]),
        bytes([3, 5, 0, 1, 255, 0]): bytes([3, 5, 0, 1, 255, 0]),
        bytes([3, 6, 0, 1, 1, 2]): bytes([3, 6, 0, 1, 1, 2]),
        bytes([3, 15, 0, 0, 0, 3, 1, 0b010]): bytes([3, 15, 0, 0, 0, 3]),
        bytes([3, 16, 0, 1, 0, 2, 4, 0, 5, 0, 6]): bytes([3, 16, 0, 1, 0, 2]),
        bytes([3, 3, 0, 9, 0, 1]): bytes([3, 0x83, 2]),
        bytes([3, 3, 0, 1, 0, 0]): bytes([3, 0x83, 3]),
        bytes([3, 5, 0, 1, 1, 0]): bytes([3, 0x85, 3]),
        bytes([3, 99, 0, 0]): bytes([3, 99 | 0x80, 1]),
    }
    for request, answer in answers.items():
        assert slave.receive(rtu(request)) == rtu(answer)
    assert slave.coils == {0: False, 1: True, 2: False}
    assert slave.registers == {1: 5, 2: 6}
    assert slave.receive(rtu(bytes([4, 3, 0, 1, 0, 1]))) is None
    assert slave.receive(bytes([3, 3, 0, 1, 0, 1, 0, 0])) is None
    assert slave.receive(rtu(bytes([0, 6, 0, 1, 0, 7]))) is None
    assert slave.registers[1] == 7


def test_the_checksum_is_that_of_the_specification() -> None:
    assert crc16(bytes([2, 7])) == bytes([0x41, 0x12])


@example(bytes([0, 0, 0, 1]), 15)
@given(st.binary(max_size=12), st.integers(0, 20))
def test_a_slave_has_an_answer_to_everything(body: bytes, function: int) -> None:
    answer = RtuSlave(1, registers={0: 0}).receive(rtu(bytes([1, function]) + body))
    assert answer is not None
    assert crc16(answer[:-2]) == answer[-2:]


def test_a_gripper_at_the_tool(sim: Simulator, program: Program) -> None:
    gripper = ScriptedGripper(object_at=400)
    sim.cabinet.tool_serial.peer = gripper

    def ask(*body: int) -> bytes:
        assert program.tool_write_raw_data_485(signed(rtu(bytes(body))))
        return bytes(octet & 0xFF for octet in program.tool_read_raw_data_485(64))

    ask(1, 6, 1, 3, 0, 0)
    assert ask(1, 3, 2, 0, 0, 3) == rtu(bytes([1, 3, 6] + [0] * 6))
    ask(1, 6, 1, 0, 0, 1)
    ask(1, 6, 1, 3, 0, 0)
    assert ask(1, 3, 2, 0, 0, 3) == rtu(bytes([1, 3, 6, 0, 1, 0, 2, 1, 0x90]))
    ask(1, 6, 1, 3, 3, 0xE8)
    assert gripper.registers[ScriptedGripper.ACTUAL] == 1000
    assert ask(1, 6, 2, 2, 0, 1) == rtu(bytes([1, 0x86, 2]))


def test_the_error_register_of_a_dh_gripper() -> None:
    with Simulator(gripper="dh_pge", speed=math.inf) as sim:
        peer = sim.cabinet.tool_serial.peer
        assert peer is not None
        # written and read at once, as a program for a PGEA-50-26 does
        assert peer.receive(rtu(bytes([1, 6, 1, 0, 0, 0xA5]))) == rtu(bytes([1, 6, 1, 0, 0, 0xA5]))
        assert peer.receive(rtu(bytes([1, 3, 2, 5, 0, 1]))) == rtu(bytes([1, 3, 2, 0, 0]))


# -- the controller's Modbus ---------------------------------------------------------------------


def test_signals_of_the_controllers_modbus(sim: Simulator, program: Program) -> None:
    slave = ModbusSlave(
        coils={1: False, 2: False}, inputs={1: True}, registers={7: 1, 8: 2}, input_registers={3: 4}
    )
    sim.cabinet.modbus.slaves["10.0.0.5", 2] = slave
    for kind, (name, address) in enumerate((("in", 1), ("coil", 1), ("word", 3), ("reg", 7))):
        assert program.modbus_add_signal("10.0.0.5", 2, address, kind, name) == TaskState.FINISHED
    assert [program.modbus_read(name) for name in ("in", "coil", "word", "reg")] == [1, 0, 4, 1]
    assert program.modbus_write("reg", 65535) == TaskState.FINISHED
    assert program.modbus_write("coil", 1) == TaskState.FINISHED
    assert (slave.registers[7], slave.coils[1]) == (65535, True)
    assert [program.modbus_read(name) for name in ("coil", "reg")] == [1, 65535]
    assert program.modbus_write_multiple_regs(2, "reg", 2, [-1, 5]) == TaskState.FINISHED
    assert slave.registers == {7: 65535, 8: 5}
    assert program.modbus_write_multiple_coils(2, "coil", 2, [0, 1]) == TaskState.FINISHED
    assert slave.coils == {1: False, 2: True}
    mismatches = [
        program.modbus_write("reg", 65536),
        program.modbus_write("coil", 2),
        program.modbus_write("in", 1),
        program.modbus_write_multiple_regs(2, "reg", 3, [1, 2]),
        program.modbus_add_signal("10.0.0.5", 2, 1, 9, "new"),
        program.modbus_add_signal("10.0.0.5", 2, 1, 0, "in"),
        program.modbus_add_signal("10.0.0.5", 2, 1, 0, ""),
        program.modbus_add_signal("10.0.0.5", 2, 70000, 0, "far"),
    ]
    assert mismatches == [TaskState.PARAMETER_MISMATCH] * len(mismatches)
    failed = [
        program.modbus_write_multiple_regs(2, "reg", 3, [1, 2, 3]),
        program.modbus_write_multiple_regs(1, "reg", 2, [1, 2]),
        program.modbus_write_multiple_coils(2, "reg", 1, [1]),
    ]
    assert failed == [TaskState.ERROR] * len(failed)
    assert slave.registers == {7: 65535, 8: 5}
    assert program.modbus_delete_signal("reg") == TaskState.FINISHED
    assert program.modbus_delete_signal("reg") == TaskState.ERROR
    assert program.modbus_write("reg", 1) == TaskState.ERROR
    assert program.modbus_read("reg") == -1
    assert "no Modbus signal 'reg'" in program.get_last_error()[-1]


def test_one_name_leads_to_registers_and_coils_as_the_manual_prints_it(
    sim: Simulator, program: Program
) -> None:
    one = ModbusSlave(registers=dict.fromkeys(range(10, 15), 0))
    two = ModbusSlave(coils=dict.fromkeys(range(10, 15), False))
    sim.cabinet.modbus.slaves |= {("10.0.0.7", 1): one, ("10.0.0.7", 2): two}
    program.modbus_add_signal("10.0.0.7", 1, 10, 3, "mbus1")
    assert program.modbus_write_multiple_regs(1, "mbus1", 5, [1, 2, 3, 4, 5]) == 4
    assert program.modbus_write_multiple_coils(2, "mbus1", 5, [1] * 5) == 4
    assert list(one.registers.values()) == [1, 2, 3, 4, 5]
    assert all(two.coils.values())


def test_a_slave_that_is_away_does_not_answer(sim: Simulator, program: Program) -> None:
    program.modbus_add_signal("10.0.0.9", 1, 0, 3, "away")
    assert program.modbus_write("away", 1) == TaskState.ERROR
    assert program.modbus_read("away") == -1
    assert "does not answer" in program.get_last_error()[-1]


class EmergencyStopper(ModbusSlave):
    """Presses the emergency stop when a register is written, as a safety controller may."""

    def __init__(self, sim: Simulator) -> None:
        super().__init__(registers={0: 0})
        self.sim = sim

    def write_registers(self, address: int, values: list[int]) -> None:
        super().write_registers(address, values)
        self.sim.emergency_stop()


def test_a_slave_may_act_on_the_simulator(sim: Simulator, aside: Aside) -> None:
    sim.cabinet.modbus.slaves["10.0.0.5", 1] = EmergencyStopper(sim)

    def write(program: Program) -> int:
        program.modbus_add_signal("10.0.0.5", 1, 0, 3, "stop")
        return program.modbus_write("stop", 1)

    assert aside(sim, write).result() == TaskState.FINISHED
    assert sim.view.emergency_stop


def test_a_simulator_that_is_started_again_has_no_times_of_the_run_before(
    connect: Connect,
) -> None:
    slave, simulator = ModbusSlave(registers={0: 1}), Simulator(speed=math.inf)
    cabinet = simulator.cabinet
    cabinet.modbus.slaves["10.0.0.5", 1] = slave
    cabinet.serial.peer, cabinet.serial.delay = Echo(), 0.5
    with simulator as sim:
        program = connect(sim)
        program.modbus_add_signal("10.0.0.5", 1, 0, 3, "word")
        sim.wait_until(lambda: sim.time > 1.0)
        assert program.modbus_read("word") == 1
        assert program.set_load_data([2.0, 0.0, 0.0, 0.0]) == TaskState.FINISHED
        program.write_raw_data_485([1])
    slave.registers[0] = 2
    with simulator as sim:
        program = connect(sim)
        assert program.modbus_read("word") == 2
        program.write_raw_data_485([2])
        began = sim.time
        sim.wait_until(lambda: sim.time > began + 0.5)
        assert program.read_raw_data_485(9) == [2]
        assert cabinet.held.mass == 0.0  # the arm carries nothing yet, either


def test_signals_are_read_at_their_frequency(sim: Simulator, program: Program) -> None:
    slave = ModbusSlave(registers={0: 1})
    sim.cabinet.modbus.slaves["10.0.0.5", 1] = slave
    modbus = sim.cabinet.modbus
    program.modbus_add_signal("10.0.0.5", 1, 0, 3, "reg")
    program.modbus_set_frequency("reg", 50)
    assert modbus.read("reg", 100.0) == 1
    slave.registers[0] = 2
    assert modbus.read("reg", 100.019) == 1
    assert modbus.read("reg", 100.021) == 2
    program.modbus_set_frequency("reg", 101)
    assert sim.view.errors[-1].startswith("modbus_set_frequency: frequency is 101")
