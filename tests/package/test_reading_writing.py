"""Files: read up to a limit, and no pipe is waited for; written whole or not at all, with the folder in the error."""

from __future__ import annotations

import errno
import io
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import pytest
from command import ARM, TYPED, call

import urdf_ik
from urdf_ik import ArgumentError, UrdfIkError
from urdf_ik.show import plot
from urdf_ik.support import files

POSIX = pytest.mark.skipif(os.name == "nt", reason="pipes, links and limits of POSIX")
SCARA = urdf_ik.load("scara_rrpr")
PLAN = SCARA.follow(urdf_ik.line(*SCARA.fk([[0.3, 0.5, 0.1, 0.2], [0.5, 0.7, 0.1, 0.2]]), 20))
OLD = b"what was there before"

# What writes a file, by the ending of its name.
WRITERS: dict[str, Callable[[Path], Any]] = {
    "a.csv": PLAN.to_csv, "a.json": PLAN.to_json, "a.npz": PLAN.to_npz, "t.csv": lambda p: PLAN.timed().to_csv(p),
    "t.json": lambda p: PLAN.timed().to_json(p), "t.npz": lambda p: PLAN.timed().to_npz(p),
    "arm.urdf": SCARA.model.write, "arm.png": lambda p: plot.save(plot.arm(SCARA), p),
    "arm.svg": lambda p: plot.save(plot.arm(SCARA), p),
    "map.npz": lambda p: urdf_ik.maps.workspace(urdf_ik.load("planar_2r"), 0.1, 4).save(p),
}  # fmt: skip


@contextmanager
def full_disk() -> Iterator[None]:
    """Every file that grows beyond 16 bytes meets an error of the system's, for the administrator too."""
    resource = pytest.importorskip("resource", reason="only POSIX limits the size of files")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (16, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, ignored)


@pytest.mark.parametrize("name", WRITERS)
def test_a_full_disk_leaves_what_was_there(name: str, tmp_path: Path) -> None:
    """The error is one of ours and names file and folder; the old file is whole, and nothing else is left behind."""
    file = tmp_path / name
    file.write_bytes(OLD[:16])
    for target in (file, tmp_path / f"new-{name}"):
        with pytest.raises(UrdfIkError, match="cannot write") as refused, full_disk():
            WRITERS[name](target)
        assert str(target) in str(refused.value) and f"folder {tmp_path}" in str(refused.value)
    assert [each.name for each in tmp_path.iterdir()] == [name]
    assert file.read_bytes() == OLD[:16]


@pytest.mark.parametrize("name", WRITERS)
def test_a_folder_that_takes_no_files(name: str, tmp_path: Path) -> None:
    """A folder that is not there, a file in the place of one, and a folder of the kernel's."""
    (tmp_path / "file").touch()
    places = [tmp_path / "missing", tmp_path / "file", *([Path("/proc")] if Path("/proc/self").exists() else [])]
    for folder in places:
        with pytest.raises(UrdfIkError, match=f"cannot write.*{folder}"):
            WRITERS[name](folder / name)
    (tmp_path / name).mkdir()
    with pytest.raises(UrdfIkError, match="it is a folder"):
        WRITERS[name](tmp_path / name)


@pytest.mark.parametrize("name", WRITERS)
def test_what_is_there_is_replaced(name: str, tmp_path: Path) -> None:
    """By a file with the same rights, at the end of the link that was given."""
    file = tmp_path / name
    file.write_bytes(OLD)
    file.chmod(0o640)
    link = tmp_path / f"link-{name}"
    link.symlink_to(file)
    WRITERS[name](link)
    assert link.is_symlink() and len(list(tmp_path.iterdir())) == 2
    assert file.read_bytes() != OLD
    if os.name != "nt":
        assert file.stat().st_mode & 0o777 == 0o640


def test_a_writer_that_stops_halfway_leaves_nothing(tmp_path: Path) -> None:
    """Whatever stops it: an error of the disk, one of another kind, Ctrl-C."""
    for failure in (OSError(errno.EIO, "I/O error"), ValueError("no"), KeyboardInterrupt()):

        def half(file: IO[bytes], failure: BaseException = failure) -> None:
            file.write(b"half")
            raise failure

        (tmp_path / "old").write_bytes(OLD)
        expected = ArgumentError if isinstance(failure, OSError) else type(failure)
        for name in ("old", "new"):
            with pytest.raises(expected):
                files.write(tmp_path / name, half)
        assert [each.name for each in tmp_path.iterdir()] == ["old"]
        assert (tmp_path / "old").read_bytes() == OLD


