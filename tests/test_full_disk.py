"""A few of the failed writes of `make crash-test`, in a separate process, since it forks."""

import subprocess
import sys
from pathlib import Path

import full_disk
import pytest


@pytest.mark.slow
@pytest.mark.skipif(not full_disk.compiler() or sys.platform != "linux", reason="needs a C compiler and Linux")
@pytest.mark.parametrize(("stride", "name"), [(3, "init"), (23, "export vtkhdf"), (23, "sweep"), (150, "simulate")])
def test_a_write_that_is_refused_leaves_what_can_be_read(stride, name):
    command = [sys.executable, str(Path(full_disk.__file__)), str(stride), name]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert f"{name}: " in ran.stdout
