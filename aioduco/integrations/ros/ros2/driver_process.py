"""The driver's process: event loop, rclpy's threads, signals."""

# pyright: reportMissingImports=false
# ROS 2 comes with the system, and has no types.

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from typing import TYPE_CHECKING, Any

import anyio
import rclpy
from anyio.from_thread import BlockingPortal
from rclpy.exceptions import NameValidationException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args
from std_srvs.srv import Trigger

from aioduco._process.reporting import BackgroundLogger, reporter
from aioduco._process.threads import in_thread
from aioduco.errors import DucoError, ParameterError
from aioduco.integrations.ros.node_parameters import NodeError
from aioduco.integrations.ros.ros2._driver_node import DriverNode
from aioduco.integrations.ros.shutdown import cancel_on_signal
from aioduco.integrations.ros.trajectory_goals import said
from aioduco.models.user_terms import TermsFormatter

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


_LEAVE = 2.0  # seconds within which rclpy's threads must end
_REFUSED = "ROS refuses the arguments: {}. Nothing was sent"
_ROS_ARGUMENTS = "one of ROS's, after --ros-args, as in: --ros-args -p prefix:=left_"
_MOST_RAISED = 1000  # errors of rclpy within a second after which it does not work any more

_log = BackgroundLogger(__name__)


class _RosLog(logging.Handler):
    """Forwards the package's log to the log of ROS, and so to /rosout, in the terms of services.

    rclpy's logger may block for some tenths of a second. It holds up nothing but the thread that
    writes the log, which drops and counts messages if too many are waiting.
    """

    def __init__(self, logger: Any) -> None:
        super().__init__()
        self.setFormatter(TermsFormatter(said))
        self._logger = logger

    def emit(self, record: logging.LogRecord) -> None:
        text = self.format(record)
        # One call for each severity: rclpy allows only one severity per line of code.
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
        arguments: arguments of the command line, from `--ros-args` on.
        parameters: parameters that override those of the command line.

    Raises:
        NodeError: ROS refuses the arguments.
        ParameterError: an argument or a parameter is wrong; nothing was sent.
        ConnectError: no controller answers.
    """
    words = ["duco", *arguments]
    try:
        rclpy.init(args=words, signal_handler_options=SignalHandlerOptions.NO)
        _, *others = remove_ros_args(words)
    except (RuntimeError, ValueError) as error:
        raise NodeError(_REFUSED.format(error)) from error
    if others:
        rclpy.try_shutdown()
        raise ParameterError("argument", others[0], _ROS_ARGUMENTS)
    try:
        failure = anyio.run(_serve, parameters)
    finally:
        rclpy.try_shutdown()
    if failure is not None:
        raise failure


async def _serve(parameters: dict[str, Any]) -> BaseException | None:
    """Serve until a signal or a failure; return the error of the failure."""
    failures: list[BaseException] = []
    async with BlockingPortal() as portal, anyio.create_task_group() as tasks:

        def fail(error: BaseException) -> None:
            failures.append(error)
            tasks.cancel_scope.cancel()

        try:
            node = DriverNode(portal, fail, parameters)
        except DucoError as error:
            return error
        except (ValueError, TypeError, RuntimeError, NameValidationException) as error:
            return NodeError(_REFUSED.format(error))
        handler = _RosLog(node.get_logger())
        logging.getLogger("aioduco").addHandler(handler)
        # A separate node: a stop waits for none of the driver node's callbacks.
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
            tasks.start_soon(cancel_on_signal, tasks.cancel_scope)
            if node.get_parameter("autostart").value:
                await in_thread(node.start, abandon_on_cancel=True)
            await anyio.sleep_forever()
        except Exception as error:  # of the start: the caller reports it
            fail(error)
        finally:
            with anyio.CancelScope(shield=True):
                await node.release()
                await node.send_results()
                for executor, thread in spinning:
                    await in_thread(executor.shutdown, _LEAVE)
                    # The nodes are destroyed next: no thread may be using them then.
                    await in_thread(thread.join, _LEAVE)
                await in_thread(reporter.flush)
                # also an arm that was still being connected to when the end came
                await portal.stop(cancel_remaining=True)
            logging.getLogger("aioduco").removeHandler(handler)
            stop_node.destroy_node()
            node.destroy_node()
    return failures[0] if failures else None


def _spinning(
    node: Any, portal: BlockingPortal, fail: Callable[[BaseException], None]
) -> tuple[Any, threading.Thread]:
    """An executor that serves a node on a separate thread, and that thread."""
    executor = SingleThreadedExecutor()
    executor.add_node(node)

    def spin() -> None:
        raised: deque[float] = deque(maxlen=_MOST_RAISED)
        while True:
            try:
                executor.spin()
            except ExternalShutdownException:
                return
            except Exception as error:  # of one message, such as a text that is not UTF-8
                now = time.monotonic()
                raised.append(now)
                if len(raised) == _MOST_RAISED and now - raised[0] < 1.0:
                    # A node that no longer answers must not seem alive.
                    portal.start_task_soon(fail, error)
                    return
                if len(raised) == 1 or now - raised[-2] > 1.0:
                    _log.warning("a message was left out: %r", error)
            else:
                return

    thread = threading.Thread(target=spin, name=f"ros {node.get_name()}", daemon=True)
    thread.start()
    return executor, thread
