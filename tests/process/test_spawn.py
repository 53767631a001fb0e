"""Processes of this package: what is kept of their standard error."""

from __future__ import annotations

import pytest
from interpreter import python

FORKING = """
import gc, os
from aioduco._process import spawn

spawn.has_memory_files = lambda: False  # as on macOS
process = spawn.Process("no_module_of_this_name", [])
process.popen.wait()
child = os.fork()
if child == 0:
    del process
    gc.collect()
    os._exit(0)
assert os.waitpid(child, 0)[1] == 0
assert "no_module_of_this_name" in process.stderr_tail, process.stderr_tail
file = process._stderr._file
process.close()
assert not file.exists()
"""


@pytest.mark.linux("os.fork")
def test_a_forked_child_does_not_delete_what_its_parents_process_has_said() -> None:
    ended = python("-c", FORKING)
    assert ended.returncode == 0, ended.stderr
