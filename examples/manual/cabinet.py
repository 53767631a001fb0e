"""What the manual's examples run on: a controller that was given, or a simulated one.

The simulated one has at its RS-485 ports and its Modbus what the examples read and write.

    python serial_sync.py                  on a simulated controller
    python serial_sync.py 192.168.1.10     on a real one
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from aioduco.sim import Simulator
from aioduco.sim.cabinet.modbus import ModbusSlave

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["DEVICE", "JOINTS_VEL", "run", "simulated"]

#: address of the devices behind the Modbus signal
DEVICE = "127.0.0.1"

#: the table `joints_vel` of the manual's section 1.3.15, whole [rad/s]
JOINTS_VEL = [
    [
        *(-6.700217460074271930e-04, -4.072137254218498661e-03, 7.066593031266893074e-03),
        *(-2.978735190571154060e-03, 2.183094442351974149e-05, -6.698504529062708013e-04),
    ],
    [
        *(-1.589154109004034272e-03, -1.011421833810334688e-02, 1.754193265331701820e-02),
        *(-7.390421055007160601e-03, 5.177329125210710173e-05, -1.588748280197681967e-03),
    ],
    [
        *(-2.755305715766451745e-03, -1.811209469461632846e-02, 3.140150170886479852e-02),
        *(-1.322473808616756764e-02, 8.975891577376789718e-05, -2.754602640998529955e-03),
    ],
    [
        *(-3.442737990430701396e-03, -2.315600008944551300e-02, 4.013747069438520360e-02),
        *(-1.690065907568836720e-02, 1.121474983595938492e-04, -3.441859692247766726e-03),
    ],
    [
        *(-3.157588346910660156e-03, -2.189245123375168842e-02, 3.793907058813744682e-02),
        *(-1.597249170914913363e-02, 1.028521444952658879e-04, -3.156782645645519157e-03),
    ],
    [
        *(-2.864607599016891562e-03, -2.071522367525847202e-02, 3.588861821868741253e-02),
        *(-1.510613530488653065e-02, 9.330159342950848850e-05, -2.863877683525377273e-03),
    ],
    [
        *(-2.820140424052270788e-03, -2.131761007776102057e-02, 3.692116291809591222e-02),
        *(-1.553733028238165649e-02, 9.184682028243494134e-05, -2.819424392840391355e-03),
    ],
    [
        *(-2.812250163455366943e-03, -2.205552289748904243e-02, 3.818995917565090603e-02),
        *(-1.606839114406481001e-02, 9.158444035047173999e-05, -2.811536045264771428e-03),
    ],
    [
        *(-2.728426654789113497e-03, -2.205617043400752084e-02, 3.818376395297849724e-02),
        *(-1.606350627152726418e-02, 8.884967501704240018e-05, -2.727728984672162828e-03),
    ],
    [
        *(-1.936938097461126220e-03, -2.279194264874751311e-02, 3.938230929954751602e-02),
        *(-1.654479502939042515e-02, 6.304779778496766665e-05, -1.936393526134143209e-03),
    ],
]

#: frames that wait at the cabinet's port and at the tool's, for the examples that read
_CABINET = bytes([255, 1, *range(1, 9), 255, 1, 50, 51, 255, 1])
_TOOL = bytes([*range(10, 20), 255, 255, *range(20, 28), 255, 1, 60, 61, 1, 255])


def simulated(speed: float = 1.0) -> Simulator:
    """A simulated controller with what the examples need; its clock runs so fast."""
    sim = Simulator(
        speed=speed, programs={"wave": [["movej2", [0.0, 0.0, 1.57, 0.0, -1.57, 0.0], 1.0, 2.0]]}
    )
    sim.cabinet.serial.arrive(_CABINET)
    sim.cabinet.tool_serial.arrive(_TOOL)
    slaves = sim.cabinet.modbus.slaves
    slaves[DEVICE, 1] = ModbusSlave(registers=dict.fromkeys(range(5), 0))
    slaves[DEVICE, 2] = ModbusSlave(coils=dict.fromkeys(range(5), False))
    return sim


def run(main: Callable[[str, int], dict[str, object]]) -> None:
    """Run a file's examples, and print what each gave."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        results = main(given.host, given.port)
    else:
        with simulated() as sim:
            results = main(sim.host, sim.port)
    for number, result in results.items():
        print(number, result)
