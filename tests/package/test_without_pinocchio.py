"""Where Pinocchio is not installed, arms load, solve and are drawn, and every check that is left out is named."""

import subprocess
import sys
from pathlib import Path

import pytest
from command import ARM, strict_json

HIDDEN = """
import sys
class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("pinocchio", "coal", "hppfcl"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Hidden())
"""
PYTHON = """
import warnings
import matplotlib
matplotlib.use("agg")
import urdf_ik
from urdf_ik.errors import MissingPackage
from urdf_ik.maps import workspaces
from urdf_ik.show import plot

arm = urdf_ik.load("zyyzyz_6r")
q = [0.3, -0.5, 0.8, 0.4, 0.7, -0.2]
s = arm.ik(arm.fk(q))
print(len(s), len(s.within_limits().turns()), len(arm.ik_nearest(arm.fk(q), q)))
plot.save(plot.branches(s), "branches.png")
print(workspaces.planar(urdf_ik.load("planar_2r")).overlap.area > 0.0)
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    plan = arm.follow(urdf_ik.line(arm.fk(q), arm.fk([0.4, -0.5, 0.8, 0.4, 0.7, -0.2]), 3))
print(plan.found, plan.unchecked, "|", said[0].message)
for ask in (s.collision_free, lambda: arm.clearance(q), lambda: arm.to_pinocchio(q), lambda: urdf_ik.freeze(arm),
            lambda: urdf_ik.compare(arm, arm, n=2), lambda: arm.follow(s.poses[None], collisions="require")):
    try:
        print("no error:", ask())
    except MissingPackage as error:
        print(error)
"""


def run(code: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run code in a process in which nobody can import Pinocchio or coal."""
    return subprocess.run(
        [sys.executable, "-c", HIDDEN + code], cwd=folder, capture_output=True, text=True, timeout=300, check=False
    )


def command(folder: Path, *args: str) -> subprocess.CompletedProcess[str]:
    """The command there."""
    return run(f"sys.argv = ['urdf-ik', *{args!r}]\nfrom urdf_ik.cli import main\nmain()", folder)


def test_everything_but_checks_works(tmp_path: Path) -> None:
    """Solutions, limits, turns, pictures, regions and plans; what needs Pinocchio says how to install it."""
    pytest.importorskip("matplotlib")
    done = run(PYTHON, tmp_path)
    assert done.returncode == 0, done.stderr
    counts, region, plan, *refused = done.stdout.splitlines()
    assert counts == "8 8 1" and region == "True"
    assert plan.startswith("True Pinocchio is missing (pip install pin) | zyyzyz_6r: contacts not checked: Pinocchio")
    assert len(refused) == 6
    assert all("need Pinocchio, which is not installed: pip install pin" in line for line in refused), refused
    assert (tmp_path / "branches.png").read_bytes().startswith(b"\x89PNG")


def test_the_command_names_what_it_did_not_check(tmp_path: Path) -> None:
    """`ik` solves and says on its own account that nothing was measured; `doctor` is content; `check` is refused."""
    table = command(tmp_path, "ik", ARM)
    assert table.returncode == 0 and "8 solutions" in table.stdout
    assert "errors were not measured: Pinocchio is missing" in table.stdout
    assert "self-collision was not checked: Pinocchio is missing" in table.stdout
    data = command(tmp_path, "ik", ARM, "--json")
    assert data.returncode == 0 and "errors and contacts were not checked: Pinocchio is missing" in data.stderr
    assert not any("error" in one for one in strict_json(data.stdout)["poses"][0]["solutions"])
    doctor = command(tmp_path, "doctor")
    assert doctor.returncode == 0 and "solving works; errors and contacts were not checked" in doctor.stdout
    check = command(tmp_path, "check", ARM, "-n", "2")
    assert check.returncode == 2 and "need Pinocchio, which is not installed" in check.stderr
    assert "Traceback" not in check.stderr
