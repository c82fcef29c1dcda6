"""Where the urdf-ik command writes, and how it looks there: tables, files, terminals, pipes, a full disk."""

import os
import signal
from pathlib import Path

import numpy as np
import pytest
import typer
from command import ARM, TWO_JOINTS, TYPED, start, strict_json, succeed

from urdf_ik.cli.options import Format, format_for


def test_many_poses_are_summed_up_from_the_data() -> None:
    """Over 20 poses the table is a summary, whose counts are those of the data."""
    text = succeed("ik", ARM, "--random", "30")
    poses = strict_json(succeed("ik", ARM, "--random", "30", "-f", "json"))["poses"]
    assert f"30 poses, 30 solved, 0 without a solution, {sum(pose['count'] for pose in poses)} solutions" in text
    histogram = [line.split()[:2] for line in text.splitlines() if line.endswith("#")]
    counts = [pose["count"] for pose in poses]
    assert histogram == [[str(c), str(counts.count(c))] for c in sorted(set(counts))]
    worst = max(one["error"]["position"] for pose in poses for one in pose["solutions"])
    assert f"{worst:.1e} m" in text


def test_info_tells_what_is_known_of_an_arm_that_cannot_be_solved() -> None:
    """Status 0 for any arm that can be read; it says that no solver takes it, and writes a missing limit as null."""
    data = strict_json(succeed("info", "-", "-f", "json", given=TWO_JOINTS))
    assert data["solver"]["supported"] is False
    assert data["joints"][0]["upper"] is None
    assert "no solver" in succeed("info", "-", given=TWO_JOINTS)


def test_output_goes_to_the_file(tmp_path: Path) -> None:
    """--output writes what stdout would have got, leaves stdout empty, and its ending chooses the format."""
    for suffix in ("json", "csv", "npz", "txt"):
        file = tmp_path / f"out.{suffix}"
        kind = "table" if suffix == "txt" else suffix
        assert succeed("ik", ARM, "--q", TYPED, "-o", str(file)) == ""
        if suffix == "npz":
            with np.load(file, allow_pickle=False) as arrays:
                assert arrays["q"].shape == (1, 8, 6)
        else:
            assert file.read_text() == succeed("ik", ARM, "--q", TYPED, "-f", kind)


def test_binary_data_do_not_go_to_a_terminal() -> None:
    """An npz needs --output or a redirection; a format that was asked for wins over the file's ending."""
    with pytest.raises(typer.BadParameter, match="--output"):
        format_for(Format.NPZ, None, terminal=True)
    assert format_for(Format.NPZ, None, terminal=False) is Format.NPZ
    assert format_for(Format.JSON, Path("x.csv"), terminal=True) is Format.JSON


@pytest.mark.skipif(os.name == "nt", reason="signals and pipes of POSIX, which Windows lacks")
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_leaves_ends_it_quietly(unbuffered: str) -> None:
    """``| head -1``: no complaint on stderr, and the status that a shell gives to SIGPIPE."""
    env = os.environ | {"PYTHONUNBUFFERED": unbuffered}
    child = start("ik", ARM, "--random", "500", "--no-check", "-f", "json", env=env)
    assert child.stdout is not None
    assert child.stderr is not None
    assert child.stdout.readline() == b"{\n"
    child.stdout.close()
    complaint = child.stderr.read()
    assert b"rror" not in complaint
    assert b"Exception" not in complaint
    child.stderr.close()
    assert child.wait(timeout=60) == 141


INTERRUPTED = """
import os, signal
from urdf_ik.cli import answers
answers.checked = lambda *_, **__: os.kill(os.getpid(), signal.SIGINT)
"""


@pytest.mark.skipif(os.name == "nt", reason="signals and pipes of POSIX, which Windows lacks")
def test_ctrl_c_ends_it_with_130(tmp_path: Path) -> None:
    """An interrupt in the midst of work: status 130, no traceback and no file."""
    # Tests that run in the background of a script have to ignore Ctrl-C, and so are their children.
    child = start(
        *("ik", ARM, "-o", "solutions.csv"),
        first=INTERRUPTED,
        cwd=tmp_path,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    out, complaint = child.communicate(timeout=60)
    assert (child.returncode, out, complaint) == (130, b"", b"")
    assert not list(tmp_path.iterdir())
