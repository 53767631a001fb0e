"""The driver's process: event loop, rclpy's threads, signals."""

# pyright: reportMissingImports=false
# ROS 2 comes with the system, and has no types.

from __future__ import annotations

import logging
import logging.handlers
import queue
import signal
import threading
from typing import TYPE_CHECKING, Any

import anyio
import anyio.to_thread
import rclpy
from anyio.from_thread import BlockingPortal
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import Trigger

from aioduco.integrations.ros.ros2._driver_node import DriverNode

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

__all__ = ["main"]

_LEAVE = 2.0  # seconds that rclpy's threads have to end


class _RosLog(logging.Handler):
    """Hands the package's log to that of ROS, and so to /rosout."""

    def __init__(self, logger: Any) -> None:
        super().__init__()
        self._logger = logger

    def emit(self, record: logging.LogRecord) -> None:
        text = self.format(record)
        # Each from a line of its own: rclpy wants one severity of one line.
        if record.levelno >= logging.ERROR:
            self._logger.error(text)
        elif record.levelno >= logging.WARNING:
            self._logger.warning(text)
        elif record.levelno >= logging.INFO:
            self._logger.info(text)
        else:
            self._logger.debug(text)


def main(arguments: Sequence[str], parameters: dict[str, Any]) -> None:
    """Run the driver until a signal.

    Args:
        arguments: of the command line: `--ros-args` and what follows.
        parameters: that go before those of the command line.

    Raises:
        ParameterError: a parameter is wrong; nothing was sent.
        ConnectError: no controller answers.
    """
    rclpy.init(args=["duco", *arguments], signal_handler_options=SignalHandlerOptions.NO)
    try:
        failure = anyio.run(_serve, parameters)
    finally:
        rclpy.try_shutdown()
    if failure is not None:
        raise failure


async def _serve(parameters: dict[str, Any]) -> BaseException | None:
    """Serve until a signal, or until something fails: gives back what."""
    failures: list[BaseException] = []
    async with BlockingPortal() as portal, anyio.create_task_group() as tasks:

        def fail(error: BaseException) -> None:
            failures.append(error)
            tasks.cancel_scope.cancel()

        node = DriverNode(portal, fail, parameters)
        # On a thread of its own: rclpy's logger takes up to some tenths of a second.
        waiting: queue.SimpleQueue[logging.LogRecord] = queue.SimpleQueue()
        handler = logging.handlers.QueueHandler(waiting)
        listener = logging.handlers.QueueListener(waiting, _RosLog(node.get_logger()))
        listener.start()
        logging.getLogger("aioduco").addHandler(handler)
        # Beside the driver's: whatever its callbacks do, a stop waits behind none of them.
        stop_node = Node(
            f"{node.get_name()}_stop",
            namespace=node.get_namespace(),
            use_global_arguments=False,
            start_parameter_services=False,
            enable_rosout=False,
        )
        stop_node.create_service(Trigger, f"{node.get_fully_qualified_name()}/stop", node.stop)
        spinning = [_spinning(each, portal, fail) for each in (node, stop_node)]
        try:
            tasks.start_soon(_until_signal, tasks.cancel_scope)
            if node.get_parameter("autostart").value:
                await anyio.to_thread.run_sync(node.start, abandon_on_cancel=True)
            await anyio.sleep_forever()
        except Exception as error:  # of the start: it is told by the caller
            fail(error)
        finally:
            with anyio.CancelScope(shield=True):
                await node.release()
                for executor, thread in spinning:
                    await anyio.to_thread.run_sync(executor.shutdown, _LEAVE)
                    # Its nodes are destroyed next: no thread may be waiting on them then.
                    await anyio.to_thread.run_sync(thread.join, _LEAVE)
            logging.getLogger("aioduco").removeHandler(handler)
            listener.stop()
            stop_node.destroy_node()
            node.destroy_node()
    return failures[0] if failures else None


def _spinning(
    node: Any, portal: BlockingPortal, fail: Callable[[BaseException], None]
) -> tuple[Any, threading.Thread]:
    """An executor that serves a node on a thread of its own, and that thread."""
    executor = SingleThreadedExecutor()
    executor.add_node(node)

    def spin() -> None:
        try:
            executor.spin()
        except ExternalShutdownException:
            return
        except BaseException as error:  # a node that answers nothing must not seem alive
            portal.start_task_soon(fail, error)

    thread = threading.Thread(target=spin, name=f"ros {node.get_name()}", daemon=True)
    thread.start()
    return executor, thread


async def _until_signal(scope: anyio.CancelScope) -> None:
    with anyio.open_signal_receiver(signal.SIGINT, signal.SIGTERM) as signals:
        async for _ in signals:
            scope.cancel()
            return
