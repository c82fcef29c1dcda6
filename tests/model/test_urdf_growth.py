"""Work and memory that grow with a hostile URDF: linear below limits, and limits that the error names."""

from __future__ import annotations

import gzip
import io
import tracemalloc
from collections.abc import Callable

import pytest

import urdf_ik
from urdf_ik import ArgumentError, ChainError, UrdfError, UrdfIkError, World
from urdf_ik.model.urdf import read, tree
from urdf_ik.model.xml import ENCODINGS, MAX_BYTES

TINY = '<robot name="r"><link name="a"/>'


def row(count: int, mimic: Callable[[int], str] = lambda k: "", name: str = "j") -> str:
    """A chain of joints, each with what ``mimic`` says."""
    parts = [
        f'<link name="l{k + 1}"/><joint name="{name}{k}" type="continuous"><parent link="l{k}"/>'
        f'<child link="l{k + 1}"/><origin xyz="0.1 0 0"/><axis xyz="0 {k % 2} 1"/>{mimic(k)}</joint>'
        for k in range(count)
    ]  # fmt: skip
    return f'<robot name="r"><link name="l0"/>{"".join(parts)}</robot>'


def steps(call: Callable[[], object]) -> int:
    """Lines of Python that are run: a measure of work that no other program disturbs."""
    import sys

    count = 0

    def trace(*_: object) -> object:
        nonlocal count
        count += 1
        return trace

    sys.settrace(trace)  # type: ignore[arg-type]
    try:
        call()
    finally:
        sys.settrace(None)
    return count


@pytest.mark.parametrize("towards", [-1, 1])
def test_rows_of_mimics_take_linear_work(towards: int) -> None:
    """Each mimics the one before it, or the one after it: twice the joints, twice the work."""

    def checked(count: int) -> int:
        mimic = lambda k: f'<mimic joint="j{k + towards}"/>' if 0 <= k + towards < count else ""  # noqa: E731
        from urdf_ik.model.urdf.defects import Defects
        from urdf_ik.model.xml import open_source, parse

        robot = parse(open_source(row(count, mimic)))
        found = Defects()
        links = tree.check_links(robot, "", found)
        return steps(lambda: tree.check_mimics(tree.check_joints(robot, links, "", found), found))

    assert checked(400) < 2.5 * checked(200)


def test_the_longest_chain_is_read() -> None:
    """As many joints in a row as links are allowed: no recursion, whether they are free, fixed or mimic each other."""
    assert urdf_ik.load(row(tree.MAX_LINKS - 1)).dof == tree.MAX_LINKS - 1
    assert urdf_ik.load(row(tree.MAX_LINKS - 1, lambda k: f'<mimic joint="j{k - 1}"/>' if k else "")).dof == 1


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (row(tree.MAX_LINKS + 1), f"more than {tree.MAX_LINKS} links"),
        (TINY + '<link name="b"/>' + "".join(
            f'<joint name="j{k}" type="fixed"><parent link="a"/><child link="b"/></joint>' for k in range(600)
        ) + "</robot>", f"more than {tree.MAX_LINKS} joints"),
        (TINY.replace('"a"/>', '"a">') + "<visual/>" * 11_000 + "</link></robot>", "more than 10000 shapes"),
        (TINY + '<material name="m"/>' * 11_000 + "</robot>", "more than 10000 materials"),
        (TINY + '<link name="b"/><joint name="j" type="fixed"><parent link="a"/><child link="b"/><origin xyz="'
         + "1 " * 100_000 + '"/></joint></robot>', "has 200000 characters"),
        (TINY + " " * MAX_BYTES + "</robot>", "larger than 8 MiB"),
        ("<a>" * 100_000, "malformed XML"),
    ],
)  # fmt: skip
def test_what_is_too_much_is_refused_with_the_limit(text: str, words: str) -> None:
    """As text, as bytes, as an open file, packed."""
    for source in (text, text.encode(), io.StringIO(text), io.BytesIO(text.encode())):
        with pytest.raises(UrdfError, match=words):
            read(source, strict=True)
    with pytest.raises(UrdfError, match=f"{words}|unpacks to more than 8 MiB"):
        read(gzip.compress(text.encode()), strict=True)


