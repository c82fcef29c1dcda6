"""A baseline: what an arm answers today holds for its rewritten URDF, and for no changed one."""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import call, succeed
from urdf_mutants import mutants, rewritten

import urdf_ik
from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError, PoseError
from urdf_ik.model import catalogue
from urdf_ik.verify.baselines import SIZE, Lock
from urdf_ik.verify.description import described
from urdf_ik.verify.differences import differences

ARM = "zyyzyz_6r"
TEXT = catalogue.resolve(ARM).path.read_text()


def again(arm: Arm, xml: bytes) -> Arm:
    """A changed URDF of the arm, its meshes where they were."""
    return urdf_ik.load(xml.decode(), base=arm.base, tip=arm.tip, mesh_roots=arm.model.package_dirs)


def hold(arm: Arm) -> None:
    """Every mutant is found, its joint named, by the lock among the first; rewritings pass. So says ``compare``."""
    lock = Lock.from_text(urdf_ik.freeze(arm, collisions=False).to_text())
    assert lock.verify(arm).passed
    for mutant in mutants(arm):
        changed = again(arm, mutant.xml)
        found = lock.verify(changed)
        assert not found.passed, mutant.what
        for listed in (found.differences[:3], differences(described(arm), described(changed))):
            named = " ".join(each.name for each in listed)
            assert any(name in named for name in mutant.names), f"{mutant.what}: {found}"
        limits = (any(each.kind == "limits" for each in listed) for listed in (found.differences, listed))
        assert len({*limits}) == 1, f"{mutant.what}: {found}"
    for same in rewritten(arm):
        other = again(arm, same.xml)
        found = lock.verify(other)
        assert found.passed, f"{same.what}: {found}"
        assert not differences(described(arm), described(other)), same.what


@pytest.mark.parametrize("name", [ARM, "ur5", "scara_rrpr"])
def test_every_small_change_is_found_and_named(name: str) -> None:
    """An axis, an order, an origin, a limit, the tip, a name, mimicry, a mesh; rewritings are no change."""
    hold(urdf_ik.load(name))


def test_a_lock_file_reads_back_and_diffs_well(tmp_path: Path) -> None:
    """Equal after reading, at most 200 kB, sorted keys, one pose a line, the same text every time."""
    lock = urdf_ik.freeze(urdf_ik.load(ARM))
    lock.save(tmp_path / "arm.lock.json")
    text = (tmp_path / "arm.lock.json").read_text()
    assert Lock.load(tmp_path / "arm.lock.json") == lock
    assert len(text) <= SIZE
    assert text == urdf_ik.freeze(urdf_ik.load(ARM)).to_text()
    data = json.loads(text)
    assert list(data) == sorted(data)
    lines = text.splitlines()
    start = lines.index(' "poses": [') + 1
    assert [json.loads(line.strip().rstrip(",")) for line in lines[start : start + len(lock.poses)]] == data["poses"]


def test_a_lock_file_follows_its_schema() -> None:
    """The schema in the docs describes what is written."""
    jsonschema = pytest.importorskip("jsonschema")
    schema = json.loads(Path(__file__).parents[2].joinpath("docs/_static/arm-lock.schema.json").read_text())
    for name in (ARM, "srs_7r", "planar_2r"):
        jsonschema.validate(json.loads(urdf_ik.freeze(urdf_ik.load(name)).to_text()), schema)


