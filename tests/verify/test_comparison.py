"""Two arms compared: what must be zero is zero, and a change of known size is found at its size."""

import json
import math
import re
from pathlib import Path
from xml.etree import ElementTree

import chains
import numpy as np
import pytest
from arms import industrial, ur_like
from command import TWO_JOINTS, call, cell, strict_json, succeed

import urdf_ik
from urdf_ik import Arm, Comparison, DHTable, UrdfIkError
from urdf_ik.model import catalogue
from urdf_ik.verify.many_arms import ManyArms

ARM = "zyyzyz_6r"
TEXT = catalogue.resolve(ARM).path.read_text()


def edited(*changes: tuple[str, str]) -> Arm:
    """The bundled arm with parts of its URDF replaced, each of which occurs once."""
    text = TEXT
    for old, new in changes:
        assert text.count(old) == 1, (old, text.count(old))
        text = text.replace(old, new)
    return urdf_ik.load(text)


def compared(other: Arm, n: int = 60) -> Comparison:
    """The bundled arm against another one."""
    return urdf_ik.compare(urdf_ik.load(ARM), other, n=n)


def differing(comparison: Comparison) -> set[str]:
    """Names of the facts of the structure that differ."""
    return {fact.what for fact in comparison.structure if not fact.same}


def joint(name: str) -> str:
    """The element of one joint in the bundled arm's URDF."""
    found = re.search(rf'<joint name="{name}".*?</joint>', TEXT, re.DOTALL)
    assert found is not None
    return found[0]


@pytest.mark.parametrize("name", [ARM, "planar_2r", "positioning_3r", "scara_rrpr", "srs_7r"])
def test_an_arm_against_itself_differs_in_nothing(name: str) -> None:
    """Every difference is zero, to the last digit, and every pose is answered alike."""
    arm, again = urdf_ik.load(name), urdf_ik.load(name)
    found = urdf_ik.compare(arm, again, n=40, seed=3)
    assert not differing(found) and found.same and "same to rounding" in str(found)
    assert all(change.angle == change.distance == 0.0 and not change.flipped for change in found.axes)
    assert found.tip == (0.0, 0.0)
    assert len(found.axes) == len(found.limits) == arm.dof
    assert all(change.a == pytest.approx(change.b, abs=1e-9) for change in found.limits)
    assert found.farthest[0] == found.farthest[1]
    assert [reach.made_by for reach in found.reach] == ["A", "B"]
    for reach in found.reach:
        assert reach.solved == reach.within_limits == (40, 40)
        assert reach.solutions[0] == reach.solutions[1] >= 40
        assert reach.same_number == 40
    assert sum(branch.poses for branch in found.branches) == found.reach[0].solutions[0]
    assert all(set(branch.worst) == {0.0} and branch.unmatched == 0 for branch in found.branches)
    assert found.tool is not None
    assert found.tool.joint_vectors == found.reach[0].solutions[0]
    assert found.tool.position == found.tool.rotation == (0.0, 0.0, 0.0)


def test_a_tool_moved_by_3_mm_is_3_mm_off_everywhere() -> None:
    """Along any direction of its own frame, at every joint vector; the axes stay where they are."""
    table = DHTable.from_chain(urdf_ik.load(ARM).chain, name=ARM)
    shift = np.eye(4)
    shift[:3, 3] = 0.003 * np.array([2.0, -1.0, 2.0]) / 3.0
    moved = _with_tool(table, table.tool @ shift)
    found = compared(moved)
    assert found.tool is not None
    assert found.tool.joint_vectors == 480
    np.testing.assert_allclose(found.tool.position, 0.003, atol=1e-9)
    np.testing.assert_allclose(found.tool.rotation, 0.0, atol=1e-9)
    assert found.tip == pytest.approx((0.003, 0.0), abs=1e-9)
    assert max(change.distance for change in found.axes) < 1e-9
    assert re.search(r"position \[mm\] +3 +3 +3$", str(found.sections()[0]), re.MULTILINE)


