"""The bytes of input devices, and their dead-man switch; without a device."""

from __future__ import annotations

import fcntl
import io
import math
import os
import pty
import resource
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from for_each import for_each

from aioduco.devices.teleoperation import (
    GamepadDevice,
    InputDevice,
    JointTarget,
    KeyboardDevice,
    Reading,
    TeleopScale,
)
from aioduco.devices.teleoperation.devices import SpaceMouseDevice, _space_mouse, open_device
from aioduco.devices.teleoperation.gamepad import Gamepad
from aioduco.devices.teleoperation.keyboard import KEYS, Keyboard
from aioduco.devices.teleoperation.reading import STANDING
from aioduco.devices.teleoperation.spacemouse import SpaceMouse
from aioduco.errors import ParameterError
from aioduco.kinematics import arm
from aioduco.testing import eventually, no_leaks

READY = [0.0, 0.0, 1.57, 0.0, -1.57, 0.0]


def event(kind: int, number: int, value: int) -> bytes:
    """`struct js_event` of include/uapi/linux/joystick.h, in the machine's byte order."""
    return struct.pack("=IhBB", 12345, value, kind, number)


def report(number: int, *values: int) -> bytes:
    """A report of a SpaceMouse: its number, then little-endian s16."""
    return bytes([number]) + struct.pack(f"<{len(values)}h", *values)


# -- keyboard --------------------------------------------------------------------------------------


def test_a_key_leads_while_it_is_repeated_and_stands_soon_after_it_is_let_go() -> None:
    keys = Keyboard()
    keys.feed(b"w", 10.0)
    assert keys.reading(10.39) == Reading((1, 0, 0, 0, 0, 0), held=True)
    assert keys.reading(10.41) == Reading()
    for tick in range(20):
        keys.feed(b"w", 10.5 + 0.04 * tick)
    last = 10.5 + 0.04 * 19
    assert keys.reading(last + 0.14).held
    assert not keys.reading(last + 0.16).held


def test_each_of_the_six_directions_has_two_keys() -> None:
    assert np.array(sorted(KEYS.values())).tolist() == sorted(
        (sign * np.eye(6)[axis]).tolist() for axis in range(6) for sign in (1, -1)
    )


@for_each("data", [b" ", b"x", b"\x1b[A", b"\x1bOd", b"\x1b[1;5D", b"\xff"])
def test_any_other_key_stands_and_letters_of_arrows_are_no_keys(data: bytes) -> None:
    keys = Keyboard()
    keys.feed(b"w", 1.0)
    keys.feed(data, 1.01)
    assert keys.reading(1.02) == Reading()
    keys.feed(b"w", 1.1)
    assert keys.reading(1.2).held


@for_each("data", [b"q", b"Q", b"\x04", b""])
def test_q_and_the_end_of_the_terminal_end_it(data: bytes) -> None:
    keys = Keyboard()
    keys.feed(b"w", 1.0)
    keys.feed(data, 1.1)
    found = keys.reading(1.1)
    assert found.done


# -- gamepad ---------------------------------------------------------------------------------------


def test_sticks_count_only_while_a_shoulder_button_is_held() -> None:
    pad = Gamepad()
    pad.feed(event(2, 1, -32767) + event(2, 3, 16384), 0.0)
    assert pad.reading(0.0) == Reading()
    pad.feed(event(1, 5, 1), 0.1)
    found = pad.reading(100.0)
    assert found.held
    assert found.axes == pytest.approx((1, 0, 0, 0, 0, -(0.5 - 0.1) / 0.9), abs=1e-4)
    pad.feed(event(1, 5, 0), 100.1)
    assert pad.reading(100.1) == Reading()


def test_a_dead_man_that_was_down_at_the_opening_has_to_be_let_go_first() -> None:
    pad = Gamepad()
    pad.feed(event(0x81, 5, 1) + event(0x82, 1, -32767), 0.0)
    assert not pad.reading(0.0).held
    pad.feed(event(1, 5, 0) + event(1, 5, 1), 0.1)
    assert pad.reading(0.1).axes[0] == 1.0


def test_a_stick_at_rest_says_nothing_and_events_may_come_in_parts() -> None:
    pad = Gamepad()
    data = event(1, 4, 1) + event(2, 0, 3000) + event(2, 4, -32768) + event(1, 0, 1)
    for at in range(0, len(data), 3):
        pad.feed(data[at : at + 3], 0.0)
    assert pad.reading(0.0) == Reading((0, 0, 1, 0, 0, 0), held=True, pressed=frozenset({0}))


