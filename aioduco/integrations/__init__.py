"""Bridges to other systems, each in a folder of its own that can be deleted with it.

They use the package as a program does: what `aioduco` exports, its errors and its kinematics. What
they need of others is loaded when a bridge is started, and not before.
"""
