"""Programs in the manner of public ones, for the vendor's Python class, and one in C++.

Each shows one habit. `test_programs.py` runs them at the simulated controller.
"""
