"""The urdf-ik command: what it prints, in which format, and the status it ends with."""

from __future__ import annotations

import csv
import io
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import typer
from arms import industrial
from numpy.typing import NDArray
from oracle import Oracle, angle_distance
from typer.testing import CliRunner, Result

from urdf_ik import catalogue, completeness, crosscheck
from urdf_ik._cli_options import Format, format_for
from urdf_ik.cli import app

Array = NDArray[np.float64]

ARM = "zyyzyz_6r"
Q = (0.3, -0.5, 0.8, 0.4, 0.7, -0.2)
TYPED = ",".join(map(str, Q))
COMMANDS = ("info", "fk", "ik", "check", "compare", "dh", "workspace", "plot")
# Two joints about one axis: no solver takes what is redundant everywhere.
TWO_JOINTS = """<robot name="planar"><link name="a"/><link name="b"/><link name="c"/>
<joint name="one" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
<joint name="two" type="continuous"><parent link="b"/><child link="c"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/></joint>
</robot>"""


def call(*args: str, given: str | bytes | None = None, **env: str) -> Result:
    """Run the command in this process; an exception that is no exit is passed on."""
    result = CliRunner().invoke(app, list(args), input=given, env={"COLUMNS": "100", **env}, catch_exceptions=False)
    assert "Traceback" not in result.output
    return result


def succeed(*args: str, given: str | bytes | None = None, **env: str) -> str:
    """Standard output of a run that must end with status 0; standard error may only hold progress."""
    result = call(*args, given=given, **env)
    assert result.exit_code == 0, result.output
    assert "rror" not in result.stderr
    return result.stdout


def start(*args: str, **options: Any) -> subprocess.Popen[bytes]:
    """Start the command as a program of its own."""
    command = [sys.executable, "-c", "from urdf_ik.cli import main; main()", *args]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)


def strict_json(text: str) -> Any:
    """Parse JSON, and refuse the NaN and Infinity that Python would take."""

    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is no JSON")

    return json.loads(text, parse_constant=refuse)


@lru_cache
def oracle(name: str = ARM) -> Oracle:
    """Pinocchio's model of a bundled arm."""
    return Oracle(catalogue.resolve(name).path, "base_link", "tool0")


def target() -> Array:
    """The pose (4, 4) of ``Q`` by Pinocchio."""
    return oracle().pose(np.array(Q))


def vectors(text: str) -> Array:
    """Joint vectors (k, n) of the solutions of the first pose in JSON."""
    return np.array([one["q"] for one in strict_json(text)["poses"][0]["solutions"]])


def comma(values: Sequence[float] | Array) -> str:
    """Numbers as they are typed."""
    return ",".join(repr(float(x)) for x in values)


# Status and messages


