"""The pages about swaps and CI: their commands run, and the notebook can be read without a kernel."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from urdf_ik.model import catalogue

ROOT = Path(__file__).parents[2]
ARM = catalogue.resolve("zyyzyz_6r").path.read_text()


def run(line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """A command of a page, by this environment's Python, in a folder of its own."""
    program, *words = shlex.split(line, comments=True)
    start = {
        "urdf-ik": ["-m", "urdf_ik.cli"],
        "pytest": ["-m", "pytest", "-p", "urdf_ik_pytest", "-p", "no:cacheprovider"],
    }[program]
    return subprocess.run([sys.executable, *start, *words], cwd=folder, capture_output=True, text=True, timeout=300)


def test_the_steps_of_the_workflow_pass_for_the_same_urdf_and_fail_for_another(tmp_path: Path) -> None:
    """In a folder that holds a URDF and its lock: status 0; after an axis was negated, the lock's steps say no."""
    page = ROOT.joinpath("docs/how-to/ci.md").read_text()
    steps = [line for line in re.findall(r"- run: (.*)", page) if not line.startswith("pip")]
    assert len(steps) == 4
    tmp_path.joinpath("my_arm.urdf").write_text(ARM)
    (freeze,) = re.findall(r"^pytest .*--urdf-freeze", page, re.MULTILINE)
    assert run(f"{freeze} --urdf-poses 5", tmp_path).returncode == 0
    for step in steps:
        quick = step.replace("-n 500", "-n 5") + (" --urdf-poses 5" if step.startswith("pytest") else "")
        done = run(quick, tmp_path)
        assert done.returncode == 0, f"{step}\n{done.stdout}\n{done.stderr}"
    axis = '<axis xyz="0 1 0"/>'
    tmp_path.joinpath("my_arm.urdf").write_text(ARM.replace(axis, axis.replace("1", "-1"), 1))
    status = {step: run(step.replace("-n 500", "-n 5") + (" --urdf-poses 5" if "pytest" in step else ""), tmp_path)
              for step in steps if "doctor" not in step}  # fmt: skip
    assert [done.returncode for done in status.values()] == [1, 0, 1]
    assert all("joint_2" in done.stdout for done in status.values() if done.returncode)


def test_the_swap_notebook_can_be_read_without_a_kernel() -> None:
    """Exported, it holds the tables of the comparison, the picture of the arms and the verdicts as plain HTML."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    exporters = pytest.importorskip("nbconvert.exporters")
    notebook = nbformat.read(ROOT / "notebooks" / "02_swap_the_urdf.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    html, _ = exporters.HTMLExporter().from_notebook_node(notebook)
    shown = [data for cell in notebook.cells if cell.cell_type == "code"
             for output in cell.outputs for data in [json.dumps(output.get("data", {}))]]  # fmt: skip
    assert sum("text/html" in data for data in shown) >= 4
    assert "<svg" in html and html.count("<table>") >= 5
    for words in ("1 difference", "joint_2", "free of contact", "PASSED", "FAILED"):
        assert words in html, words
