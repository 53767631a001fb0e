"""Messages, services and the action of the driver, as text, for use where they are not installed.

They are files in the folder `messages`, as a package of ROS has them. `control_msgs` are ROS's own,
field by field: their checksums are those of the released package. `aioduco_msgs` are those of this
package.
"""

from __future__ import annotations

from importlib import resources
from typing import TYPE_CHECKING, Final

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