@for_each("data", [event(1, 7, 1), b""])
def test_start_or_an_unplugged_gamepad_ends_it(data: bytes) -> None:
    pad = Gamepad()
    pad.feed(event(1, 5, 1), 0.0)
    pad.feed(data, 0.1)
    assert pad.reading(0.1).done


# -- SpaceMouse ------------------------------------------------------------------------------------


def test_a_cap_pushed_forward_left_and_up_leads_so() -> None:
    mouse = SpaceMouse(width=0.0)
    mouse.feed(report(1, -350, -175, -70), 0.0)  # to the right, towards the person, down
    mouse.feed(report(2, 35, 0, 0), 0.0)
    found = mouse.reading(0.1)
    assert found.held
    assert found.axes == pytest.approx((0.5, 1.0, 0.2, 0.0, -0.1, 0.0))


def test_a_report_of_a_newer_model_has_the_turns_behind() -> None:
    mouse = SpaceMouse(width=0.0)
    mouse.feed(report(1, 0, 0, 0, 0, 0, -350), 0.0)
    assert mouse.reading(0.0).axes == pytest.approx((0, 0, 0, 0, 0, 1.0))


def test_bytes_as_they_were_seen_on_a_bus() -> None:
    """Reports of a SpaceNavigator: the cap turned by -30 of 350 about its second axis."""
    mouse = SpaceMouse(width=0.0)
    mouse.feed(bytes.fromhex("01000000000000"), 0.0)
    mouse.feed(bytes.fromhex("020000e2ff0000"), 0.0)
    assert mouse.reading(0.0).axes == pytest.approx((0, 0, 0, 30 / 350, 0, 0))
    mouse.feed(bytes.fromhex("0303"), 0.0)
    assert mouse.reading(0.0).pressed == {0, 1}


def test_a_deflected_cap_that_falls_silent_counts_as_let_go() -> None:
    mouse = SpaceMouse()
    mouse.feed(report(1, 0, -350, 0), 5.0)
    assert mouse.reading(5.19).held
    assert mouse.reading(5.21) == Reading()


def test_a_button_may_be_asked_for_as_well() -> None:
    mouse = SpaceMouse(button=1)
    mouse.feed(report(1, 0, -350, 0), 0.0)
    assert not mouse.reading(0.0).held
    mouse.feed(b"\x03\x02\x00", 0.0)
    assert mouse.reading(0.0).held
    mouse.feed(b"", 0.1)
    assert mouse.reading(0.1) == Reading(done=True, pressed=frozenset({1}))


def test_a_space_mouse_is_found_by_what_the_kernel_says(tmp_path: Path) -> None:
    for name, said in {
        "hidraw0": "HID_ID=0003:0000046D:0000C52B\nHID_NAME=Logitech USB Receiver\n",
        "hidraw1": "HID_ID=0003:0000256F:0000C635\nHID_NAME=3Dconnexion SpaceMouse Compact\n",
    }.items():
        (tmp_path / name / "device").mkdir(parents=True)
        (tmp_path / name / "device" / "uevent").write_text(said)
    (tmp_path / "hidraw2").mkdir()
    assert _space_mouse(tmp_path) == "/dev/hidraw1"
    with pytest.raises(ParameterError, match="plugged in"):
        _space_mouse(tmp_path / "hidraw0")


# -- devices ---------------------------------------------------------------------------------------


@pytest.mark.linux("devices that are files")
def test_devices_are_read_without_waiting_and_their_end_is_seen(tmp_path: Path) -> None:
    reader, writer = os.pipe()
    try:
        with KeyboardDevice(reader) as keys:
            assert keys.read(0.0) == Reading()
            os.write(writer, b"a")
            assert keys.read(0.1).axes == (0, 1, 0, 0, 0, 0)
            os.close(writer)
            assert keys.read(0.2).done
    finally:
        os.close(reader)
    path = tmp_path / "js0"
    os.mkfifo(path)
    with GamepadDevice(path) as pad:
        writer = os.open(path, os.O_WRONLY)
        os.write(writer, event(1, 5, 1) + event(2, 0, -32767))
        assert pad.read(0.0).axes == (0, 1, 0, 0, 0, 0)
        os.close(writer)
        assert pad.read(0.1) == Reading(done=True, pressed=frozenset())
    with pytest.raises(ParameterError, match="can be read"), SpaceMouseDevice(tmp_path / "none"):
        pass
    with pytest.raises(ParameterError, match="keyboard, gamepad"):
        open_device("mouse")


# -- speeds and targets ----------------------------------------------------------------------------


