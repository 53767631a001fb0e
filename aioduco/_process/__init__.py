"""Processes: how the package starts and asks its own, what the system offers them, their log."""
