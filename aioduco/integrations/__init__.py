"""Bridges to other systems, each in a folder of its own. Deleting the folder removes the bridge.

They use the package as a program does: the exports of `aioduco`, its errors and its kinematics. The
libraries of other systems are imported when a bridge is started, not earlier.
"""