@pytest.mark.parametrize(
    ("args", "given", "status", "words"),
    [
        (("ik", ARM, "--xyz", "9,0,0", "--rpy", "0,0,0", "-f", "csv"), None, 1, ("1 of 1 poses have no solution",)),
        (("ik",), None, 2, ("ROBOT",)),
        (("turn", ARM), None, 2, ("turn",)),
        (("ik", ARM, "--frob"), None, 2, ("--frob",)),
        (("ik", ARM, "--format", "xml"), None, 2, ("xml", "table", "json", "csv", "npz")),
        (("ik", ARM, "--random", "0"), None, 2, ("--random", "equal to 1")),
        (("ik", ARM, "--random", "2", "--q", TYPED), None, 2, ("--q and --random",)),
        (("ik", ARM, "--xyz", "1,2,3"), None, 2, ("--quat-xyzw", "--rotvec", "none given")),
        (("ik", ARM, "--rpy", "0,0,0"), None, 2, ("--rpy", "--xyz")),
        (("ik", ARM, "--xyz", "1,2", "--rpy", "0,0,0"), None, 2, ("1,2", "3 are needed", "x,y,z")),
        (("ik", ARM, "--xyz", "1,2,up", "--rpy", "0,0,0"), None, 2, ("'up'",)),
        (("ik", ARM, "--xyz", "1,2,nan", "--rpy", "0,0,0"), None, 2, ("1,2,nan", "finite")),
        (("ik", ARM, "--xyz", "1,0,0", "--quat-wxyz", "0,0,0,0"), None, 2, ("zero",)),
        (("ik", ARM, "--q", "1,2,3"), None, 2, ("1,2,3", "joint_6")),
        (("ik", ARM, "--nearest", "1"), None, 2, ("--nearest", "joint_6")),
        (("ik", ARM, "--poses", "no/such.csv"), None, 2, ("no/such.csv", "No such file")),
        (("ik", ARM, "--poses", "-"), "", 2, ("standard input is empty", "qx,qy,qz,qw")),
        (("ik", ARM, "--poses", "-"), "1,2,3\n", 2, ("(1, 3)", "qx,qy,qz,qw")),
        (("ik", ARM, "--poses", "-"), "1,0,0,0,0,0,1\n1,0,0,0,0,east,1\n", 2, ("'east'",)),
        (("ik", ARM, "--poses", "-"), "1,0,0,0,0,0,1\n1,0,0\n", 2, ("1,0,0", "3 values")),
        (("ik", ARM, "--poses", "-"), '[[1, 0, 0, 0, 0, "up", 1]]', 2, ('"up"',)),
        (("ik", ARM, "--poses", "-"), '{"targets": []}', 2, ("targets", "'poses'")),
        (("ik", ARM, "--poses", "-"), "[[1, 2", 2, ("cannot be read",)),
        (("ik", ARM, "--poses", "-"), b"\x93NUMPY\x01", 2, ("damaged",)),
        (("ik", ARM, "--poses", "-"), b"PK\x03\x04nothing", 2, ("damaged",)),
        (("ik", ARM, "--poses", "-"), b"\xff\xfe\x00", 2, ("neither text nor",)),
        (("ik", ARM, "--poses", "-"), json.dumps([np.eye(4).tolist(), np.diag([1, 1, -1, 1]).tolist()]), 2, ("[1]",)),
        (("ik", "-", "--poses", "-"), "", 2, ("standard input",)),
        (("fk", ARM), None, 2, ("--q", "--file")),
        (("fk", ARM, "--q", TYPED, "--file", "x.csv"), None, 2, ("--q", "--file")),
        (("fk", ARM, "--file", "-"), "1,2\n", 2, ("(1, 2)", "joint_6")),
        (("fk", ARM, "--file", "-"), "[[1, 2, 3, 4, 5, NaN]]", 2, ("nan", "joint_6")),
        (("fk", ARM, "--q", TYPED, "-o", "no/such/folder.json"), None, 2, ("no/such/folder.json",)),
        (("info", "zyyzyz_7r"), None, 2, ("zyyzyz_7r", "zyyzyz_6r")),
        (("info", "no/such.urdf"), None, 3, ("no/such.urdf",)),
        (("info", "-"), "<robot name='x'><link", 3, (":1:", "XML")),
        (("info", ARM, "--tip", "hand"), None, 3, ("hand", "tool0")),
        (("compare", "-", "-"), TWO_JOINTS, 2, ("standard input already",)),
        (("ik", "-"), TWO_JOINTS, 4, ("planar",)),
    ],
)
def test_errors_have_a_status_and_one_readable_message(
    args: tuple[str, ...], given: str | bytes | None, status: int, words: tuple[str, ...]
) -> None:
    """Each kind of error has its status; stderr names what is wrong and what is valid; stdout holds no half answer."""
    result = call(*args, given=given)
    assert result.exit_code == status, result.output
    assert all(word in result.stderr for word in words), result.stderr
    assert sum(line.startswith("Error:") for line in result.stderr.splitlines()) == (status != 1)
    assert result.stdout.count("\n") <= (status == 1)