def test_speeds_are_scaled_and_zero_without_the_dead_man() -> None:
    scale = TeleopScale(speed=0.1, turn_speed=0.5, joint_speed=0.2)
    axes = (1.0, -0.5, 0.0, 0.0, 1.0, 0.0)
    assert scale.twist(Reading(axes, held=True)) == (0.1, -0.05, 0.0, 0.0, 0.5, 0.0)
    assert scale.joints(Reading(axes, held=True)) == (0.2, -0.1, 0.0, 0.0, 0.2, 0.0)
    assert scale.twist(Reading(axes)) == scale.joints(Reading(axes)) == STANDING
    released: Any = "released"
    for speeds in (scale.twist, scale.joints):
        with pytest.raises(ParameterError, match="the reading's held"):
            speeds(Reading(axes, held=released))
    with pytest.raises(ParameterError, match="joint_speed"):
        TeleopScale(joint_speed=9.0)


@for_each("in_tool", [False, True])
def test_a_joint_target_leads_the_flange_along_the_twist(in_tool: bool) -> None:
    model = arm("gcr5_910")
    target = JointTarget(model, damping=1e-4)
    before = model.fkine(READY)
    seen = np.array(READY)
    for _ in range(30):
        seen = target.by_twist([0.0, 0.0, 0.05, 0, 0, 0], 1 / 30, seen.tolist(), in_tool=in_tool)
    after = model.fkine(seen)
    axis = before[:3, 2] if in_tool else np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(after[:3, 3] - before[:3, 3], 0.05 * axis, atol=1e-3)
    np.testing.assert_allclose(after[:3, :3], before[:3, :3], atol=1e-3)
    assert target.rest(READY) == pytest.approx(seen)


def test_a_target_that_nobody_leads_follows_an_arm_that_is_moved() -> None:
    """By hand between two episodes: it went back by itself, from up to 13 degrees away."""
    target = JointTarget(arm("gcr5_910"))
    led = target.by_joints([0.5, 0, 0, 0, 0, 0], 0.2, READY)
    for seen in (READY, (0.6 * led + 0.4 * np.array(READY)).tolist(), led.tolist()):
        assert target.rest(seen) == pytest.approx(led), "the arm is on its way there"
    moved = [*led[:3], led[3] + 0.15, *led[4:]]
    assert target.rest(moved) == pytest.approx(moved)


def test_a_joint_target_keeps_near_the_arm_and_within_limits_at_a_singularity() -> None:
    model = arm("gcr5_910")
    target = JointTarget(model, fastest=0.5, lead=0.1)
    stretched = [0.0] * 6
    before = np.array(stretched)
    for _ in range(100):
        new = target.by_twist([0.3, 0.2, 0.3, 1, 1, 1], 0.03, stretched)
        assert np.abs(new - before).max() <= 0.5 * 0.03 + 1e-12
        assert np.abs(new).max() <= 0.1
        before = new


@pytest.mark.linux("devices that are files")
def test_a_device_that_is_opened_again_knows_nothing_of_the_last_time(tmp_path: Path) -> None:
    """A program ended each time at once after q; a button that was held on moved the arm."""
    reader, writer = os.pipe()
    path = tmp_path / "js0"
    os.mkfifo(path)
    plug = os.open(path, os.O_RDWR)
    try:
        keys, pad = KeyboardDevice(reader), GamepadDevice(path)
        with keys:
            os.write(writer, b"q")
            assert keys.read(0.0).done
        with keys:
            assert not keys.read(1.0).done
            os.write(writer, b"w")
            assert keys.read(1.0) == Reading((1, 0, 0, 0, 0, 0), held=True)
        with pad:
            os.write(plug, event(1, 4, 1))
            assert pad.read(0.0).held
        with pad:
            os.write(plug, event(1 | 0x80, 4, 1))
            assert not pad.read(1.0).held
    finally:
        for each in (reader, writer, plug):
            os.close(each)


@pytest.mark.linux("devices that are files")
def test_what_came_while_nobody_read_counts_only_if_it_goes_on(tmp_path: Path) -> None:
    """A key that was typed while the arm was brought up moved it, and a cap that was let go."""
    path = tmp_path / "hidraw0"
    os.mkfifo(path)
    plug = os.open(path, os.O_RDWR)
    reader, writer = os.pipe()
    devices: list[tuple[InputDevice, int, bytes]] = [
        (KeyboardDevice(reader), writer, b"w"),
        (SpaceMouseDevice(path), plug, report(1, 0, -350, 0)),
    ]
    try:
        for device, end, sign in devices:
            with device:
                for now in (5.0, 9.0):
                    os.write(end, sign)
                    assert not device.read(now).held
                    os.write(end, sign)
                    assert device.read(now + 0.02).held
    finally:
        for each in (reader, writer, plug):
            os.close(each)


