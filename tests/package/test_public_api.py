"""What ``import urdf_ik`` gives, and what it must not cost."""

import importlib
import inspect
import json
import re
import subprocess
import sys
from pathlib import Path

import urdf_ik
from urdf_ik import errors

PROMISED = ("load", "Arm", "Chain", "Structure", "IKSolutions", "Solution", "Singular", "pose")
HEAVY = {"pinocchio", "coal", "yourdfpy", "trimesh", "matplotlib", "viser", "typer", "rich"}
# Numba itself imports the bare ``scipy`` for its version; the weight lies in the subpackages.
HEAVY |= {"scipy.linalg", "scipy.optimize", "scipy.sparse", "scipy.spatial"}


def answer_of(code: str) -> object:
    """What a fresh interpreter prints as JSON when it runs the code."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_every_exported_name_exists_once() -> None:
    """The stable names are there, and each name has a docstring where it is a class or function."""
    assert len(set(urdf_ik.__all__)) == len(urdf_ik.__all__) and set(PROMISED) <= set(urdf_ik.__all__)
    assert {"calibration", "maps", "show", "verify", *urdf_ik.__all__} <= set(dir(urdf_ik))
    for name in urdf_ik.__all__:
        exported = getattr(urdf_ik, name)
        assert not name.startswith("_") or name == "__version__"
        assert exported.__doc__ or not (inspect.isclass(exported) or inspect.isfunction(exported)), name


def test_the_stub_names_what_the_package_gives() -> None:
    """Editors and mypy see the names that are imported at their first use."""
    stub = Path(urdf_ik.__file__).with_suffix(".pyi").read_text()
    listed = re.findall(r"^from (urdf_ik[\w.]*) import (\w+) as \2$", stub, re.MULTILINE)
    assert sorted(name for _, name in listed) == sorted([*urdf_ik.__all__, "__version__"])
    for module, name in listed:
        assert getattr(importlib.import_module(module), name) is getattr(urdf_ik, name)


def test_every_error_is_exported_and_has_one_root() -> None:
    """All errors that the package raises on purpose are caught by UrdfIkError and can be named from urdf_ik."""
    own = {
        name: value
        for name, value in vars(errors).items()
        if inspect.isclass(value) and value.__module__ == errors.__name__
    }
    assert all(issubclass(value, urdf_ik.UrdfIkError) for value in own.values())
    assert all(getattr(urdf_ik, name) is value for name, value in own.items())
    assert set(own) <= set(urdf_ik.__all__)


def test_import_brings_none_of_the_heavy_packages() -> None:
    """In a fresh interpreter ``import urdf_ik`` loads nothing that only some of its rooms need."""
    code = "import json, sys, urdf_ik; print(json.dumps(sorted(sys.modules)))"
    loaded = answer_of(code)
    assert isinstance(loaded, list) and "urdf_ik" in loaded
    assert HEAVY.isdisjoint(loaded), sorted(HEAVY & set(loaded))