def test_without_a_solution_the_table_says_why() -> None:
    """Out of reach: status 1, and the answer on stdout holds the explanation with the lengths."""
    result = call("ik", ARM, "--xyz", "9,0,0", "--rpy", "0,0,0")
    assert result.exit_code == 1
    assert "no solution" in result.stdout
    assert " m" in result.stdout.split("no solution")[1]
    said = strict_json(call("ik", ARM, "--xyz", "9,0,0", "--rpy", "0,0,0", "-f", "json").stdout)["poses"][0]
    assert said["count"] == 0
    assert said["explanation"] in " ".join(result.stdout.split())


def test_one_pose_of_a_batch_without_a_solution_is_status_1() -> None:
    """A batch that is solved in part ends with status 1, and its data hold the part that is solved."""
    poses = [target().tolist(), [[1, 0, 0, 9], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]]
    result = call("ik", ARM, "--poses", "-", "-f", "json", given=json.dumps(poses))
    assert result.exit_code == 1
    assert [pose["count"] for pose in strict_json(result.stdout)["poses"]] == [8, 0]
    assert result.stderr.endswith("1 of 2 poses have no solution\n")


def test_check_complete_ends_with_the_reports_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    """With --complete two ways to all solutions are compared; the status is 1 where the report says so."""
    assert strict_json(succeed("check", ARM, "--complete", "-n", "3", "-f", "json"))["second"]
    assert "PASSED: 6 poses" in succeed("check", ARM, "--complete", "-n", "3")
    failed = SimpleNamespace(passed=False, to_json=lambda: '{"passed": false}')
    monkeypatch.setattr(completeness, "compare", lambda *_, **__: failed)
    assert call("check", ARM, "--complete", "-f", "json").exit_code == 1
    assert call("check", ARM, "--complete", "--collision").exit_code == 2


def test_check_ends_with_the_reports_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    """A good arm passes its check with status 0; a report that failed ends with status 1 and is printed, too."""
    assert strict_json(succeed("check", ARM, "-n", "5", "-f", "json"))["passed"] is True
    assert "pass" in succeed("check", ARM, "-n", "5", "--no-collision").lower()
    failed = SimpleNamespace(passed=False, to_json=lambda: '{"passed": false}')
    monkeypatch.setattr(crosscheck, "check", lambda *_, **__: failed)
    result = call("check", ARM, "-f", "json")
    assert result.exit_code == 1
    assert strict_json(result.stdout) == {"passed": False}


# Help