@pytest.mark.parametrize("isa", ["v2", "v3"])
def test_another_instruction_set_has_the_same_answers(isa: str, tmp_path: Path) -> None:
    """A lock file of this process holds in one that is forced to another instruction set."""
    names = (ARM, "srs_7r", "stanford_rrprrr", "positioning_3r")
    for name in names:
        urdf_ik.freeze(urdf_ik.load(name)).save(tmp_path / f"{name}.lock.json")
    code = (
        "import sys, urdf_ik\nfrom urdf_ik.verify.baselines import Lock\n"
        "for name in sys.argv[1:]:\n"
        "    found = Lock.load(f'{name}.lock.json').verify(urdf_ik.load(name))\n"
        "    assert found.passed, found"
    )
    environment = {**os.environ, "URDF_IK_ISA": isa}
    done = subprocess.run(
        [sys.executable, "-c", code, *names], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    if "URDF_IK_ISA" in done.stderr:
        pytest.skip(f"this processor, or this build, has no {isa}")
    assert not done.returncode, done.stderr


def test_poses_of_the_user_are_kept_and_tolerances_and_ignored_kinds_count() -> None:
    """A tool 0.05 mm longer passes with 0.1 mm; a limit passes where limits are ignored, and nothing else does."""
    arm = urdf_ik.load(ARM)
    T = arm.fk(np.array([[0.3, -0.5, 0.8, 0.4, 0.7, -0.2]]))
    lock = urdf_ik.freeze(arm, T)
    assert [pose.kind for pose in lock.poses][-1] == "own"
    assert np.array_equal(lock.poses[-1].matrix, T[0])
    assert len(lock.poses[-1].answers) == 8
    longer = urdf_ik.load(arm.with_tool(urdf_ik.pose([0.0, 0.0, 5e-5])).model.xml.decode(), tip="tool")
    found = lock.verify(longer, tolerance_mm=0.1, ignore="names")
    assert found.passed, found
    assert [each.name for each in found.ignored] == ["tool"]
    assert not lock.verify(longer, tolerance_mm=0.01, ignore=["names"]).passed
    cut = urdf_ik.load(TEXT.replace('upper="2.6"', 'upper="2.5"', 1))
    assert not lock.verify(cut).passed
    assert lock.verify(cut, ignore="limits,collisions").passed
    with pytest.raises(ArgumentError, match="limits, names, collisions, visuals"):
        lock.verify(arm, ignore="axes")
    with pytest.raises(PoseError):
        urdf_ik.freeze(arm, np.zeros((4, 4)))


def test_a_solver_that_loses_gains_renames_or_reorders() -> None:
    """Sets are compared: a lost or gained solution is found with its pose, another order or name is none."""
    arm = urdf_ik.load(ARM)
    lock = urdf_ik.freeze(arm, collisions=False)
    first = lock.poses[0]
    changed = {
        "lost": first.answers[1:],
        "gained": (*first.answers, first.answers[0].__class__((0.1,) * 6, "odd", True, False, None)),
        "": tuple(answer.__class__(answer.q, "x", *_rest(answer)) for answer in reversed(first.answers)),
    }
    for words, answers in changed.items():
        held = Lock(lock.arm, lock.planted, (first.__class__(first.kind, first.T, (), answers), *lock.poses[1:]))
        found = held.verify(arm)
        # What the lock has too much was lost since, and the other way round.
        expected = {"lost": "gained", "gained": "lost", "": ""}[words]
        assert found.passed == (not words)
        assert not words or (str(found.differences[0]).startswith(expected) and "pose 0" in str(found.differences[0]))


def _rest(answer: object) -> tuple[object, ...]:
    return answer.within_limits, answer.singular, answer.contact  # type: ignore[attr-defined]


def test_pairs_that_an_srdf_allows_to_touch_are_kept(tmp_path: Path) -> None:
    """A lock frozen with an SRDF verifies with it, also from its file; without it, or with more, it does not."""
    first, second = sorted(urdf_ik.load("zyyzyz_6r").model.links)[:2]
    srdf = f'<robot name="any"><disable_collisions link1="{second}" link2="{first}" reason="Never"/></robot>'.encode()
    lock = urdf_ik.freeze(urdf_ik.load("zyyzyz_6r", srdf=srdf), collisions=False)
    lock.save(tmp_path / "arm.lock.json")
    lock = Lock.load(tmp_path / "arm.lock.json")
    assert lock.arm.allowed == ((first, second),)
    assert lock.verify(urdf_ik.load("zyyzyz_6r", srdf=srdf)).passed
    lost = lock.verify(urdf_ik.load("zyyzyz_6r"))
    assert [(each.kind, each.name) for each in lost.differences] == [("collisions", first)]
    assert "may no longer touch" in str(lost.differences[0])
    assert lock.verify(urdf_ik.load("zyyzyz_6r"), ignore="collisions").passed
    more = urdf_ik.freeze(urdf_ik.load("zyyzyz_6r"), collisions=False).verify(urdf_ik.load("zyyzyz_6r", srdf=srdf))
    assert "may touch now" in str(more.differences[0])


def test_a_robot_whose_repository_moved_is_said_with_both_commits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The lock keeps repository, commit, file and hash of a downloaded robot; verify says the old ones and the new."""
    address, commits = "https://example.org/arms.git", []
    monkeypatch.setenv("ROBOT_DESCRIPTIONS_CACHE", str(tmp_path))
    pytest.importorskip("robot_descriptions")
    file = tmp_path / "arms" / "urdf" / "ur5.urdf"
    file.parent.mkdir(parents=True)

    def git(*words: str) -> str:
        command = ["git", "-c", "user.name=A", "-c", "user.email=a@b.c", *words]
        return subprocess.check_output(command, cwd=tmp_path / "arms", text=True).strip()

    git("init", "-q")
    git("remote", "add", "origin", address)
    text = catalogue.resolve(ARM).path.read_text()
    locks = []
    for content in (text, text.replace('xyz="0 0 1"', 'xyz="0 0 1.25"', 1)):
        file.write_text(content)
        git("add", ".")
        git("commit", "-q", "-m", "an arm")
        commits.append(git("rev-parse", "HEAD"))
        locks.append(urdf_ik.freeze(urdf_ik.load(file)))
        assert locks[-1].origin is not None
        assert (locks[-1].origin.repository, locks[-1].origin.commit) == (address, commits[-1])
        assert locks[-1].origin.sha256 == hashlib.sha256(content.encode()).hexdigest()
    lock = Lock.from_text(locks[0].to_text())
    assert lock == locks[0]
    found = lock.verify(urdf_ik.load(file))
    (note,) = (note for note in found.notes if "the file was" in note)
    assert all(f"urdf/ur5.urdf of {address} at commit {commit[:12]}" in note for commit in commits), note
    assert not any("the file was" in note for note in locks[1].verify(urdf_ik.load(file)).notes)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("", "no lock"),
        ("[]", "no lock"),
        ("[" * 100_000, "no lock"),
        ('{"format": "urdf-ik lock", "version": 99}', "version 99"),
        ('{"format": "urdf-ik lock", "version": 1}', "damaged"),
    ],
)
def test_what_is_no_lock_file_is_refused(text: str, match: str) -> None:
    """Whatever the text is."""
    with pytest.raises(ArgumentError, match=match):
        Lock.from_text(text)


def test_a_damaged_lock_file_is_refused() -> None:
    """An entry that is taken away is missed when the file is read."""
    data = json.loads(urdf_ik.freeze(urdf_ik.load("planar_2r")).to_text())
    for place, key in (
        (data, "poses"),
        (data["arm"], "limits"),
        (data["poses"][0], "T"),
        (data["arm"]["steps"][0], "axis"),
    ):
        kept = place.pop(key)
        with pytest.raises(ArgumentError, match="damaged"):
            Lock.from_text(json.dumps(data))
        place[key] = kept
    assert Lock.from_text(json.dumps(data)).arm.robot == "planar_2r"


def test_the_commands_freeze_verify_and_update(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Status 0 and 1; base and tip come from the lock; --update rewrites it; a tip that is gone is a failure."""
    monkeypatch.chdir(tmp_path)
    Path("arm.urdf").write_text(TEXT)
    Path("bad.urdf").write_text(TEXT.replace('<axis xyz="0 1 0"/>', '<axis xyz="0 -1 0"/>', 1))
    Path("gone.urdf").write_text(TEXT.replace('"tool0"', '"flange"'))

    succeed("freeze", "arm.urdf", "arm.lock.json")
    again = call("freeze", "arm.urdf")
    assert again.exit_code == 2 and "arm.lock.json is there already" in again.stderr
    bad = call("verify", "bad.urdf", "arm.lock.json")
    assert bad.exit_code == 1 and "joint_2: its axis is negated" in bad.stdout
    lines = [line[10:] for line in bad.stdout.splitlines() if line.startswith("  replay: ")]
    names: dict[str, Any] = {}
    exec("\n".join(lines), names)
    now, then = (eval(part.split(",")[0], names) for part in lines[2].split("  # the lock has "))
    assert len(lines) > 3 and np.abs(now[:3].ravel() - then).max() > 0.1
    gone = call("verify", "gone.urdf", "arm.lock.json")
    assert gone.exit_code == 1 and "FAILED" in gone.stdout and "tool0" in gone.stdout
    assert call("verify", "arm.urdf", "arm.lock.json", "--ignore", "axes").exit_code == 2
    assert "negated" in succeed("verify", "bad.urdf", "arm.lock.json", "--update")
    succeed("verify", "bad.urdf", "arm.lock.json")


LOCKS = Path(__file__).parent.parent / "goldens" / "locks"


@pytest.mark.parametrize("path", sorted(LOCKS.glob("*.lock.json")), ids=lambda path: path.name.partition(".")[0])
def test_an_old_lock_verifies_and_is_written_the_same(path: Path) -> None:
    """Every pose has the solutions of then, and the lock is written as the same text.

    `urdf-ik freeze` of commit 889e87b wrote them, of every kind of family, some with the URDF beside.
    """
    name = path.name.removesuffix(".lock.json")
    urdf = path.with_name(f"{name}.urdf")
    lock = Lock.load(path)
    found = lock.verify(urdf_ik.load(urdf if urdf.is_file() else name))
    assert found.passed and found.poses == len(lock.poses), found
    assert all(note.startswith("contacts were not checked: no collision shapes") for note in found.notes), found
    assert lock.to_text() == path.read_text()