def test_a_file_in_a_folder_that_takes_no_new_ones(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is written where it stands. The right to make files is taken away by hand: an administrator always has it."""
    opened = os.open

    def deny(path: Any, flags: int, *rest: Any, **named: Any) -> int:
        if flags & os.O_EXCL:
            raise PermissionError(errno.EACCES, "Permission denied")
        return opened(path, flags, *rest, **named)

    monkeypatch.setattr(os, "open", deny)
    with pytest.raises(ArgumentError, match=f"Permission denied .folder {tmp_path}"):
        files.write(tmp_path / "new", b"text")
    (tmp_path / "old").write_bytes(OLD)
    files.write(tmp_path / "old", b"text")
    assert (tmp_path / "old").read_bytes() == b"text"


@POSIX
def test_pipes_links_and_devices(tmp_path: Path) -> None:
    """A pipe without another end is not waited for, a circle of links is refused and stays, a device is written."""
    pipe, loop = tmp_path / "pipe", tmp_path / "loop"
    os.mkfifo(pipe)
    loop.symlink_to(loop)
    assert files.read(pipe, 10) == b""
    for odd in (pipe, loop):
        with pytest.raises(ArgumentError, match="cannot write"):
            files.write(odd, b"text")
    assert loop.is_symlink() and pipe.is_fifo()
    for odd, words in ((loop, "symbolic links"), (tmp_path, "directory")):
        with pytest.raises(ArgumentError, match=f"cannot read.*{words}"):
            files.read(odd, 10)
    files.write("/dev/null", b"text")
    ours, theirs = os.pipe()
    os.write(theirs, b"text")
    os.close(theirs)
    assert files.read(f"/dev/fd/{ours}", 10) == b"text"
    os.close(ours)


class Dripping(io.RawIOBase):
    """A file that gives three bytes at a time, as a pipe may, and counts them."""

    def __init__(self, data: bytes) -> None:
        self._data, self.given = data, 0

    def readable(self) -> bool:
        """It is."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Three bytes at most."""
        part = self._data[self.given : self.given + min(3, len(buffer))]
        buffer[: len(part)] = part
        self.given += len(part)
        return len(part)


def test_no_more_than_the_limit_is_read() -> None:
    """Of an open file, in however small parts it comes; one byte more tells that it is too large."""
    assert files.read(Dripping(b"0123456789"), 10) == b"0123456789"
    dripping = Dripping(bytes(1000))
    with pytest.raises(ArgumentError, match="larger than 10 bytes"):
        files.read(dripping, 10)
    assert dripping.given == 11
    assert files.read(io.StringIO("äöü"), 6) == "äöü".encode()
    with pytest.raises(ArgumentError, match="larger than 5 bytes"):
        files.read(io.StringIO("äöü"), 5)


def test_a_urdf_from_an_open_file_is_read_no_further_than_its_limit() -> None:
    """As from standard input, which may have no end."""
    from urdf_ik.model import xml

    endless = Dripping(b"<robot name='x'>" + b" " * (3 * 2**20))
    limit = xml.MAX_BYTES
    try:
        xml.MAX_BYTES = 2**10
        with pytest.raises(urdf_ik.UrdfError, match="larger than"):
            urdf_ik.load(endless)
    finally:
        xml.MAX_BYTES = limit
    assert endless.given == 2**10 + 1
    whole = urdf_ik.load(Dripping(SCARA.model.xml), SCARA.base, SCARA.tip)
    assert whole.joint_names == SCARA.joint_names


def test_files_that_give_odd_things() -> None:
    """A closed file, a read() that fails, gives None or takes no size: read, or refused in words."""

    class Odd:
        def __init__(self, answer: Any) -> None:
            self._answer = answer

        def read(self) -> Any:
            if isinstance(self._answer, Exception):
                raise self._answer
            return self._answer

    closed = io.BytesIO(b"1")
    closed.close()
    for odd in (closed, Odd(None), Odd(5), Odd(OSError("gone"))):
        with pytest.raises(ArgumentError, match="cannot read"):
            files.read(odd, 10)
        with pytest.raises(UrdfIkError):
            urdf_ik.load(odd)
        with pytest.raises(UrdfIkError):
            urdf_ik.read_waypoints(odd)
    assert files.read(Odd(b"all"), 10) == b"all"


@pytest.mark.parametrize(
    "args",
    [
        ("fk", ARM, "--q", TYPED, "-o", "x.json"), ("ik", ARM, "--q", TYPED, "--no-check", "-o", "x.npz"),
        ("dh", "puma_560", "-o", "x.urdf"), ("plot", "planar_2r", "arm", "-o", "x.png"),
        ("view", "planar_2r", "-o", "x.html"),
        ("workspace", "planar_2r", "--voxel", "0.2", "--orientations", "2", "-o", "x.npz"),
        ("workspace", "planar_2r", "--voxel", "0.2", "--orientations", "2", "--store", "x.zarr"),
    ],
)  # fmt: skip
def test_the_command_says_what_cannot_be_written(
    args: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Status 2, one line that names the place, and no file that is half there."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    with full_disk():
        result = call(*args)
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1 and "cannot write" in result.stderr and "x." in result.stderr
    assert not [each for each in tmp_path.iterdir() if each.is_file()]