@pytest.mark.parametrize("command", COMMANDS)
def test_examples_in_the_help_work(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every command's help shows examples, unbroken, and each of them ends with status 0."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(catalogue.resolve(ARM).path, "my_arm.urdf")
    Path("vectors.csv").write_text("0,-60,60,0,60,0\n10,-60,60,0,60,0\n")
    examples = [line.strip() for line in succeed(command, "--help").splitlines() if line.startswith("    urdf-ik ")]
    assert len(examples) >= 2
    for example in examples:
        piped: str | None = None
        for part in example.split(" | "):
            words = shlex.split(part)[1:]
            piped = succeed(*words, given=piped)


def test_help_and_version_are_light() -> None:
    """``--version`` prints the version and brings in neither Pinocchio nor yourdfpy nor rich."""
    code = "import sys; from urdf_ik.cli import app; app(['--version'], standalone_mode=False); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    version, modules = done.stdout.splitlines()
    assert version.split()[0] == "urdf-ik"
    assert version.split()[1][0].isdigit()
    assert not {"pinocchio", "coal", "yourdfpy", "rich"} & set(modules.split())


# Solutions and their formats


def test_the_example_shows_all_eight_solutions() -> None:
    """``urdf-ik ik zyyzyz_6r``, the job of ``make run``: eight named branches with limits, collision and error."""
    text = succeed("ik", ARM)
    assert "8 solutions" in text
    for word in ("front", "back", "up", "down", "noflip", "flip", "in limits", "collision", "singular", "error [m]"):
        assert word in text
    data = strict_json(succeed("ik", ARM, "-f", "json"))["poses"][0]
    assert len({one["branch"] for one in data["solutions"]}) == 8
    assert all(one["within_limits"] in (True, False) for one in data["solutions"])


def test_solutions_and_errors_are_pinocchios() -> None:
    """Every solution in the data reaches the pose under Pinocchio, and the error printed is the one it measures."""
    pose = strict_json(succeed("ik", ARM, "--q", TYPED, "-f", "json"))["poses"][0]
    assert np.abs(np.array(pose["pose"]) - target()).max() < 1e-12
    for one in pose["solutions"]:
        error = oracle().error(np.array(one["q"]), target())
        assert error < 1e-9
        assert abs(max(one["error"]["position"], one["error"]["rotation"]) - error) < 1e-14
    assert angle_distance(np.array([one["q"] for one in pose["solutions"]]), np.array(Q)).min() < 1e-9


def test_formats_hold_the_same_solutions() -> None:
    """JSON, CSV and npz of the same poses hold the same joint vectors, branches, flags and errors, to the last bit."""
    args = ("ik", ARM, "--random", "5", "--check")
    data = strict_json(succeed(*args, "-f", "json"))
    flat = [(i, one) for i, pose in enumerate(data["poses"]) for one in pose["solutions"]]
    rows = list(csv.DictReader(io.StringIO(succeed(*args, "-f", "csv"))))
    raw = call(*args, "-f", "npz").stdout_bytes
    with np.load(io.BytesIO(raw), allow_pickle=False) as arrays:
        valid = arrays["valid"]
        assert arrays["poses"].tolist() == [pose["pose"] for pose in data["poses"]]
        assert arrays["q"][valid].tolist() == [one["q"] for _, one in flat]
        assert arrays["branches"][valid].tolist() == [one["branch"] for _, one in flat]
        assert arrays["within_limits"][valid].tolist() == [one["within_limits"] for _, one in flat]
        assert arrays["collision_free"][valid].tolist() == [one["collision_free"] for _, one in flat]
        assert arrays["position_error"][valid].tolist() == [one["error"]["position"] for _, one in flat]
        assert np.isnan(arrays["q"][~valid]).all()
    assert len(rows) == len(flat)
    for row, (i, one) in zip(rows, flat, strict=True):
        assert (int(row["pose"]), row["branch"]) == (i, one["branch"])
        assert [float(row[name]) for name in data["joints"]] == one["q"]
        assert bool(int(row["within_limits"])) == one["within_limits"]
        assert bool(int(row["collision_free"])) == one["collision_free"]
        assert float(row["rotation_error"]) == one["error"]["rotation"]


def test_numpy_reads_the_csv() -> None:
    """The numbers come first in the CSV, so that NumPy reads them without knowing of the quoted branch names."""
    text = succeed("ik", ARM, "--q", TYPED, "-f", "csv")
    numbers = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1, usecols=range(1, 7), quotechar='"')
    assert numbers.tolist() == vectors(succeed("ik", ARM, "--q", TYPED, "-f", "json")).tolist()


@pytest.mark.parametrize("format", ["json", "csv", "npz"])
def test_fk_feeds_ik(format: str) -> None:
    """The output of fk in every data format is input for ``ik --poses -``, which finds the joint vector again."""
    poses = call("fk", ARM, "--q", TYPED, "--q", comma(np.array(Q) / 2), "-f", format).stdout_bytes
    answer = strict_json(succeed("ik", ARM, "--poses", "-", "-f", "json", given=poses))["poses"]
    for k, pose in enumerate(answer):
        found = np.array([one["q"] for one in pose["solutions"]])
        assert angle_distance(found, np.array(Q) / (k + 1)).min() < 1e-9


