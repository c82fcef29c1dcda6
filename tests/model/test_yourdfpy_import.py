"""The import of yourdfpy: what it leaves out, and that nothing of yourdfpy is lost by it."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

URDF = Path(__file__).resolve().parents[2] / "urdf" / "zyyzyz_6r.urdf"
SLOW = {"networkx", "scipy", "trimesh"}


def _run(code: str, *arguments: str) -> Any:
    """What a fresh process prints, read as JSON."""
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_first_answer_imports_neither_trimesh_nor_scipy() -> None:
    """Loading and solving an arm of primitive shapes imports none of the packages that yourdfpy needs for meshes."""
    imported = _run(
        "import json, sys, urdf_ik; arm = urdf_ik.load(sys.argv[1]); assert arm.ik(arm.fk([0.1] * 6)).q.size\n"
        "print(json.dumps(sorted(sys.modules)))",
        str(URDF),
    )
    assert "yourdfpy" in imported
    assert not SLOW & set(imported)


@pytest.mark.parametrize("first", ["urdf_ik", "yourdfpy", "trimesh"])
def test_yourdfpy_draws_scenes_whatever_is_imported_first(first: str) -> None:
    """A user's own yourdfpy makes scenes of trimesh's class, with the same frames in every order of imports."""
    frames = _run(
        f"import {first}, json, sys, urdf_ik; urdf_ik.load(sys.argv[1]); import yourdfpy, trimesh\n"
        "robot = yourdfpy.URDF.load(sys.argv[1]); assert isinstance(robot.scene, trimesh.Scene)\n"
        "assert yourdfpy.urdf.trimesh.Trimesh is trimesh.Trimesh and sys.modules['trimesh'].__version__\n"
        "robot.update_cfg([0.1] * 6)\n"
        "print(json.dumps([robot.get_transform(link).tolist() for link in robot.link_map]))",
        str(URDF),
    )
    expected = _run(
        "import json, sys, yourdfpy; robot = yourdfpy.URDF.load(sys.argv[1]); robot.update_cfg([0.1] * 6)\n"
        "print(json.dumps([robot.get_transform(link).tolist() for link in robot.link_map]))",
        str(URDF),
    )
    assert frames == expected


def test_a_yourdfpy_that_needs_more_of_trimesh_is_imported_as_it_is(tmp_path: Path) -> None:
    """A release of yourdfpy whose classes derive from trimesh's is imported with trimesh."""
    (tmp_path / "yourdfpy").mkdir()
    (tmp_path / "yourdfpy" / "__init__.py").write_text("from .urdf import URDF\n")
    (tmp_path / "yourdfpy" / "urdf.py").write_text("import trimesh\nclass URDF(trimesh.Scene):\n    pass\n")
    parents = _run(
        "import json, sys; sys.path.insert(0, sys.argv[1])\n"
        "from urdf_ik.model.urdf.yourdfpy_import import yourdfpy\n"
        "print(json.dumps([each.__module__ for each in yourdfpy().URDF.__mro__]))",
        str(tmp_path),
    )
    assert "trimesh.scene.scene" in parents


def test_another_threads_import_is_trimesh() -> None:
    """While this package imports yourdfpy, an import of trimesh in another thread gives trimesh."""
    names = _run(
        "import json, sys, threading; from urdf_ik.model.urdf.yourdfpy_import import yourdfpy; seen = []\n"
        "def imports():\n    import trimesh; seen.append(trimesh.Scene.__module__)\n"
        "threads = [threading.Thread(target=each) for each in (yourdfpy, imports, yourdfpy, imports)]\n"
        "[each.start() for each in threads]; [each.join() for each in threads]\n"
        "seen.append(type(yourdfpy().URDF.load(sys.argv[1]).scene).__module__); print(json.dumps(seen))",
        str(URDF),
    )
    assert names == ["trimesh.scene.scene"] * 3