def test_an_endless_file_is_not_read_to_its_end() -> None:
    """What an open file gives is cut off a byte after the limit."""

    class Endless(io.RawIOBase):
        def read(self, size: int = -1) -> bytes:
            assert 0 <= size <= MAX_BYTES + 1
            return b"<" * size

    with pytest.raises(UrdfError, match="larger than 8 MiB"):
        read(Endless())  # type: ignore[arg-type]
    with open("/dev/zero", "rb") as file, pytest.raises(UrdfError):
        read(file)


def test_memory_stays_within_bounds() -> None:
    """The smallest elements that there are, as many as fit."""
    text = TINY + "<a/>" * ((MAX_BYTES - 100) // 4) + "</robot>"
    tracemalloc.start()
    try:
        with pytest.raises(ChainError):
            urdf_ik.load(text)
        assert tracemalloc.get_traced_memory()[1] < 200 * 2**20
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("encoding", ["punycode", "idna", "unicode_escape", "rot13", "hex", "zlib", "mbcs", "x"])
def test_encodings_that_are_none_of_xml_are_refused(encoding: str) -> None:
    """Python's other codecs are slow, or change what a text says."""
    with pytest.raises(UrdfError, match="unusable encoding"):
        read(f'<?xml version="1.0" encoding="{encoding}"?>{TINY}</robot>'.encode() + b"\xff" * 2**20)


@pytest.mark.parametrize(
    "encoding", ["utf-8", "UTF-16", "ISO-8859-1", "latin1", "windows-1252", "Shift_JIS", "GB18030"]
)
def test_encodings_of_xml_are_read(encoding: str) -> None:
    """The usual ones by their usual names."""
    text = f'<?xml version="1.0" encoding="{encoding}"?>{TINY}</robot>'
    assert read(text.encode(encoding)).root == "a"
    assert "punycode" not in ENCODINGS


@pytest.mark.parametrize("name", ["x" * 10**6, "x" * 79 + "\u202e", "\x9b31m", "tip\u2066\u2069", "a\u2028b"])
def test_names_are_quoted_short_and_as_they_can_be_shown(name: str) -> None:
    """At most 80 characters of a name, no control character and no mark that turns the direction of writing."""
    asked: list[Callable[[], object]] = [
        lambda: urdf_ik.load(row(2), tip=name), lambda: urdf_ik.load(row(2), base=name),
        lambda: urdf_ik.load(row(2), locked={name: 0.0}), lambda: urdf_ik.load(row(2), chain=name),
        lambda: urdf_ik.load(row(2).replace('parent link="l1"', f'parent link="{name}"')),
        lambda: urdf_ik.load(row(2).replace('type="continuous"', f'type="{name}"')),
        lambda: urdf_ik.load(row(2, lambda k: f'<mimic joint="{name}"/>')),
        lambda: urdf_ik.load(row(2).replace("continuous", "floating").replace("j0", name)),
        lambda: urdf_ik.load(row(2, lambda k: f'<mimic joint="{name}0"/>', name)),
        lambda: urdf_ik.load(row(8, name=name)).ik([0]),
        lambda: urdf_ik.load(row(2, name=name)).fk([0.0]),
        lambda: urdf_ik.load(row(2).replace("l2", name), tip="x"),
        lambda: World().move(name, [0]), lambda: urdf_ik.load(row(2)).for_task(name), lambda: urdf_ik.load(name),
        lambda: urdf_ik.load("planar_2r").cell.collisions.allow(name, name), lambda: urdf_ik.DHTable.read(name),
        lambda: urdf_ik.read_waypoints(name), lambda: urdf_ik.maps.workspaces.read(name),
        lambda: urdf_ik.Mesh(name).file(),
        lambda: urdf_ik.load("planar_2r").ik([0, 0], task=name), lambda: urdf_ik.Sphere(name),
    ]  # fmt: skip
    for ask in asked:
        with pytest.raises(UrdfIkError) as refused:
            ask()
        text = str(refused.value)
        assert all(c.isprintable() or c == "\n" for c in text), ascii(text[:300])
        assert len(text) < 3000, text[:300]
    assert ArgumentError("\x1b[31m").args == ("\\x1b[31m",)