def _text(rows: Array, separator: str = ",") -> bytes:
    return "\n".join(separator.join(map(repr, row)) for row in rows.tolist()).encode() + b"\n"


def _npy(array: Array) -> bytes:
    out = io.BytesIO()
    np.save(out, array)
    return out.getvalue()


def _npz(**arrays: Array) -> bytes:
    out = io.BytesIO()
    np.savez(out, **arrays)
    return out.getvalue()


POSE_FILES: dict[str, Callable[[Array, Array], bytes]] = {
    "npy (4, 4)": lambda T, _: _npy(T[0]),
    "npy (N, 4, 4)": lambda T, _: _npy(T),
    "npy (N, 16)": lambda T, _: _npy(T.reshape(-1, 16)),
    "npy (N, 7)": lambda _, p: _npy(p),
    "npz poses": lambda T, p: _npz(poses=T, other=p[0]),
    "npz T": lambda T, p: _npz(T=T, other=p[0]),
    "npz the only one": lambda _, p: _npz(anything=p),
    "json (4, 4)": lambda T, _: json.dumps(T[0].tolist()).encode(),
    "json (N, 7)": lambda _, p: json.dumps(p.tolist()).encode(),
    "json object": lambda T, _: json.dumps({"poses": T.tolist()}).encode(),
    "json objects": lambda T, _: json.dumps([{"pose": x} for x in T.tolist()]).encode(),
    "csv 16": lambda T, _: _text(T.reshape(-1, 16)),
    "csv 7": lambda _, p: _text(p),
    "csv 7, header in another order": lambda _, p: (
        b"# made by hand\nqw,qx,qy,qz,x,y,z,name\n"
        + b"\n".join(row + b",tool" for row in _text(p[:, [6, 3, 4, 5, 0, 1, 2]]).split())
    ),
    "semicolons, byte order mark": lambda _, p: b"\xef\xbb\xbf" + _text(p, ";"),
    "blanks": lambda T, _: _text(T.reshape(-1, 16), "  "),
}


@pytest.mark.parametrize("kind", POSE_FILES)
@pytest.mark.parametrize("stdin", [True, False])
def test_poses_are_read_in_every_documented_form(kind: str, stdin: bool, tmp_path: Path) -> None:
    """The same poses, as matrices or with quaternions, in any format, from a file or stdin, are read as the same."""
    poses = oracle().poses(np.array([Q, np.array(Q) / 2, np.zeros(6)]))
    single = "(4, 4)" in kind and "N" not in kind
    quats = np.array([pin.SE3ToXYZQUAT(pin.SE3(pose)) for pose in poses])
    content = POSE_FILES[kind](poses, quats)
    file = tmp_path / "poses.data"
    file.write_bytes(content)
    source = ("-", content) if stdin else (str(file), None)
    text = succeed("ik", ARM, "--no-check", "--poses", source[0], "-f", "json", given=source[1])
    got = np.array([pose["pose"] for pose in strict_json(text)["poses"]])
    assert np.abs(got - (poses[:1] if single else poses)).max() < 1e-12


def test_joint_vectors_are_read_in_every_documented_form(tmp_path: Path) -> None:
    """npy, npz, JSON and CSV, with and without a header, give Pinocchio's poses."""
    q = np.random.default_rng(1).uniform(-1.0, 1.0, (3, 6))
    names = [f"joint_{i}" for i in range(6, 0, -1)]
    contents = [
        _npy(q),
        _npz(q=q, other=q[0]),
        json.dumps(q.tolist()).encode(),
        json.dumps({"q": q.tolist()}).encode(),
        _text(q),
        ",".join(names).encode() + b"\n" + _text(q[:, ::-1]),
    ]
    for content in contents:
        file = tmp_path / "vectors"
        file.write_bytes(content)
        poses = strict_json(succeed("fk", ARM, "--file", str(file), "-f", "json"))["poses"]
        assert np.abs(np.array([pose["pose"] for pose in poses]) - oracle().poses(q)).max() < 1e-12


