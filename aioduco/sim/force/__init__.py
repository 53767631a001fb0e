"""Force control (力控, manual 1.3.10): what the sensor says, and how the arm gives way to it.

May import `planner`, `cycle` and `scene`. Its tasks are in `controller.force_tasks`.
"""
