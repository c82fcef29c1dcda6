"""The core as it was built: the C++ tests of tests/core/native, for each instruction set, and the stub for mypy."""

import ast
import subprocess
import sys
from pathlib import Path

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


STUB = Path(__file__).resolve().parents[2] / "src" / "urdf_ik" / "_core.pyi"


def test_stub_is_that_of_the_built_core(tmp_path: Path) -> None:
    """Same classes, functions, arguments and docstrings; layout may differ between releases of nanobind."""
    made = tmp_path / "_core.pyi"
    command = [sys.executable, "-m", "nanobind.stubgen", "-q", "-m", "urdf_ik._core", "-o", str(made)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    kept, new = (ast.dump(ast.parse(file.read_text()), indent=1) for file in (STUB, made))
    assert kept == new, "`make stub` writes it anew"