def _with_tool(table: DHTable, tool: np.ndarray) -> Arm:
    rows = np.stack([table.alpha, table.a, table.d, table.theta], axis=1)
    same = {key: getattr(table, key) for key in ("joint_types", "joint_names", "limits", "base", "name")}
    return urdf_ik.load(DHTable.from_array(rows, table.convention, tool=tool, **same).to_urdf())


def test_a_link_that_is_1_mm_longer() -> None:
    """All axes beyond it that lie across it move by 1 mm, and so does the tool; the reach grows by as much."""
    arm = urdf_ik.load(ARM)
    element = joint("joint_3")
    origin = re.search(r'xyz="([^"]*)"', element)
    assert origin is not None
    x, y, z = map(float, origin[1].split())
    longer = edited((element, element.replace(origin[0], f'xyz="{x} {y} {z + 0.001}"')))
    found = compared(longer)
    np.testing.assert_allclose([change.distance for change in found.axes[:2]], 0.0, atol=1e-12)
    across = np.linalg.norm(np.cross(arm.chain.H, [0.0, 0.0, 1.0]), axis=1)
    np.testing.assert_allclose([change.distance for change in found.axes[2:]], 0.001 * across[2:], atol=1e-12)
    assert found.tool is not None
    np.testing.assert_allclose(found.tool.position, 0.001, atol=1e-12)
    assert found.tip == pytest.approx((0.001, 0.0), abs=1e-12)
    assert found.farthest[1] - found.farthest[0] == pytest.approx(0.001, abs=2e-4)
    assert differing(found) == {"axes 2 and 3"}
    # Solving on the arm as it is instead moves the joints by about 1 mm over the length of a link.
    assert all(0.0 < branch.median[1] < 0.02 for branch in found.branches)
    assert all(branch.matched == "name" for branch in found.branches)


def test_limits_that_changed() -> None:
    """One row differs, with the numbers of both; poses that need what was taken away are lost within limits."""
    element = joint("joint_2")
    limits = re.search(r'lower="([^"]*)" upper="([^"]*)"', element)
    assert limits is not None
    narrow = edited((element, element.replace(limits[0], 'lower="-0.5" upper="0.25"')))
    found = compared(narrow)
    changed = [change for change in found.limits if change.a != pytest.approx(change.b, abs=1e-9)]
    assert [change.joint for change in changed] == ["joint_2"]
    assert changed[0].a == (float(limits[1]), float(limits[2]))
    assert changed[0].b == (-0.5, 0.25)
    for reach in found.reach:
        assert reach.solved == (60, 60)
        assert reach.same_number == 60
    assert found.reach[0].within_limits[0] == 60 > found.reach[0].within_limits[1]
    assert found.tool is not None and found.tool.position[2] == 0.0


@pytest.mark.parametrize("number", [1, 3, 6])
def test_an_axis_that_was_flipped(number: int) -> None:
    """It is called flipped; to reach the same poses its joint has the other sign, and the others the same values."""
    element = joint(f"joint_{number}")
    axis = re.search(r'<axis xyz="([^"]*)"', element)
    assert axis is not None
    other = " ".join(str(-float(value)) for value in axis[1].split())
    flipped = edited((element, element.replace(axis[0], f'<axis xyz="{other}"')))
    found = compared(flipped)
    assert [change.joint for change in found.axes if change.flipped] == [f"joint_{number}"]
    assert found.axes[number - 1].angle == pytest.approx(math.pi)
    assert found.tip == (0.0, 0.0)
    arm = urdf_ik.load(ARM)
    for reach in found.reach:
        assert reach.same_number == 60
    for branch in found.branches:
        assert branch.matched == "nearest"
        others = np.delete(branch.worst, number - 1)
        assert others.max() < 1e-6, branch.branch
        assert branch.median[number - 1] > 0.1
    q = np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
    mirrored = q.copy()
    mirrored[number - 1] *= -1.0
    np.testing.assert_allclose(arm.fk(q), flipped.fk(mirrored), atol=1e-12)


