"""The examples of docstrings print what they show."""

from __future__ import annotations

import doctest
import importlib
import pkgutil
import warnings
from pathlib import Path

import pytest

import urdf_ik

# The package's own folder: the path of an editable install holds others, where the bundled URDFs come from.
FOLDER = str(Path(urdf_ik.__file__).parent)
NAMES = ["urdf_ik", *(module.name for module in pkgutil.walk_packages([FOLDER], "urdf_ik."))]


def examples_of(name: str) -> list[doctest.DocTest]:
    """The examples of a module, without what it imports from others."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        module = importlib.import_module(name)
    return [test for test in doctest.DocTestFinder().find(module, name) if test.examples]


@pytest.mark.parametrize("name", [name for name in NAMES if not name.endswith(("__main__", "_core"))])
def test_examples(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every example of a module runs, in a folder of its own, and prints what stands below it."""
    monkeypatch.chdir(tmp_path)
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    printed: list[str] = []
    for test in examples_of(name):
        runner.run(test, out=printed.append)
    assert not runner.failures, "".join(printed)
