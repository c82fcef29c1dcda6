"""Files are written whole or not at all, with the folder in the error."""

import errno
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import pytest

import urdf_ik
from urdf_ik import ArgumentError, UrdfIkError
from urdf_ik.show import plot
from urdf_ik.support import files

SCARA = urdf_ik.load("scara_rrpr")
PLAN = SCARA.follow(urdf_ik.line(*SCARA.fk([[0.3, 0.5, 0.1, 0.2], [0.5, 0.7, 0.1, 0.2]]), 20))
OLD = b"what was there before"

# What writes a file, by the ending of its name.
WRITERS: dict[str, Callable[[Path], Any]] = {
    "a.csv": PLAN.to_csv, "t.csv": lambda p: PLAN.timed().to_csv(p),
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
def test_what_cannot_be_written_leaves_what_was_there(name: str, tmp_path: Path) -> None:
    """A full disk, a folder that is missing, a file or a folder in its place: the error names file and folder."""
    file = tmp_path / name
    file.write_bytes(OLD[:16])
    for target in (file, tmp_path / f"new-{name}"):
        with pytest.raises(UrdfIkError, match="cannot write") as refused, full_disk():
            WRITERS[name](target)
        assert str(target) in str(refused.value) and f"folder {tmp_path}" in str(refused.value)
    assert [each.name for each in tmp_path.iterdir()] == [name] and file.read_bytes() == OLD[:16]
    for folder in (tmp_path / "missing", file, *([Path("/proc")] if Path("/proc/self").exists() else [])):
        with pytest.raises(UrdfIkError, match=f"cannot write.*{folder}"):
            WRITERS[name](folder / name)
    file.unlink()
    file.mkdir()
    with pytest.raises(UrdfIkError, match="it is a folder"):
        WRITERS[name](file)


@pytest.mark.parametrize("name", WRITERS)
def test_what_is_there_is_replaced(name: str, tmp_path: Path) -> None:
    """By a file with the same rights, at the end of the link."""
    file, link = tmp_path / name, tmp_path / f"link-{name}"
    file.write_bytes(OLD)
    file.chmod(0o640)
    link.symlink_to(file)
    WRITERS[name](link)
    assert link.is_symlink() and len(list(tmp_path.iterdir())) == 2
    assert file.read_bytes() != OLD
    assert os.name == "nt" or file.stat().st_mode & 0o777 == 0o640


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