def test_orientations_in_any_notation_are_the_same_pose() -> None:
    """A pose typed with either quaternion, roll-pitch-yaw or a rotation vector, in rad or degrees, is the same pose."""
    T = target()
    quat = pin.Quaternion(T[:3, :3]).coeffs()
    notations = {
        "--quat-xyzw": quat,
        "--quat-wxyz": quat[[3, 0, 1, 2]],
        "--rpy": pin.rpy.matrixToRpy(T[:3, :3]),
        "--rotvec": pin.log3(T[:3, :3]),
    }
    for option, values in notations.items():
        for degrees in (False, True):
            shown = np.rad2deg(values) if degrees and len(values) == 3 else values
            more = ("--degrees",) if degrees else ()
            text = succeed("ik", ARM, "--xyz", comma(T[:3, 3]), option, comma(shown), "-f", "json", *more)
            assert np.abs(np.array(strict_json(text)["poses"][0]["pose"]) - T).max() < 1e-12, option


def test_degrees_are_the_same_answers() -> None:
    """--degrees turns every angle, in and out, and changes nothing else."""
    radians = strict_json(succeed("ik", ARM, "--q", TYPED, "-f", "json"))
    degrees = strict_json(succeed("ik", ARM, "--q", comma(np.rad2deg(Q)), "--degrees", "-f", "json"))
    assert (radians["units"]["angle"], degrees["units"]["angle"]) == ("rad", "deg")
    for one, other in zip(radians["poses"][0]["solutions"], degrees["poses"][0]["solutions"], strict=True):
        assert one["branch"] == other["branch"]
        assert np.abs(np.deg2rad(other["q"]) - one["q"]).max() < 1e-12
    nearest = succeed("ik", ARM, "--q", TYPED, "--nearest", TYPED, "-f", "csv")
    again = succeed("ik", ARM, "--q", comma(np.rad2deg(Q)), "--nearest", comma(np.rad2deg(Q)), "--degrees", "-f", "csv")
    assert nearest.rpartition(",,")[2] == again.rpartition(",,")[2]
    fk = [succeed("fk", ARM, "--q", TYPED), succeed("fk", ARM, "--q", comma(np.rad2deg(Q)), "--degrees")]
    assert fk[0].splitlines()[:-1] == fk[1].splitlines()[:-1]
    limits = [strict_json(succeed("info", ARM, "-f", "json", *more))["joints"] for more in ((), ("--degrees",))]
    for one, other in zip(*limits, strict=True):
        assert other["upper"] == pytest.approx(np.rad2deg(one["upper"]))


def test_filters_keep_what_they_say() -> None:
    """The limits, collision and nearest filters keep exactly the solutions that the unfiltered data say they should."""
    args = ("ik", ARM, "--random", "20", "--seed", "3", "-f", "json")

    def kept(*more: str) -> list[list[Any]]:
        return [pose["solutions"] for pose in strict_json(call(*args, *more).stdout)["poses"]]

    everything = kept()
    free = kept("--collision-free")
    assert free == [[one for one in pose if one["collision_free"]] for pose in everything]
    assert free != everything
    inside = kept("--within-limits")
    assert inside == [[one for one in pose if one["within_limits"]] for pose in everything]
    assert inside != everything
    nearest = kept("--nearest", TYPED)
    for pose, chosen in zip(everything, nearest, strict=True):
        distance = [np.linalg.norm((np.array(one["q"]) - Q + np.pi) % (2 * np.pi) - np.pi) for one in pose]
        assert chosen == [pose[int(np.argmin(distance))]]