def test_arms_of_other_families_are_matched_by_the_nearest_solution() -> None:
    """Where a branch's name is unknown to the other arm, its nearest solution counts; no difference exceeds pi."""
    a, b = urdf_ik.load(ur_like().urdf), urdf_ik.load(industrial().urdf)
    found = urdf_ik.compare(a, b, n=30)
    assert "family" in differing(found)
    assert found.branches
    for branch in found.branches:
        assert branch.matched == ("name" if branch.branch in b.structure.branches else "nearest")
        assert branch.poses == 0 or max(branch.worst) <= math.pi


def test_what_cannot_be_compared_is_said() -> None:
    """Other numbers of joints leave structure and reach; a joint that slides is no joint that turns."""
    six, seven = urdf_ik.load("puma_560"), urdf_ik.load("srs_7r")
    found = urdf_ik.compare(six, seven, n=20)
    assert found.axes == found.limits == found.branches == ()
    assert found.tool is None
    assert len(found.reach) == 2
    assert found.reach[1].solved[1] == 20
    words = " ".join(found.notes)
    assert "A has 6 joints and B has 7" in words
    assert "infinitely many" in words
    stanford = urdf_ik.compare(six, urdf_ik.load("stanford_rrprrr"), n=20)
    assert "'joint_3' of B slides" in " ".join(stanford.notes)
    few = urdf_ik.compare(urdf_ik.load("positioning_3r"), urdf_ik.load("planar_2r"), n=20)
    assert "the position, B for the planar position" in " ".join(few.notes)


def test_an_arm_that_is_not_solved_is_compared_as_far_as_it_goes() -> None:
    """Joint vectors that were drawn take the place of solutions: the tool's error needs no inverse kinematics."""
    longer = TWO_JOINTS.replace('"0 0 1"/><axis', '"0 0 1.5"/><axis')
    found = urdf_ik.compare(urdf_ik.load(TWO_JOINTS), urdf_ik.load(longer), n=10)
    assert found.reach == found.branches == ()
    assert found.tool is not None
    np.testing.assert_allclose(found.tool.position, 0.5, atol=1e-12)
    assert found.tool.joint_vectors == 10
    assert any(note.startswith("reach") for note in found.notes)


def test_many_arms_answer_the_same_poses() -> None:
    """One row a solution, one for a pose that is not reached; contacts as coal sees them, or said to be unchecked."""
    arm = urdf_ik.load(ARM)
    T = arm.fk(np.random.default_rng(4).uniform(-2.0, 2.0, (12, 6)))
    found = urdf_ik.compare_many({"old": arm, "new": urdf_ik.load("puma_560")}, T)
    old = [row for row in found.rows if row.arm == "old"]
    s = arm.ik(T)
    assert len(old) == int(s.count.sum()) and found.reached("old") == 12
    assert found.reached("new") == int((urdf_ik.load("puma_560").ik(T).count > 0).sum())
    assert sum(row.in_limits for row in old) == int(s.within_limits().count.sum())
    free = sum(row.contact is False for row in old)
    assert free == sum(not hit for row, hit in zip(old, arm.cell.collisions.in_collision(s.q[s.valid]), strict=True))
    assert ElementTree.fromstring(found.svg()).tag.endswith("svg") and "<svg" in found._repr_html_()
    assert ManyArms.from_dict(json.loads(found.to_json())).poses == 12
    frame = found.to_frame()
    assert list(frame.columns) == [
        "arm", "pose", "branch", "reachable", "in_limits", "limit_margin", "manipulability", "contact"
    ]  # fmt: skip
    bare = urdf_ik.load(arm.model.xml.decode().replace("collision", "visual"))
    words = urdf_ik.compare_many([bare], T)
    assert "not checked" in repr(words) and {row.contact for row in words.rows} == {"not checked"}
    with pytest.raises(UrdfIkError):
        urdf_ik.compare_many([], T)


