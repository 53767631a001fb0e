"""The supervision of a robot: its tasks, stop, heartbeat, state, bring-up and closing steps."""