def test_input_that_never_ends_is_not_held_and_holds_up_nobody() -> None:
    """More than can be read at a time: the newest key is not known, so it counts as let go."""
    reader, writer = os.pipe()
    fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 1 << 20)
    fed: list[int] = []

    class Filled(Keyboard):
        def feed(self, data: bytes, now: float) -> None:
            fed.append(len(data))
            os.write(writer, data)  # as much comes as is read
            super().feed(data, now)

    try:
        with KeyboardDevice(reader, Filled()) as device:
            os.write(writer, b"w" * 8192)
            found = device.read(0.0)
            assert (found.held, found.axes) == (False, STANDING)
            assert len(fed) < 100
        with KeyboardDevice(reader) as device:
            device.read(0.0)
            os.write(writer, b"w")
            assert device.read(0.1).held, "what was left is read, and then the key is known"
    finally:
        os.close(reader)
        os.close(writer)


# -- what is no device, and no number ------------------------------------------------------------


def test_an_empty_name_of_a_device_is_not_another_device() -> None:
    """A variable of a script that is not set."""
    for kind in ("gamepad", "spacemouse"):
        with pytest.raises(ParameterError, match="device is ''"), open_device(kind, ""):
            pass


def test_a_device_is_opened_once_at_a_time(tmp_path: Path) -> None:
    path = tmp_path / "device"
    path.touch()
    with no_leaks():
        device = SpaceMouseDevice(path)
        with device, pytest.raises(ParameterError, match="open already"):
            device.__enter__()
        with device:
            pass


def test_a_device_that_is_not_open_says_so() -> None:
    device = GamepadDevice()
    with pytest.raises(ParameterError, match="open: use it in `with`"):
        device.read(0.0)


@pytest.mark.parametrize("missing", [None, io.StringIO()])
def test_a_keyboard_without_a_standard_input_is_refused(
    missing: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", missing)
    with pytest.raises(ParameterError, match="no standard input"), KeyboardDevice():
        pass


def test_a_terminal_that_is_closed_ends_the_keyboard_without_an_error() -> None:
    ours, theirs = pty.openpty()
    try:
        with KeyboardDevice(theirs) as keys:
            keys.read(0.0)
            os.write(ours, b"w")
            eventually(lambda: keys.read(0.0).held)
            os.close(ours)
            eventually(lambda: keys.read(0.0).done)
    finally:
        os.close(theirs)


def test_a_device_is_read_in_a_program_with_thousands_of_descriptors() -> None:
    if resource.getrlimit(resource.RLIMIT_NOFILE)[0] < 1100:
        pytest.skip("this system allows no such descriptor")
    reads, writes = os.pipe()
    high = fcntl.fcntl(reads, fcntl.F_DUPFD_CLOEXEC, 1050)
    try:
        with KeyboardDevice(high) as keys:
            keys.read(0.0)
            os.write(writes, b"w")
            assert keys.read(0.0).held
            os.close(high)
            assert keys.read(1.0) == Reading(done=True)
    finally:
        os.close(reads)
        os.close(writes)


@for_each("time", [math.nan, math.inf, 0.0, -1.0, 61.0, "1", None, True])
def test_no_key_and_no_cap_counts_as_held_for_long(time: Any) -> None:
    for make in (
        lambda: Keyboard(first=time),
        lambda: Keyboard(repeating=time),
        lambda: SpaceMouse(quiet=time),
    ):
        with pytest.raises(ParameterError):
            make()


@for_each("width", [math.nan, -0.1, 1.0, "1", None])
def test_a_width_at_rest_is_a_share(width: Any) -> None:
    for make in (lambda: SpaceMouse(width=width), lambda: Gamepad(width=width)):
        with pytest.raises(ParameterError, match="width"):
            make()


@for_each("wrong", [[math.nan] * 6, [0.0] * 5, "000000", None, [1e400] * 6])
def test_a_target_of_joints_keeps_its_place_when_a_speed_is_no_number(wrong: Any) -> None:
    with pytest.raises(ParameterError, match="an Arm"):
        JointTarget("gcr5_910")  # type: ignore[arg-type]  # the wrong type is the point
    target = JointTarget(arm("gcr5_910"))
    before = target.by_joints([0.1] * 6, 0.02, READY)
    steps: list[Callable[[], object]] = [
        lambda: target.by_joints(wrong, 0.02, READY),
        lambda: target.by_twist(wrong, 0.02, READY),
        lambda: target.by_joints([0.0] * 6, 0.02, wrong),
        lambda: target.rest(wrong),
    ]
    for step in steps:
        with pytest.raises(ParameterError):
            step()
    np.testing.assert_array_equal(target.rest(READY), before)
