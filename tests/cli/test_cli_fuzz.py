"""Hostile arguments and files for every command: the answer, or an error in words, with a known status.

The seed and the number of calls are those of URDF_IK_CALLS, 'seed:count'; by default a few hundred, which take some
forty seconds.
"""

from __future__ import annotations

import itertools
import json
import os
import re
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import ARM, TYPED, Q, comma
from typer.testing import CliRunner

import urdf_ik
from urdf_ik.cli import app
from urdf_ik.maps import workspaces
from urdf_ik.model import catalogue
from urdf_ik.show import viewer

SEED, COUNT = map(int, os.environ.get("URDF_IK_CALLS", "3:480").split(":"))
PARTS, MOST_SECONDS = 8, 120
WRITING = ("-o", "--output", "--timed", "--store")
STATUS = {0, 1, 2, 3, 4}
SEVEN = "0.3,0.5,-0.4,0.9,0.2,-0.6,0.1"
# Calls that succeed, or nearly: names in braces are files.
TEXT = """
info ARM --degrees
explain ARM --q TYPED --degrees
explain ARM --poses {poses_csv} --json
explain planar_2r --task planar-position --xyz 0.1,0.05,0
info {arm} --chains -f json
info {arm} --srdf {srdf}
info - --tip tool0
info ARM --lock joint_1=30deg --tool-xyz 0,0,0.1 --tool-rpy 0,0.1,0
info {xacro} --xacro-arg length:=0.4
fk ARM --q TYPED --degrees
fk ARM --q {vectors_json} -f json
fk ARM --q - -f csv
fk ARM --q {vectors_csv} -o {out}.csv
fk {arm} --q TYPED -o {out}.npz
ik ARM --q TYPED --within-limits --turns --degrees
ik ARM --poses {poses_csv} --no-check -o {out}.json
ik ARM --poses {poses_json} --no-check -f json
ik ARM --poses {poses_npy} --no-check -f csv
ik ARM --poses {poses_npz} --no-check -o {out}.npz
ik ARM --poses - --no-check -f json
ik ARM --xyz 0.5,0.1,0.3 --rpy 0,0.1,0.2 --no-check
ik ARM --xyz 0.5 0.1 0.3 --rpy 0 0.1 0.2 --no-check
ik ARM --random 3 --seed 2 --no-check -f json
ik ARM --xyz 0.5,0.1,0.3 --quat-xyzw 0,0,0,1 --no-check
ik ARM --xyz 0.4,0.1,0.3 --rotvec 0,0.1,0.2 --no-check
ik ARM --q TYPED --nearest 0,0,0,0,0,0 --metric time --max-step 3 --no-check -f json
ik ARM --q TYPED --free-axis z --free-at 0,0,0.1 --redundancy 0,0.4 --no-check
ik srs_7r --q SEVEN --redundancy 0.1,0.3 --no-check --best limits
ik ARM --q TYPED --best manipulability
check planar_2r -n 3 --seed 4 -f json
check planar_2r -n 2 --complete
compare planar_2r {arm} -n 2 --tip B=tool0
compare {arm} {arm} -n 2 --lock joint_1=0 --tool-xyz B=0,0,0.1 -f json
dh puma_560 --convention modified --degrees
dh {table_csv} -o {out}.urdf
dh {table_json} --snap 1e-6 -f csv
dh {arm} -o {out}.csv --snap 0.001
workspace planar_2r --degrees
workspace planar_2r --voxel 0.2 --orientations 4 -o {out}.npz
workspace planar_2r --voxel 0.2 --orientations 2 --bounds -1,-1,-1,1,1,1 --values manipulability,margin --json
workspace planar_2r --voxel 0.2 --orientations 2 --store {out}.zarr
path ARM --poses {seam} --no-collisions --output {out}.csv
path ARM -p {seam} --world {world} --margin 0.01 --cost max --limit-cost 0.1 --reconfigure -f json
path ARM -p - --no-collisions --max-step 1 --tolerance 0.01,0.1 --start TYPED --timed {out}.json
plot planar_2r limits --q 0.5,-1 -o {out}.png
plot planar_2r workspace --q 0.5,-1 -o {out}.svg
plot planar_2r workspace --map {map} --axis z --at 0 --show solutions -o {out}.png
robots puma -f json
view planar_2r -o {out}.html
view {arm} --host localhost --port 0 --poses {seam} --no-collisions -o {out}.html
--version
ik --help
"""
CALLS = [line.replace("ARM", ARM).replace("TYPED", TYPED).replace("SEVEN", SEVEN) for line in TEXT.split("\n") if line]
NUMBERS = (
    "0", "-0", "-1", "1e-300", "5e-324", "-1e-17", "1e155", "-1e155", "1e200", "1e308", "1e309", "nan", "-inf", "1_0",
    "0x10", "1000000000000000000", "9" * 400, "-" + "9" * 5000, "1" * 5000, "١٢", "1,5", "1e", "--", "", " ",
)  # fmt: skip
WORDS = (
    "x", "A" * 300, "B" * 5000, "\x1b[31mred", "\x9b31m", "tool\u202e0", "a\0b", "\udcff\udc80", "a\nb\rc", "=",
    "joint_1=", "=1", "joint_1=1e308", "joint_1=nan", "{", "[0]", "%s%n", "../../etc/passwd", "~", "-", "--", "-o",
    "--q", "file:///etc/passwd", "日本", "name:=${1/0}", "<robot/>", "tcp://[::1", "x" * 64 + ".example", "*", "$(id)",
    "[red]bold[/red]",
)  # fmt: skip
OPTIONS = (
    "--base", "--tip", "--chain", "--srdf", "--mesh-root", "--degrees", "--lock", "--tool-xyz", "--tool-rpy",
    "--redundancy-joint", "--free-axis", "--free-at", "--output", "--format", "--seed", "--q", "--task", "--xyz",
    "--quat-xyzw", "--quat-wxyz", "--rpy", "--rotvec", "--poses", "--random", "--redundancy", "--turns",
    "--within-limits", "--collision-free", "--nearest", "--metric", "--values", "--best", "--voxel",
    "--orientations", "--bounds", "--threads", "--store", "--json", "--world", "--start", "--end", "--margin",
    "--cost", "--limit-cost", "--max-step", "--tolerance", "--timed", "--map", "--axis", "--at", "--snap",
    "--convention", "--host", "--port", "--xacro-arg", "--scheduler", "--help", "--version", "--nonsense",
)  # fmt: skip
# What a terminal takes for an order, or a reader for the end of a line.
ORDERS = re.compile(r"[\x00-\x09\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
MOST_OF_A_NAME, MOST_OF_A_PATH = 80, 200


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The files of ``CALLS``, each of them sound."""
    folder = tmp_path_factory.mktemp("good")
    arm = urdf_ik.load(ARM)
    q = np.array([Q, np.array(Q) / 2])
    poses = arm.fk(q)
    seam = urdf_ik.line(poses[0], poses[0] @ urdf_ik.pose([0.02, 0, 0]), 4)
    files: dict[str, str | bytes] = {
        "arm.urdf": catalogue.resolve("puma_560").path.read_bytes(),
        "robot.xacro": '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:arg name="length" default="1"/>'
        '<link name="a"/><link name="b"/><joint name="j" type="continuous"><parent link="a"/><child link="b"/>'
        '<origin xyz="0 0 $(arg length)"/></joint></robot>',
        "arm.srdf": '<robot name="puma_560"><group name="arm"><chain base_link="base_link" tip_link="tool0"/></group>'
        "</robot>",
        "world.urdf": '<robot name="cell"><link name="box"><collision><origin xyz="9 0 0"/><geometry>'
        '<box size="1 1 1"/></geometry></collision></link></robot>',
        "vectors.json": json.dumps({"q": q.tolist()}),
        "vectors.csv": "\n".join(map(comma, q)),
        "poses.csv": "\n".join(comma(T.ravel()) for T in poses),
        "poses.json": json.dumps(poses.tolist()),
        "seam.json": json.dumps(seam.tolist()),
    }
    for name, content in files.items():
        (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    np.save(folder / "poses.npy", poses)
    np.savez(folder / "poses.npz", poses=poses, other=q)
    table = urdf_ik.DHTable.from_chain(urdf_ik.load("puma_560").chain, "standard")
    (folder / "table.csv").write_text(table.to_csv())
    (folder / "table.json").write_text(table.to_json())
    workspaces.workspace(urdf_ik.load("planar_2r"), voxel=0.2, orientations=2).save(folder / "map.npz")
    named = {"arm": "arm.urdf", "xacro": "robot.xacro", "srdf": "arm.srdf", "world": "world.urdf", "map": "map.npz"}
    named |= {"seam": "seam.json", "vectors_json": "vectors.json", "vectors_csv": "vectors.csv"}
    named |= {f"poses_{kind}": f"poses.{kind}" for kind in ("csv", "json", "npy", "npz")}
    named |= {f"table_{kind}": f"table.{kind}" for kind in ("csv", "json")}
    return {name: folder / file for name, file in named.items()}


def odd_places(folder: Path) -> list[str]:
    """What is given as a file and is none, or holds nothing of use."""
    (folder / "folder").mkdir()
    (folder / "loop").symlink_to("loop")
    (folder / "empty").touch()
    (folder / "wide.csv").write_text("9" * 200_000 + ",1\n1,2\n")
    (folder / "deep.json").write_text("[" * 100_000)
    (folder / "nul").write_bytes(bytes(5000))
    names = ["folder", "loop", "loop/x.csv", "empty", "empty/x.csv", "missing/x.csv", "wide.csv", "deep.json", "nul"]
    names += ["n" * 300]
    if hasattr(os, "mkfifo"):
        os.mkfifo(folder / "pipe")
        names += ["pipe"]
    return [str(folder / name) for name in names] + ["/dev/null", "/dev/full", "/", "\0", "", "-", "a" * 5000]


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """Cut off, or with bytes or numbers changed, doubled or missing."""
    for _ in range(int(rng.integers(1, 4))):
        place, length = int(rng.integers(max(len(data), 1))), int(rng.integers(1, 40))
        kind = int(rng.integers(6))
        if kind == 0:
            data = data[:place]
        elif kind == 1:
            data = data[:place] + bytes([int(rng.integers(256))]) + data[place + 1 :]
        elif kind == 2:
            data = data[:place] + data[place + length :]
        elif kind == 3:
            data = data[:place] + data[place : place + length] * 3 + data[place + length :]
        elif kind == 4:
            word = (*NUMBERS, *WORDS)[int(rng.integers(len(NUMBERS) + len(WORDS)))]
            data = data[:place] + word.encode(errors="surrogateescape") + data[place:]
        elif found := list(re.finditer(rb"\d+(?:\.\d+)?", data[:100_000])):
            one = found[int(rng.integers(len(found)))]
            data = data[: one.start()] + NUMBERS[int(rng.integers(len(NUMBERS)))].encode() + data[one.end() :]
    return data


class Drawn:
    """One call: arguments, standard input, and the files that it may write."""

    def __init__(self, good: dict[str, Path], folder: Path, rng: np.random.Generator) -> None:
        self.folder, self._rng = folder, rng
        odd = odd_places(folder)
        (folder / "out").mkdir()
        parts = str(self._one(CALLS)).split(" ")
        changes = int(self._one([0, 0, 0, 1, 1, 1, 1, 2, 2, 3]))
        files = [k for k, part in enumerate(parts) if part.startswith("{") and not part.startswith("{out}")]
        for k in files:
            path = good[parts[k][1:-1]]
            parts[k] = str(path)
            chance = rng.random()
            if chance < 0.5:
                worse = folder / path.name
                worse.write_bytes(damaged(path.read_bytes(), rng))
                parts[k] = str(worse)
            elif chance < 0.6:
                parts[k] = str(self._one(odd))
        changes += not files and not changes
        parts = [part.replace("{out}", str(folder / "out" / "written")) for part in parts]
        for _ in range(changes):
            self._change(parts, odd)
        self.args = parts
        source = good[str(self._one(["arm", "poses_csv", "poses_npy", "vectors_json", "seam"]))].read_bytes()
        self.given = damaged(source, rng) if rng.random() < 0.7 else source

    def _one(self, choices: Any) -> Any:
        return choices[int(self._rng.integers(len(choices)))]

    def _value(self, old: str) -> str:
        chance = self._rng.random()
        if "," in old and chance < 0.6:
            values = old.split(",")
            values[int(self._rng.integers(len(values)))] = self._one(NUMBERS)
            return ",".join(values)
        return str(self._one(NUMBERS if chance < 0.6 else WORDS))

    def _change(self, parts: list[str], odd: list[str]) -> None:
        place, kind = int(self._rng.integers(len(parts))), int(self._rng.integers(10))
        values = [k for k, part in enumerate(parts) if k > 1 and not part.startswith("-")]
        if kind < 5 and values:
            place = int(self._one(values))
            parts[place] = self._value(parts[place])
        elif kind == 5:
            parts[place] = str(self._one(WORDS))
        elif kind == 6:
            del parts[place]
            parts += [] if parts else [""]
        elif kind == 7 and values:
            parts[int(self._one(values))] = str(self._one(odd))
        else:
            option = str(self._one(OPTIONS))
            parts += [option, str(self._one(odd)) if self._rng.random() < 0.2 else self._value("")]


def judge(drawn: Drawn) -> int:
    """Run it; the status, after what must hold has been looked at."""
    named = {Path(value).name for option, value in itertools.pairwise(drawn.args) if option in WRITING}
    before = {name: _state(drawn.folder / name) for name in os.listdir(drawn.folder) if name not in {"out", *named}}
    env = {"COLUMNS": "100", "MPLBACKEND": "agg"}
    result = CliRunner().invoke(app, drawn.args, input=drawn.given, env=env)
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code in STATUS
    assert "Traceback" not in result.output
    shown = result.stderr if result.stdout_bytes.startswith(b"PK") else result.output
    assert not ORDERS.search(shown), ORDERS.findall(shown)
    for filler, most in (("A", MOST_OF_A_PATH), ("B", MOST_OF_A_PATH), ("9", MOST_OF_A_NAME), ("1", MOST_OF_A_NAME)):
        assert filler * (most + 1) not in result.stderr
    if result.exit_code:
        assert result.stderr or result.stdout
    for name, state in before.items():
        assert _state(drawn.folder / name) == state, f"{name} was changed"
    for file in (drawn.folder / "out").iterdir():
        assert result.exit_code in (0, 1), f"{file.name} was written"
        assert file.is_dir() or _whole(file), f"{file.name} is not whole"
    return result.exit_code


def _state(path: Path) -> Any:
    if path.is_file():
        return path.read_bytes()
    return sorted(os.listdir(path)) if path.is_dir() else None


def _whole(file: Path) -> bool:
    data = file.read_bytes()
    if file.suffix == ".npz":
        with np.load(file, allow_pickle=False) as arrays:
            return len([arrays[name] for name in arrays.files]) > 0
    if file.suffix == ".json":
        json.loads(data)
    ends = {".urdf": b"</robot>", ".svg": b"</svg>", ".html": b"</html>", ".png": b"IEND\xaeB`\x82"}
    return data.rstrip().endswith(ends.get(file.suffix, b""))


@pytest.fixture
def in_time() -> Iterator[None]:
    """A call that hangs is ended, and named."""

    def late(*_: Any) -> None:
        raise AssertionError(f"still at work after {MOST_SECONDS} s")

    before = signal.signal(signal.SIGALRM, late)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.mark.skipif(os.name == "nt", reason="named pipes and alarms are things of POSIX")
@pytest.mark.parametrize("part", range(PARTS))
def test_hostile_calls_end_in_words(
    part: int, good: dict[str, Path], in_time: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A known status, no traceback, no order to the terminal, no long quote, no file half written, no file changed."""
    monkeypatch.setattr(viewer.Viewer, "wait", lambda self: None)
    monkeypatch.delenv("DISPLAY", raising=False)
    seen = set()
    for k in range(max(COUNT // PARTS, 1)):
        folder = tmp_path / str(k)
        folder.mkdir()
        monkeypatch.chdir(folder)
        drawn = Drawn(good, folder, np.random.default_rng((SEED, part, k)))
        signal.alarm(MOST_SECONDS)
        try:
            seen.add(judge(drawn))
        except Exception as error:
            raise AssertionError(f"call {k} of part {part}, seed {SEED}: {drawn.args!r:.2000}") from error
    assert {0, 2} <= seen
