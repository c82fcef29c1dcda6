"""load: from open files and by name, and the errors for inputs that it refuses."""

import re
from pathlib import Path

import numpy as np
import pytest
from arms import ur_like
from oracle import Oracle

import urdf_ik
from urdf_ik.errors import ArgumentError, UrdfError
from urdf_ik.model import catalogue

Q = np.array([0.3, 0.5, 0.9, 0.4, 0.8, -0.2])
TEXT = ur_like().urdf


def test_load_from_an_open_file(tmp_path: Path) -> None:
    """A file that is open stays open, and is read from where it stands."""
    file = tmp_path / "an arm.urdf"
    file.write_text(TEXT)
    for mode in ("r", "rb"):
        with file.open(mode) as stream:
            assert urdf_ik.load(stream, "base", "tool").name == "ur_like"
            assert not stream.closed


def test_load_by_name() -> None:
    """A catalogue name brings base and tip along, either of which may be replaced."""
    entry = catalogue.resolve("zyyzyz_6r")
    by_name, by_path = urdf_ik.load("zyyzyz_6r"), urdf_ik.load(entry.path)
    assert (by_name.base, by_name.tip) == (entry.base, entry.tip) == (by_path.base, by_path.tip)
    oracle = Oracle(entry.path, "base_link", "tool0")
    np.testing.assert_allclose(by_name.fk(Q), oracle.pose(Q), atol=1e-14)
    shorter = by_name.chain.joint_names[:3]
    link = by_name.model.joints[[joint.name for joint in by_name.model.joints].index(shorter[-1])].child
    assert urdf_ik.load("zyyzyz_6r", tip=link).joint_names == shorter


def test_a_file_goes_before_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a file in this folder has the name of a catalogue arm, the file is meant."""
    (tmp_path / "ur5").write_text(TEXT)
    monkeypatch.chdir(tmp_path)
    assert urdf_ik.load("ur5", "base", "tool").name == "ur_like"


def test_unknown_names_and_missing_files() -> None:
    """An unknown word raises ArgumentError with similar names; a missing path raises UrdfError."""
    with pytest.raises(ArgumentError, match="zyyzyz_6r"):
        urdf_ik.load("zyyzyz-6r")
    for missing in ("nowhere/arm.urdf", "arm.urdf", Path("zyyzyz_6r_not_here")):
        with pytest.raises((UrdfError, OSError), match=re.escape(str(missing))):
            urdf_ik.load(missing)
