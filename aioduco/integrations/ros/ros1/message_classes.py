"""Classes of messages that are not installed, made from their definitions on demand.

The definitions are files in the folder `messages`, as a package of ROS has them. `control_msgs` are
ROS's own, field by field: their checksums are those of the released package. `aioduco_msgs` are
those of this package.
"""

from __future__ import annotations

import importlib
import sys
from importlib import resources
from types import ModuleType
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Iterator
    from importlib.resources.abc import Traversable


_FOLDER: Final = resources.files("aioduco.integrations.ros.ros1") / "messages"


def _read(kind: str) -> Iterator[tuple[str, str]]:
    """Full name and text of each definition of a kind, in the order of their names."""

    def named(folder: Traversable) -> list[Traversable]:
        return sorted(folder.iterdir(), key=lambda each: each.name)

    for package in named(_FOLDER):
        if (folder := package / kind).is_dir():
            for file in named(folder):
                name = file.name.removesuffix(f".{kind}")
                yield f"{package.name}/{name}", file.read_text("utf-8")


#: messages by their full name; each uses only those before it
MESSAGES: Final = dict(_read("msg"))
#: services by their full name
SERVICES: Final = dict(_read("srv"))
#: the three parts of control_msgs/FollowJointTrajectory
ACTION: Final[dict[str, str]] = dict(
    zip(
        ("Goal", "Result", "Feedback"),
        dict(_read("action"))["control_msgs/FollowJointTrajectory"].split("---\n"),
        strict=True,
    )
)
#: fields that actionlib adds to each part
ACTION_HEADERS: Final[dict[str, str]] = {
    "Goal": "Header header\nactionlib_msgs/GoalID goal_id\n{name}Goal goal\n",
    "Result": "Header header\nactionlib_msgs/GoalStatus status\n{name}Result result\n",
    "Feedback": "Header header\nactionlib_msgs/GoalStatus status\n{name}Feedback feedback\n",
    "": "{name}ActionGoal action_goal\n{name}ActionResult action_result\n"
    "{name}ActionFeedback action_feedback\n",
}


_NAME = "control_msgs/FollowJointTrajectory"
#: installed messages whose definitions, with all that they use, the others need
_USED = (
    "std_msgs/Header",
    "trajectory_msgs/JointTrajectory",
    "actionlib_msgs/GoalID",
    "actionlib_msgs/GoalStatus",
)
_SEPARATOR = "=" * 80 + "\nMSG: "


def install() -> None:
    """Make `control_msgs.msg`, `aioduco_msgs.msg` and `aioduco_msgs.srv` importable.

    Installed packages are used as they are. Python clients can call this too: after it,
    `from control_msgs.msg import FollowJointTrajectoryAction` works with any ROS 1.

    Raises:
        ModuleNotFoundError: genpy, or messages of ROS's core, are not installed.
    """
    missing = [name for name in ("control_msgs", "aioduco_msgs") if not _importable(name)]
    if missing:
        define(MESSAGES | action_messages(_NAME, ACTION), SERVICES, missing)


def define(messages: dict[str, str], services: dict[str, str], packages: list[str]) -> None:
    """Make classes of messages and services, and add them to the modules that clients import.

    Args:
        messages: definitions by the messages' full names, each after the messages that it uses.
        services: definitions by the services' full names.
        packages: packages of which classes are made; the others are installed.

    Raises:
        ModuleNotFoundError: genpy, or messages of ROS's core, are not installed.
    """
    genmsg = importlib.import_module("genmsg")
    generator = importlib.import_module("genpy.generator")
    loader = genmsg.msg_loader
    context = genmsg.MsgContext.create_default()
    for name in _USED:
        for kind, text in _definitions(name):
            loader.load_msg_from_string(context, text, kind)
    for name, text in messages.items():
        spec = loader.load_msg_from_string(context, text, name)
        _define(name, "msg", generator.msg_generator(context, spec, {}), packages)
    for name, text in services.items():
        spec = loader.load_srv_from_string(context, text, name)
        _define(name, "srv", generator.srv_generator(context, spec, {}), packages)


def action_messages(name: str, parts: dict[str, str]) -> dict[str, str]:
    """The messages of an action, by their full names.

    Args:
        name: full name of the action.
        parts: definitions of its goal, result and feedback.
    """
    found = {name + part: text for part, text in parts.items()}
    short = name.partition("/")[2]
    return found | {
        f"{name}Action{part}": text.format(name=short) for part, text in ACTION_HEADERS.items()
    }


def _importable(package: str) -> bool:
    try:
        importlib.import_module(f"{package}.msg")
    except ModuleNotFoundError:
        return False
    return True


def _definitions(name: str) -> list[tuple[str, str]]:
    """The definitions of an installed message and of the messages that it uses, from its class."""
    package, _, kind = name.partition("/")
    whole: str = getattr(importlib.import_module(f"{package}.msg"), kind)._full_text
    own, *others = whole.split(_SEPARATOR)
    return [(name, own), *((each.partition("\n")[0], each.partition("\n")[2]) for each in others)]


def _define(name: str, folder: str, lines: Any, packages: list[str]) -> None:
    """Run the code of a message's class, and add the class to the module that clients import."""
    package, _, kind = name.partition("/")
    if package not in packages:
        return
    module = _module(package, folder)
    code = compile("\n".join(lines), f"<{name}>", "exec")
    own = ModuleType(f"{package}.{folder}._{kind}")
    sys.modules[own.__name__] = own
    exec(code, own.__dict__)  # made by ROS's generator from the text above
    for each, made in vars(own).items():
        if isinstance(made, type) and each.startswith(kind):
            setattr(module, each, made)


def _module(package: str, folder: str) -> ModuleType:
    """The module for a package that is not installed; it is made once."""
    name = f"{package}.{folder}"
    if name not in sys.modules:
        parent = sys.modules.setdefault(package, ModuleType(package))
        parent.__path__ = []
        module = ModuleType(name)
        module.__path__ = []
        sys.modules[name] = module
        setattr(parent, folder, module)
    return sys.modules[name]
