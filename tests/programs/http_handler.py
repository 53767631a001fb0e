"""A web service that moves the arm: requests are handled on another thread than opened it."""

from __future__ import annotations

import json
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from typing import Any
from urllib.request import Request, urlopen


def main(cobot_class: Any, ip: str, port: int) -> tuple[dict[str, Any], dict[str, Any]]:
    robot = cobot_class(ip, port)
    robot.open()
    robot.power_on(True)
    robot.enable(True)

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.answer({"joints": robot.get_actual_joints_position()})

        def do_POST(self) -> None:
            body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
            self.answer({"state": robot.movej2(body["joints"], 1.0, 2.0, 0.0, True)})

        def answer(self, value: dict[str, Any]) -> None:
            text = json.dumps(value).encode()
            self.send_response(200)
            self.send_header("Content-Length", str(len(text)))
            self.end_headers()
            self.wfile.write(text)

        def log_message(self, *_: object) -> None:
            """Say nothing."""

    with HTTPServer(("127.0.0.1", 0), Handler) as service:
        thread = threading.Thread(target=service.serve_forever, daemon=True)
        thread.start()
        url = f"http://127.0.0.1:{service.server_port}/"
        goal = json.dumps({"joints": [0.4, 0.0, 1.57, 0.0, -1.57, 0.0]}).encode()
        with urlopen(Request(url, goal), timeout=60) as response:
            moved = json.load(response)
        with urlopen(url, timeout=60) as response:
            seen = json.load(response)
        service.shutdown()
        thread.join()
    robot.close()
    return moved, seen
