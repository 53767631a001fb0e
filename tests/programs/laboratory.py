"""A laboratory's command line: named places, a valve, and a way out of standby, by typed words."""

from __future__ import annotations

import cmd
import io
import json
import shlex
from typing import Any

PLACES = {
    "home": [0.0, 0.0, 1.57, 0.0, -1.57, 0.0],
    "rack": [0.5, 0.1, 1.4, 0.0, -1.5, 0.3],
}
ENABLED = 6


class Laboratory(cmd.Cmd):
    """One command a line; what it answers is printed."""

    prompt = ""
    use_rawinput = False

    def __init__(self, robot: Any, lines: io.StringIO, printed: io.StringIO) -> None:
        super().__init__(stdin=lines, stdout=printed)
        self.robot = robot

    def tell(self, value: Any) -> None:
        print(json.dumps(value), file=self.stdout)

    def do_state(self, _: str) -> None:
        self.tell(self.robot.get_robot_state())

    def do_wake(self, _: str) -> None:
        """Out of standby, or of a stop: power off, on, enable."""
        self.robot.power_off(True)
        self.robot.power_on(True)
        self.tell(self.robot.enable(True))

    def do_go(self, words: str) -> None:
        place, percent = shlex.split(words)
        self.tell(self.robot.movej(PLACES[place], float(percent), 50, 0, True))

    def do_up(self, millimetres: str) -> None:
        offset = [0.0, 0.0, -float(millimetres) / 1000, 0.0, 0.0, 0.0]
        self.tell(self.robot.tcp_move(offset, 0.1, 0.5, 0, "", True))

    def do_where(self, _: str) -> None:
        self.tell([round(1000 * each, 1) for each in self.robot.get_tcp_pose()[:3]])

    def do_valve(self, words: str) -> None:
        number, state = shlex.split(words)
        self.robot.set_standard_digital_out(int(number), state == "on", True)
        self.tell(self.robot.get_standard_digital_out(int(number)))

    def do_errors(self, _: str) -> None:
        self.tell(self.robot.get_last_error())

    def do_quit(self, _: str) -> bool:
        return True


def main(cobot_class: Any, ip: str, port: int, lines: list[str]) -> list[Any]:
    robot = cobot_class(ip, port)
    robot.open()
    printed = io.StringIO()
    Laboratory(robot, io.StringIO("\n".join([*lines, "quit", ""])), printed).cmdloop()
    robot.close()
    return [json.loads(line) for line in printed.getvalue().splitlines()]
