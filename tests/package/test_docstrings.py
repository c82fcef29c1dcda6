"""The examples of docstrings print what they show."""

import doctest
import importlib
import pkgutil
import warnings
from pathlib import Path

import pytest

import urdf_ik

# The package's own folder: the path of an editable install holds others, where the bundled URDFs come from.
NAMES = [module.name for module in pkgutil.walk_packages([str(Path(urdf_ik.__file__).parent)], "urdf_ik.")]


@pytest.mark.parametrize("room", sorted({"", *(name.split(".")[1] for name in NAMES)} - {"_core"}))
def test_examples(room: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every example of a room runs, in a folder of its own, and prints what stands below it."""
    monkeypatch.chdir(tmp_path)
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    printed: list[str] = []
    for name in [name for name in NAMES if name.split(".")[1] == room] if room else ["urdf_ik"]:
        if name.endswith("__main__"):
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            module = importlib.import_module(name)
        for test in doctest.DocTestFinder().find(module, name):
            runner.run(test, out=printed.append)
    assert not runner.failures, "".join(printed)
