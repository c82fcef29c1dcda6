"""The C++ tests of tests/core/native: programs that are built beside the core, one for each instruction set."""

import subprocess

import pytest
from core_steps import FOLDER

from urdf_ik import _core


@pytest.mark.parametrize("level", _core.levels())
def test_facts_hold_in_cpp(level: str) -> None:
    """Subproblems, angles and roots hold their facts as C++ calls them, in every instruction set."""
    program = FOLDER / f"core_tests_{level}"
    done = subprocess.run([program], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stdout
    assert int(done.stdout.split()[0]) > 1000
