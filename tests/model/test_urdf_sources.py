"""Where a URDF is read from: paths, text, bytes and streams, and what cannot be read."""

import io
from pathlib import Path

import pytest
from urdf_texts import TINY

from urdf_ik.errors import UrdfError
from urdf_ik.model.urdf import read


@pytest.mark.parametrize(
    "make",
    [
        lambda path: path,
        str,
        lambda path: path.read_text(encoding="utf-8"),
        lambda path: "\n  " + path.read_text(encoding="utf-8").partition("?>")[2],
        lambda path: path.read_bytes(),
        lambda path: b"\xef\xbb\xbf" + path.read_bytes(),
        lambda path: path.read_text(encoding="utf-8").encode("utf-16"),
        lambda path: io.BytesIO(path.read_bytes()),
        lambda path: path.read_text(encoding="utf-8").replace("\n", "\r\n").encode(),
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


@pytest.mark.parametrize(
    ("source", "problem"),
    [
        ("no_such_robot.urdf", "neither an existing file nor XML text"),
        (b"robot", "is no XML"),
        (b"<robot name='r'>\n<link name='\xe9'/></robot>", "not utf-8 text: byte 0xe9"),
        (b'<?xml version="1.0" encoding="klingon"?><robot/>', "unusable encoding"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused_in_words(source: object, problem: str) -> None:
    """A source that is no URDF text ends in an UrdfError with a hint, never in an error of Python's."""
    with pytest.raises(UrdfError, match=problem) as caught:
        read(source)  # type: ignore[arg-type]
    assert caught.value.hint
    assert len(str(caught.value)) < 500
