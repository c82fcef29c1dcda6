"""Where a URDF is read from: paths, text, bytes and streams, and what cannot be read."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from urdf_texts import TINY, edited, refused

from urdf_ik.errors import UrdfError
from urdf_ik.model.urdf import read


@pytest.mark.parametrize(
    "make",
    [
        lambda path: path,
        str,
        lambda path: path.read_text(encoding="utf-8"),
        lambda path: path.read_bytes(),
        lambda path: "\n\n  " + path.read_text(encoding="utf-8"),
        lambda path: "\ufeff" + path.read_text(encoding="utf-8"),
        lambda path: b"\xef\xbb\xbf" + path.read_bytes(),
        lambda path: path.read_text(encoding="utf-8").encode("utf-16"),
        lambda path: io.BytesIO(path.read_bytes()),
        lambda path: io.StringIO(path.read_text(encoding="utf-8")),
        lambda path: path.read_text(encoding="utf-8").replace("\n", "\r\n").encode(),
        lambda path: path.read_text(encoding="utf-8").replace('"1.0"', '"1.0" encoding="UTF-8"'),
        lambda path: path.read_text(encoding="utf-8").replace('"1.0"', '"1.0" encoding="utf-16"'),
        lambda path: path.read_text(encoding="utf-8").replace('"1.0"', '"1.0" encoding="cp1252"').encode("cp1252"),
    ],
)
def test_every_kind_of_source_gives_the_same_robot(make: object, tmp_path: Path) -> None:
    """Path, text, bytes and streams, with any byte order mark, encoding and line ends, read alike."""
    path = tmp_path / "r\u00f6bot arm.urdf"
    path.write_text(TINY.replace("tool", "w\u00e9rkzeug"), encoding="utf-8")
    model = read(make(path))  # type: ignore[operator]
    assert model.xml == read(path).xml
    assert model.links[-1] == "w\u00e9rkzeug"


def test_open_files_are_read_and_named(tmp_path: Path) -> None:
    """A text or binary file that is open gives its name to the messages."""
    path = tmp_path / "a.urdf"
    path.write_text(edited(11, "0 0 1", "0 0 0"))
    for mode in ("r", "rb"):
        with path.open(mode) as file:
            assert refused(file).source == str(path)


@pytest.mark.parametrize(
    ("source", "problem"),
    [
        ("no_such_robot.urdf", "neither an existing file nor XML text"),
        (Path("no_such_robot.urdf"), "neither an existing file nor XML text"),
        ("robot: tiny\nlinks: 3\n" * 1000, "cannot read|neither"),
        ("null\0byte.urdf", "cannot read|neither"),
        (b"robot", "is no XML"),
        (b"\xff\xfe", "empty|no XML"),
        (None, "cannot read a URDF from NoneType"),
        (42, "cannot read a URDF from int"),
        ("<robot name='\udc80'/>", "malformed XML"),
        (b"<robot name='r'>\n<link name='\xe9'/></robot>", "not utf-8 text: byte 0xe9"),
        (b'<?xml version="1.0" encoding="klingon"?><robot/>', "unusable encoding"),
        (b'<?xml version="1.0" encoding="hex"?><robot/>', "unusable encoding"),
        (b"<robot name='r'>\0</robot>", "malformed XML"),
        (io.TextIOWrapper(io.BytesIO(b"<robot name='\xe9'/>"), encoding="utf-8"), "cannot read the open file"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused_in_words(source: object, problem: str) -> None:
    """A source that is no URDF text ends in an UrdfError with a hint, never in an error of Python's."""
    with pytest.raises(UrdfError, match=problem) as caught:
        read(source)  # type: ignore[arg-type]
    assert caught.value.hint
    assert len(str(caught.value)) < 500


def test_files_that_cannot_be_read_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A directory, a closed file, a file of bytes and a file without rights each say what they are."""
    (tmp_path / "inside.urdf").write_text(TINY)
    error = refused(tmp_path)
    assert "directory" in error.problem
    assert "inside.urdf" in str(error.hint)

    with (tmp_path / "inside.urdf").open() as closed:
        pass
    assert "closed file" in refused(closed).problem

    (tmp_path / "bytes.urdf").write_bytes(b"<robot>\n\xff\xff\n")
    assert refused(tmp_path / "bytes.urdf").line == 2

    def deny(*_: object) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_bytes", deny)
    assert "Permission denied" in refused(tmp_path / "inside.urdf").problem
