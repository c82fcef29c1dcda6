"""The cache of the kernels' machine code: keyed on their text, in a folder of its own."""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
from pathlib import Path

import pytest
from kernel_samples import fresh
from numba.core import config

from urdf_ik._kernels import compile as compiler


def test_digest_follows_the_kernels_text(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Any edit of any kernel's file, and any new file, changes the cache directory's name; copying them does not."""
    for file in Path(compiler.__file__).parent.glob("*.py"):
        shutil.copy(file, tmp_path)
    expected = compiler._digest()
    monkeypatch.setattr(compiler, "__file__", str(tmp_path / "compile.py"))
    assert compiler._digest() == expected
    seen = {expected}
    for name in ("trig.py", "layout.py", "refine.py"):
        with (tmp_path / name).open("a") as file:
            file.write("# more\n")
        seen.add(compiler._digest())
    (tmp_path / "new.py").write_text("x = 1\n")
    seen.add(compiler._digest())
    assert len(seen) == 5
    monkeypatch.setattr(compiler.numba, "__version__", "0.0.0")
    assert compiler._digest() not in seen


def test_directory_carries_the_digest() -> None:
    """The machine code lies in a directory of its own for this version of the kernels, and exists."""
    assert compiler.CACHE_DIRECTORY.name == f"kernels-{compiler._digest()}" or not os.access(compiler._root(), os.W_OK)
    assert compiler.CACHE_DIRECTORY.is_dir()


def test_numbas_own_cache_setting_is_untouched() -> None:
    """Other packages' Numba functions keep their cache: the global setting is what the environment says."""
    assert os.environ.get("NUMBA_CACHE_DIR", "") == config.CACHE_DIR


@pytest.mark.parametrize(
    ("platform", "environment", "expected"),
    [
        ("linux", {"URDF_IK_CACHE_DIR": "/a", "NUMBA_CACHE_DIR": "/b", "XDG_CACHE_HOME": "/c"}, "/a"),
        ("linux", {"NUMBA_CACHE_DIR": "/b", "XDG_CACHE_HOME": "/c"}, "/b"),
        ("linux", {"XDG_CACHE_HOME": "/c"}, "/c/urdf-ik"),
        ("linux", {"XDG_CACHE_HOME": "", "HOME": "/h"}, "/h/.cache/urdf-ik"),
        ("linux", {"HOME": "/h"}, "/h/.cache/urdf-ik"),
        ("darwin", {"HOME": "/h", "XDG_CACHE_HOME": "/c"}, "/h/Library/Caches/urdf-ik"),
        ("win32", {"LOCALAPPDATA": "/l"}, "/l/urdf-ik"),
    ],
)
def test_cache_folder(
    platform: str, environment: dict[str, str], expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Our own variable comes before Numba's, then the platform's folder for caches."""
    with monkeypatch.context() as patch:
        for name in ("URDF_IK_CACHE_DIR", "NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA"):
            patch.delenv(name, raising=False)
        for name, setting in environment.items():
            patch.setenv(name, setting)
        patch.setattr(sys, "platform", platform)
        found = compiler._root()
    assert found == Path(expected)


def test_directory_falls_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the cache cannot be made, a folder among the temporary ones serves, and in need a new one of its own."""
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    monkeypatch.setenv("URDF_IK_CACHE_DIR", str(blocked))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    shared = compiler._directory()
    assert shared.parent.parent == tmp_path
    assert shared.name == f"kernels-{compiler._digest()}"
    assert compiler._directory() == shared
    shutil.rmtree(shared.parent)
    shared.parent.write_text("in the way, too")
    alone = compiler._directory()
    assert alone.parent == tmp_path
    assert alone.is_dir()


USE = """
import json, numpy as np
from numba.core import config
from urdf_ik._kernels import compile, polynomials
gap = polynomials.root_gap(np.array([[1.0, 0.0], [0.0, 1.0]]), 2, 0)
files = [str(file) for file in compile.CACHE_DIRECTORY.rglob("*.nbi")]
print(json.dumps([gap, str(compile.CACHE_DIRECTORY), files, config.CACHE_DIR]))
"""


def test_cache_directory_is_used(tmp_path: Path) -> None:
    """A kernel's machine code lands below URDF_IK_CACHE_DIR, in this version's directory, and nowhere else."""
    given = json.loads(
        fresh(USE, URDF_IK_CACHE_DIR=str(tmp_path), NUMBA_DISABLE_JIT=None, NUMBA_CACHE_DIR=str(tmp_path / "other"))
    )
    gap, directory, files, numbas = given
    assert gap == 2.0
    assert directory == str(tmp_path / f"kernels-{compiler._digest()}")
    assert [Path(file).name.split("-")[0] for file in files] == ["polynomials.root_gap"]
    assert numbas == str(tmp_path / "other")
    assert not (tmp_path / "other").exists()


def test_unwritable_cache_does_no_harm(tmp_path: Path) -> None:
    """With a file where the cache folder should be, kernels work, and are kept among the temporary files."""
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    gap, directory, files, _ = json.loads(
        fresh(USE, URDF_IK_CACHE_DIR=str(blocked), NUMBA_DISABLE_JIT=None, TMPDIR=str(tmp_path))
    )
    assert gap == 2.0
    assert Path(directory).is_relative_to(tmp_path)
    assert len(files) == 1
