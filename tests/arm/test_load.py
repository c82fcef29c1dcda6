"""load: from every kind of source, by name, and the errors for inputs that it refuses."""

import io
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arms import TWO_HANDS, ur_like
from oracle import Oracle

import urdf_ik
from urdf_ik.errors import ArgumentError, ChainError, UrdfError
from urdf_ik.model import catalogue

Q = np.array([0.3, 0.5, 0.9, 0.4, 0.8, -0.2])
TEXT = ur_like().urdf


def _write(folder: Path) -> Path:
    """The text as a file."""
    file = folder / "an arm.urdf"
    file.write_text(TEXT)
    return file


SOURCES: dict[str, Callable[[Path], Any]] = {
    "text": lambda folder: TEXT,
    "text behind white space": lambda folder: "\n  " + TEXT,
    "text with a declaration": lambda folder: '<?xml version="1.0"?>\n' + TEXT,
    "path": _write,
    "path as text": lambda folder: str(_write(folder)),
    "text stream": lambda folder: io.StringIO(TEXT),
    "binary stream": lambda folder: io.BytesIO(TEXT.encode()),
}


@pytest.mark.parametrize("kind", SOURCES)
def test_load_from(kind: str, tmp_path: Path) -> None:
    """XML text, a path of either type and an open file of either mode give the same arm."""
    arm = urdf_ik.load(SOURCES[kind](tmp_path), "base", "tool")
    expected = urdf_ik.load(TEXT, base="base", tip="tool")
    assert (arm.name, arm.base, arm.tip, arm.dof) == ("ur_like", "base", "tool", 6)
    assert arm.joint_names == expected.joint_names == tuple(f"joint_{i}" for i in range(1, 7))
    np.testing.assert_array_equal(arm.fk(Q), expected.fk(Q))
    np.testing.assert_array_equal(arm.limits, expected.limits)
    assert arm.structure == expected.structure


def test_load_from_an_open_file(tmp_path: Path) -> None:
    """A file that is open stays open, and is read from where it stands."""
    file = _write(tmp_path)
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


@pytest.mark.parametrize("name", ["ur5", "zyyzyz_6r"])
def test_the_way_a_robot_is_named_changes_nothing(name: str, tmp_path: Path) -> None:
    """By name, path, text, copy and xacro a robot has the same base, tip and joints."""
    try:
        file = catalogue.resolve(name).path
    except ArgumentError as absent:
        pytest.skip(f"not installed: {absent}")
    pytest.importorskip("xacro", reason="reads the robot's xacro")
    text = file.read_text()
    copy, macro = tmp_path / "copy.urdf", tmp_path / "copy.urdf.xacro"
    copy.write_text(text)
    begin = re.search(r"<robot [^>]*>", text)
    assert begin
    opened = begin[0] if "xmlns:xacro" in begin[0] else begin[0][:-1] + ' xmlns:xacro="http://www.ros.org/wiki/xacro">'
    macro.write_text(text.replace(begin[0], opened + '<xacro:property name="unused" value="1"/>'))
    arms = [urdf_ik.load(source) for source in (name, file, str(file), text, copy, macro)]
    assert {(arm.base, arm.tip, arm.joint_names) for arm in arms} == {(arms[0].base, arms[0].tip, arms[0].joint_names)}


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


def test_ambiguous_tip() -> None:
    """With two movable chains the tip must be named; the error lists both ends, and naming one settles it."""
    with pytest.raises(ChainError) as error:
        urdf_ik.load(TWO_HANDS)
    assert {"left", "right"} <= set(error.value.candidates)
    assert "left" in str(error.value) and "right" in str(error.value)
    assert urdf_ik.load(TWO_HANDS, tip="left").joint_names == ("waist", "l")
    assert urdf_ik.load(TWO_HANDS, base="left", tip="right").joint_names == ("l", "r")


@pytest.mark.parametrize("which", ["base", "tip"])
def test_unknown_link(which: str) -> None:
    """An unknown base or tip raises ChainError with the links that there are, the nearest one first."""
    with pytest.raises(ChainError, match="rigth") as error:
        urdf_ik.load(TWO_HANDS, **{"base": "base", "tip": "left", which: "rigth"})
    assert error.value.candidates[0] == "right"
    assert set(error.value.candidates) == {"base", "body", "left", "right"}


def test_broken_urdf() -> None:
    """A defect in the file comes out of load as it came out of the reader, with its line."""
    with pytest.raises(UrdfError) as error:
        urdf_ik.load(TEXT.replace('type="revolute"', 'type="revolving"', 1), "base", "tool")
    assert error.value.line is not None
