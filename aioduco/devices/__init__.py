"""Devices beside the arm: buses, grippers, cameras, and what a hand holds to lead the arm.

Each uses a robot by its public interface. A driver for a gripper of yours belongs into `grippers`.
"""
