"""Messages, services and the action of the driver, as text, for use where they are not installed.

`control_msgs` are ROS's own, field by field: their checksums are those of the released package.
`aioduco_msgs` are those of this package.
"""

from __future__ import annotations

__all__ = ["ACTION", "ACTION_HEADERS", "MESSAGES", "SERVICES"]

#: the three parts of control_msgs/FollowJointTrajectory
ACTION = {
    "Goal": """\
trajectory_msgs/JointTrajectory trajectory
JointTolerance[] path_tolerance
JointTolerance[] goal_tolerance
duration goal_time_tolerance
""",
    "Result": """\
int32 error_code
int32 SUCCESSFUL = 0
int32 INVALID_GOAL = -1
int32 INVALID_JOINTS = -2
int32 OLD_HEADER_TIMESTAMP = -3
int32 PATH_TOLERANCE_VIOLATED = -4
int32 GOAL_TOLERANCE_VIOLATED = -5
string error_string
""",
    "Feedback": """\
Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint desired
trajectory_msgs/JointTrajectoryPoint actual
trajectory_msgs/JointTrajectoryPoint error
""",
}

#: fields that actionlib adds to each part
ACTION_HEADERS = {
    "Goal": "Header header\nactionlib_msgs/GoalID goal_id\n{name}Goal goal\n",
    "Result": "Header header\nactionlib_msgs/GoalStatus status\n{name}Result result\n",
    "Feedback": "Header header\nactionlib_msgs/GoalStatus status\n{name}Feedback feedback\n",
    "": "{name}ActionGoal action_goal\n{name}ActionResult action_result\n"
    "{name}ActionFeedback action_feedback\n",
}

#: messages by their full name; each uses only those before it
MESSAGES = {
    "control_msgs/JointTolerance": """\
string name
float64 position
float64 velocity
float64 acceleration
""",
    "aioduco_msgs/RobotState": """\
Header header
int32 robot_state
int32 program_state
int32 safety_state
int32 operation_mode
string text
bool enabled
bool collision
int32 collision_joint
bool emergency_stop
int32 error
""",
    "aioduco_msgs/IOState": """\
Header header
bool[] digital_inputs
bool[] digital_outputs
bool[] tool_inputs
bool[] tool_outputs
float64[] voltage_inputs
float64[] voltage_outputs
float64[] current_inputs
float64[] current_outputs
""",
    "aioduco_msgs/ToolData": """\
Header header
float64[6] offset
float64 mass
float64[3] centre
bool[] inputs
bool[] outputs
""",
    "control_msgs/JointTrajectoryControllerState": """\
Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint desired
trajectory_msgs/JointTrajectoryPoint actual
trajectory_msgs/JointTrajectoryPoint error
""",
}

_REPLY = "---\nbool success\nstring message\n"

#: services by their full name
SERVICES = {
    "aioduco_msgs/SetAnalogOutput": "uint8 number\nfloat64 value\nbool current\n" + _REPLY,
    "aioduco_msgs/SetIO": "int8 fun\nint8 pin\nfloat32 state\n" + _REPLY,
    "aioduco_msgs/SetSpeed": "int32 percent\n" + _REPLY,
    "aioduco_msgs/SetSpeedFraction": "float64 speed_slider_fraction\n" + _REPLY,
    "aioduco_msgs/SetText": "string text\n" + _REPLY,
    "aioduco_msgs/StartForceMode": "bool[6] selection\nfloat64[6] wrench\nfloat64[6] damping\n"
    "float64[6] speed_limits\nuint8 frame\n" + _REPLY,
    "aioduco_msgs/SetOutput": "uint8 number\nbool value\n" + _REPLY,
    "aioduco_msgs/SetLoad": "float64 mass\nfloat64[3] centre\n" + _REPLY,
    "aioduco_msgs/SetTool": "string name\nfloat64[6] offset\nfloat64 mass\nfloat64[3] centre\n"
    + _REPLY,
    "aioduco_msgs/MoveJ": "float64[] joints\nfloat64 v\nfloat64 a\n" + _REPLY,
    "aioduco_msgs/MoveL": "float64[6] pose\nfloat64 v\nfloat64 a\nstring tool\nstring wobj\n"
    + _REPLY,
}
