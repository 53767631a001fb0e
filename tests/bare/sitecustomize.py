"""Takes from child interpreters what `pytest --bare-platform` takes; found by PYTHONPATH."""

import os
import sys

if os.environ.get("AIODUCO_TESTS_BARE"):
    sys.path.insert(0, os.environ["AIODUCO_TESTS_BARE"])
    import bare_platform

    sys.path.pop(0)
    bare_platform.install()
