"""The compiled core's stub, by which mypy knows it: as it is generated from what was built."""

import ast
import subprocess
import sys
from pathlib import Path

STUB = Path(__file__).resolve().parents[2] / "src" / "urdf_ik" / "_core.pyi"


def test_stub_is_that_of_the_built_core(tmp_path: Path) -> None:
    """Same classes, functions, arguments and docstrings; layout may differ between releases of nanobind."""
    made = tmp_path / "_core.pyi"
    command = [sys.executable, "-m", "nanobind.stubgen", "-q", "-m", "urdf_ik._core", "-o", str(made)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    kept, new = (ast.dump(ast.parse(file.read_text()), indent=1) for file in (STUB, made))
    assert kept == new, "`make stub` writes it anew"