def test_turns_add_images_inside_the_limits() -> None:
    """--turns gives every image inside the limits, of which a UR's joints have two each: as many as counted by hand."""
    args = ("ik", "ur5", "--q", "0.1,-1,1,0.2,0.3,0.4", "--no-check", "-f", "json")
    plain, turned = vectors(succeed(*args)), vectors(succeed(*args, "--turns"))
    limits = strict_json(succeed("info", "ur5", "-f", "json"))["joints"]
    images = plain[..., None] + 2.0 * np.pi * np.arange(-2, 3)
    inside = [(images[:, i] >= one["lower"]) & (images[:, i] <= one["upper"]) for i, one in enumerate(limits)]
    assert len(turned) == np.prod(np.sum(inside, axis=-1), axis=0).sum() > 8 * len(plain)
    assert len(np.unique(turned.round(6), axis=0)) == len(turned)
    assert all(angle_distance(plain, q).min() < 1e-9 for q in turned)


def test_random_poses_follow_the_seed() -> None:
    """The same seed gives the same output, another seed another."""
    outputs = [succeed("ik", ARM, "--random", "3", "--seed", seed, "-f", "csv") for seed in ("1", "1", "2")]
    assert outputs[0] == outputs[1] != outputs[2]


def test_no_check_leaves_pinocchio_out() -> None:
    """With --no-check neither Pinocchio nor coal is brought in, and neither errors nor collisions are claimed."""
    code = "import sys; from urdf_ik.cli import app; app(sys.argv[1:], standalone_mode=False); print(*sys.modules)"
    command = [sys.executable, "-c", code, "ik", ARM, "--no-check", "-f", "csv"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    header, *_, modules = done.stdout.splitlines()
    assert not {"pinocchio", "coal"} & set(modules.split())
    assert "error" not in header
    assert "collision" not in header


def test_urdf_from_standard_input() -> None:
    """``-`` reads the URDF from stdin, with the same result as its file."""
    path = catalogue.resolve(ARM).path
    piped = strict_json(succeed("info", "-", "-f", "json", given=path.read_bytes()))
    named = strict_json(succeed("info", str(path), "-f", "json"))
    assert {**piped, "source": ""} == {**named, "source": ""}


def test_arm_without_collision_shapes_is_solved_and_says_so() -> None:
    """Where there is nothing to check for collision, solutions come all the same, and none is called free."""
    text = succeed("ik", "-", "--base", "base", "--tip", "tool", given=industrial().urdf)
    assert "self-collision was not checked" in text
    assert "free" not in text
    assert "error [m]" in text


# Output


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


@pytest.mark.parametrize("width", [80, 120])
@pytest.mark.parametrize(
    "args", [("info", ARM), ("info", "ur5"), ("ik", ARM), ("ik", "ur5"), ("fk", ARM, "--q", TYPED)]
)
def test_tables_fit_the_width_in_plain_text(width: int, args: tuple[str, ...]) -> None:
    """Where nobody watches, tables are ASCII without colour, and fit the width without cutting anything off."""
    text = succeed(*args, COLUMNS=str(width))
    assert text.isascii()
    assert "\x1b" not in text
    paths = [line for line in text.splitlines() if os.sep in line]
    assert all(len(line) <= width for line in text.splitlines() if line not in paths)
    assert text.endswith("\n")


def test_info_tells_the_structure() -> None:
    """The bundled arm's axes z y y z y z, its parallel pair, its wrist and its eight branches, in table and JSON."""
    data = strict_json(succeed("info", ARM, "-f", "json"))
    assert [np.round(joint["axis"]).astype(int).tolist().index(1) for joint in data["joints"]] == [2, 1, 1, 2, 1, 2]
    assert [pair["relation"] for pair in data["structure"]["pairs"]].count("parallel") == 1
    assert {"axes": [4, 5, 6], "relation": "meet"}.items() <= data["structure"]["triples"][0].items()
    assert data["solver"]["max_solutions"] == len(data["solver"]["branches"]) == 8
    text = succeed("info", ARM)
    for word in (*(joint["name"] for joint in data["joints"]), data["solver"]["family"], *data["solver"]["branches"]):
        assert word in text


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
        format = "table" if suffix == "txt" else suffix
        assert succeed("ik", ARM, "--q", TYPED, "-o", str(file)) == ""
        if suffix == "npz":
            with np.load(file, allow_pickle=False) as arrays:
                assert arrays["q"].shape == (1, 8, 6)
        else:
            assert file.read_text() == succeed("ik", ARM, "--q", TYPED, "-f", format)


def test_binary_data_do_not_go_to_a_terminal() -> None:
    """An npz needs --output or a redirection; a format that was asked for wins over the file's ending."""
    with pytest.raises(typer.BadParameter, match="--output"):
        format_for(Format.NPZ, None, terminal=True)
    assert format_for(Format.NPZ, None, terminal=False) is Format.NPZ
    assert format_for(Format.JSON, Path("x.csv"), terminal=True) is Format.JSON


@pytest.mark.skipif(os.name == "nt", reason="a pseudo-terminal is a thing of POSIX")
def test_colour_only_on_a_terminal_that_wants_it() -> None:
    """On a terminal the table has colour; NO_COLOR takes it away."""
    import pty

    shown = {}
    for no_colour in ("", "1"):
        theirs, ours = pty.openpty()
        env = {key: value for key, value in os.environ.items() if key not in ("NO_COLOR", "FORCE_COLOR")}
        env |= {"TERM": "xterm", **({"NO_COLOR": "1"} if no_colour else {})}
        command = [sys.executable, "-c", "from urdf_ik.cli import main; main()", "ik", ARM, "--no-check"]
        child = subprocess.Popen(command, stdout=ours, stderr=subprocess.DEVNULL, env=env)
        os.close(ours)
        parts = []
        while True:
            try:
                part = os.read(theirs, 65536)
            except OSError:  # Linux's word for the end of a terminal
                part = b""
            if not part:
                break
            parts.append(part)
        os.close(theirs)
        assert child.wait(timeout=60) == 0
        shown[no_colour] = b"".join(parts)
    assert b"\x1b[" in shown[""]
    assert b"\x1b[" not in shown["1"]
    assert b"8 solutions" in shown["1"]


@pytest.mark.skipif(os.name == "nt", reason="signals and pipes of POSIX")
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


@pytest.mark.skipif(os.name == "nt", reason="signals and pipes of POSIX")
def test_a_full_disk_is_one_message() -> None:
    """Standard output that cannot be written: status 2 and one line, no second complaint at exit."""
    if not os.path.exists("/dev/full"):
        pytest.skip("this system has no /dev/full")
    command = [sys.executable, "-c", "from urdf_ik.cli import main; main()", "info", ARM]
    with open("/dev/full", "wb") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert len([line for line in done.stderr.splitlines() if "rror" in line or "xception" in line]) == 1


@pytest.mark.skipif(os.name == "nt", reason="signals and pipes of POSIX")
def test_ctrl_c_ends_it_with_130() -> None:
    """An interrupt in the midst of work: status 130 and no traceback."""
    # Tests that run in the background of a script are told to ignore Ctrl-C, and so are their children.
    child = start(
        *("ik", ARM, "--random", "20000", "--check", "-f", "csv"),
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    time.sleep(0.1)
    while child.poll() is None and not _loaded(child.pid):
        time.sleep(0.05)
    time.sleep(0.5)
    child.send_signal(signal.SIGINT)
    _, complaint = child.communicate(timeout=60)
    assert child.returncode == 130
    assert b"Traceback" not in complaint


def _loaded(pid: int) -> bool:
    """Whether the program has come as far as Pinocchio, where its long work begins."""
    maps = Path(f"/proc/{pid}/maps")
    return not maps.exists() or "pinocchio" in maps.read_text()