def test_a_table_in_the_way_takes_the_lower_elbows() -> None:
    """Above a table in front of a UR5 the upper elbows are free by coal, the lower ones are not; the tool counts."""
    arm, world = urdf_ik.load("ur5"), urdf_ik.World()
    world.add("table", urdf_ik.Box((0.8, 1.2, 0.1)), urdf_ik.pose([0.6, 0.0, -0.05]))
    T = [urdf_ik.pose([0.35, y, 0.12], rpy=[np.pi, 0.0, 0.0]) for y in (-0.1, 0.0, 0.1)]
    found = urdf_ik.compare_many({"ur5": "ur5", "again": arm}, T, world=world)
    for row in found.rows:
        assert row.contact is ("elbow down" in row.branch), row
    assert found.reached("again") == 3
    text = str(found)
    assert all("  all  " in line for line in text.splitlines() if "elbow up" in line)
    assert max(map(len, text.splitlines())) <= 80
    drill = arm.with_tool(
        urdf_ik.pose([0.0, 0.0, 0.1]), [(urdf_ik.Cylinder(0.02, 0.3), urdf_ik.pose([0.0, 0.0, 0.15]))]
    )
    hit = urdf_ik.compare_many([drill], [each @ urdf_ik.pose([0.0, 0.0, 0.1]) for each in T], world=world)
    assert all(row.contact is True for row in hit.rows if row.in_limits)
    degrees = found.in_degrees()
    assert (
        degrees.rows[0].limit_margin == pytest.approx(np.rad2deg(found.rows[0].limit_margin)) and degrees.unit == "deg"
    )


def test_the_command_compares_in_a_cell_and_draws_it(tmp_path: Path) -> None:
    """--world, --tool-cylinder and --tool-urdf take the branches that touch; -o FILE.svg is the picture."""
    slide = chains.joint("slide", "prismatic", "palm", "finger", "0 0 0.1", axis="0 1 0")
    finger = chains.collision('box size="0.02 0.02 0.2"', "0 0 0.1")
    (tmp_path / "gripper.urdf").write_text(chains.robot(slide, finger=finger))
    words = ["compare", "ur5", "ur5", "-n", "2", "--xyz", "0.35,0,0.12", "--rpy", "180,0,0", "--degrees"]
    in_cell = [*words, "--world", cell(tmp_path / "cell.urdf", 'box size="0.8 1.2 0.1"', (0.6, 0, -0.05))]
    gripper = ["--tool-urdf", str(tmp_path / "gripper.urdf")]
    for some, free in (
        (words, 8),
        (in_cell, 4),
        ([*in_cell, "--tool-cylinder", "0.02,0.3"], 0),
        (in_cell + gripper, 0),
    ):
        rows = strict_json(succeed(*some, "-f", "json"))["poses"]["rows"]
        assert sum(row[7] is False for row in rows if row[0].startswith("A")) == free
    succeed(*in_cell, "-o", str(tmp_path / "cell.svg"))
    assert ElementTree.fromstring((tmp_path / "cell.svg").read_text()).tag.endswith("svg")


def test_the_command_takes_many_arms_poses_and_an_exit_code(tmp_path: Path) -> None:
    """Status 1 only with --exit-code and a difference; every option for all arms or for one; poses from a file."""
    np.save(tmp_path / "T.npy", urdf_ik.load(ARM).fk(np.zeros((2, 6)) + 0.3))

    loose = "--exit-code", "--tolerance-mm", "0.2", "--ignore", "names"
    for words, status in (
        (("--exit-code",), 0),
        (("--tool-xyz", "B=0,0,0.1"), 0),
        (("--tool-xyz", "B=0,0,0.1", "--exit-code"), 1),
        (("--tool-xyz", "0,0,0.1", "--exit-code"), 0),
        (("--tool-xyz", "B=0,0,0.0001", *loose), 0),
    ):
        assert call("compare", "-n", "2", ARM, ARM, *words).exit_code == status, words
    out = succeed("compare", "-n", "2", ARM, "puma_560", "dh_6r", "--poses", str(tmp_path / "T.npy"))
    assert "C dh_6r" in out and "the same poses" in out
    assert call("compare", ARM).exit_code == 2
