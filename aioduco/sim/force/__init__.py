"""Force control (力控, manual 1.3.10): the sensor's readings, and the arm's compliance with forces.

The modules may import `planner`, `cycle` and `scene`. The tasks are in `controller.force_tasks`.
"""
