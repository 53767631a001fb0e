"""Classes of these messages, made from their definitions."""

from aioduco.integrations.ros.ros1.message_classes import action_messages, define

_MESSAGES = {
    "moveit_msgs/MoveItErrorCodes": "int32 val\nint32 SUCCESS=1\nint32 FAILURE=99999\n"
    "int32 CONTROL_FAILED=-4\nint32 INVALID_GROUP_NAME=-15\n",
    "moveit_msgs/JointConstraint": "string joint_name\nfloat64 position\n"
    "float64 tolerance_above\nfloat64 tolerance_below\nfloat64 weight\n",
    "moveit_msgs/Constraints": "string name\nJointConstraint[] joint_constraints\n",
    "moveit_msgs/MotionPlanRequest": "Constraints[] goal_constraints\nstring planner_id\n"
    "string group_name\nint32 num_planning_attempts\nfloat64 allowed_planning_time\n"
    "float64 max_velocity_scaling_factor\nfloat64 max_acceleration_scaling_factor\n",
    "moveit_msgs/PlanningOptions": "bool plan_only\n",
}
_ACTION = {
    "Goal": "MotionPlanRequest request\nPlanningOptions planning_options\n",
    "Result": "MoveItErrorCodes error_code\n",
    "Feedback": "string state\n",
}
define(_MESSAGES | action_messages("moveit_msgs/MoveGroup", _ACTION), {}, ["moveit_msgs"])
