"""The cross-check passes sound arms, and every kind of damage is caught by the row that is there for it."""

import json
from collections.abc import Callable
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from arms import KINDS, random_arm

import urdf_ik
from urdf_ik.arm import with_positioner
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import UnsupportedArm, UrdfError
from urdf_ik.verify.crosscheck import CrossCheck, check, replay

ROWS = (
    "joints and limits",
    "forward kinematics, position",
    "forward kinematics, rotation",
    "Jacobian",
    "links, position",
    "links, rotation",
    "batch = single, kinematics",
    "solutions, position",
    "solutions, rotation",
    "planted joint vector",
    "batch = single, solutions",
    "duplicates",
    "collision, verdict",
    "collision, distance",
)
FEW = 12


@lru_cache
def loaded(name: str) -> Any:
    """An arm by name."""
    return urdf_ik.load(name)


class Damaged:
    """A sound arm of which some members are replaced."""

    def __init__(self, **members: Any) -> None:
        self._members = members

    def __getattr__(self, name: str) -> Any:
        arm = loaded("zyyzyz_6r")
        members = object.__getattribute__(self, "_members")
        return members[name] if name in members else getattr(arm, name)


def damaged_ik(change: Callable[[np.ndarray, np.ndarray], None], *, where: str = "both") -> Any:
    """An ``ik`` whose joint vectors (m, B, n) and valid flags (m, B) go through ``change``."""

    def ik(T: np.ndarray, redundancy: Any = None) -> Any:
        sound = loaded("zyyzyz_6r").ik(T)
        q, valid = np.array(sound.q), np.array(sound.valid)
        if where == "both" or (where == "batch") == (T.ndim == 3):
            change(q.reshape(-1, *q.shape[-2:]), valid.reshape(-1, valid.shape[-1]))
        return SimpleNamespace(q=q, valid=valid, branches=sound.branches)

    return ik


# ---------------------------------------------------------------- sound arms


@pytest.mark.parametrize(("name", "n"), [("zyyzyz_6r", 60), ("dh_6r", 60), ("ur3", 8), ("ur5", 15), ("ur10", 8)])
def test_a_sound_arm_passes(name: str, n: int) -> None:
    """Every property of a sound arm holds, every row compared something, and nothing was left out."""
    report = check(loaded(name), n, seed=1)
    assert report.passed, str(report)
    assert report.skipped == ()
    assert tuple(row.name for row in report.rows) == ROWS
    assert all(row.checked > 0 for row in report.rows)
    assert report.row("planted joint vector").checked == n
    assert report.row("solutions, position").checked > 4 * n
    assert report.row("collision, distance").checked == report.row("solutions, position").checked + n


@pytest.mark.parametrize("kind", KINDS)
def test_random_members_of_every_family_pass(kind: str) -> None:
    """Arms with any base, tool, axis signs and lengths pass; without collision shapes, the report says so."""
    report = check(urdf_ik.load(random_arm(kind, 11).urdf, "base", "tool"), 20)
    assert report.passed, str(report)
    assert [name for name, _ in report.skipped] == ["collision"]
    assert "no link has a collision shape" in report.skipped[0][1]


def test_arms_with_two_redundancy_parameters_pass() -> None:
    """A free axis on seven joints, and a positioner of two on six: poses are solved at the values of both."""
    table = with_positioner(loaded("zyyzyz_6r"), loaded("planar_2r"), np.eye(4))
    for arm in (urdf_ik.load("srs_7r").with_free_axis("z"), table):
        assert len(arm.solver.parameters) == 2
        report = check(arm, 20, seed=2)
        assert report.passed, str(report)
        assert tuple(row.name for row in report.rows) == ROWS


def test_the_same_seed_gives_the_same_report() -> None:
    """Reports are equal for equal seeds, differ for others, and a pose depends on seed and index alone."""
    arm = loaded("zyyzyz_6r")
    first = check(arm, 10, seed=3)
    assert check(arm, 10, seed=3) == first
    assert check(arm, 10, seed=4) != first
    longer = check(arm, 11, seed=3)
    worst = longer.row("forward kinematics, position")
    q, T = replay(arm, 3, worst.index)
    assert tuple(q) == worst.q
    np.testing.assert_array_equal(Reference(arm.model, arm.base, arm.tip).pose(q), T)


def test_collision_is_compared_up_to_the_bound() -> None:
    """The bound on collision counts joint vectors; none are compared where collision is not wanted."""
    arm = loaded("zyyzyz_6r")
    assert check(arm, FEW, collision_poses=17).row("collision, verdict").checked == 17
    report = check(arm, FEW, collision=False)
    assert report.skipped == (("collision", "not asked for"),)
    assert "collision, verdict" not in [row.name for row in report.rows]


def test_collision_without_shapes() -> None:
    """To insist on collision where there are no shapes is an error."""
    arm = urdf_ik.load(random_arm("wrist, 2||3", 1).urdf, "base", "tool")
    with pytest.raises(UrdfError, match="no link has a collision shape"):
        check(arm, FEW, collision=True)


def test_an_arm_without_joints() -> None:
    """From a link to itself, or with every joint held: kinematics and collision agree, and nothing is solved."""
    arm = loaded("zyyzyz_6r")
    for still in (urdf_ik.load("zyyzyz_6r", tip="base_link"), arm.with_locked(dict.fromkeys(arm.joint_names, 0.1))):
        report = check(still, 3)
        assert report.passed, str(report)
        assert [name for name, _ in report.skipped] == ["inverse kinematics"]
        assert report.row("collision, distance").checked == 3


def test_an_arm_without_a_solver() -> None:
    """Where no solver takes the arm the rest is still checked, and the report says what was not."""

    def ik(T: np.ndarray, redundancy: Any = None) -> Any:
        raise UnsupportedArm("nobody solves this")

    report = check(Damaged(ik=ik), FEW)
    assert report.passed
    assert report.skipped == (("inverse kinematics", "nobody solves this"),)
    assert [row.name for row in report.rows] == [*ROWS[:7], *ROWS[12:]]
    assert report.row("collision, distance").checked == FEW


# ---------------------------------------------------------------- damaged arms


def mirrored_fk(q: np.ndarray) -> np.ndarray:
    """Forward kinematics with the sign of one joint wrong."""
    return loaded("zyyzyz_6r").fk(np.asarray(q) * [1, 1, -1, 1, 1, 1])


def fk_not_a_number(q: np.ndarray) -> np.ndarray:
    """Forward kinematics that gives NaN now and then."""
    T = loaded("zyyzyz_6r").fk(q)
    T[np.asarray(q)[..., 0] > 0] = np.nan
    return T


def stretched_fk(q: np.ndarray) -> np.ndarray:
    """Forward kinematics whose rotation is no rotation, though it shows no angle."""
    T = loaded("zyyzyz_6r").fk(q)
    T[..., :3, :3] *= 1.0 + 1e-9
    return T


def swapped_jacobian(q: np.ndarray) -> np.ndarray:
    """A Jacobian with angular rows above linear ones."""
    return np.roll(loaded("zyyzyz_6r").jacobian(q), 3, axis=-2)


def fk_other_alone(q: np.ndarray) -> np.ndarray:
    """Forward kinematics that differs by a hair for single joint vectors."""
    T = loaded("zyyzyz_6r").fk(q)
    return T + 1e-11 if T.ndim == 2 else T


def shifted_link(q: np.ndarray) -> dict[str, np.ndarray]:
    """Link poses of which one is a millimetre off."""
    poses = dict(loaded("zyyzyz_6r").link_poses(q))
    poses["link_4"] = poses["link_4"].copy()
    poses["link_4"][..., 1, 3] += 1e-3
    return poses


def turned_link(q: np.ndarray) -> dict[str, np.ndarray]:
    """Link poses of which one is turned by half a turn."""
    poses = dict(loaded("zyyzyz_6r").link_poses(q))
    poses["link_2"] = poses["link_2"] @ np.diag([-1.0, -1.0, 1.0, 1.0])
    return poses


def missing_link(q: np.ndarray) -> dict[str, np.ndarray]:
    """Link poses without one that has collision shapes."""
    return {name: pose for name, pose in loaded("zyyzyz_6r").link_poses(q).items() if name != "link_3"}


def far_link(q: np.ndarray) -> dict[str, np.ndarray]:
    """Link poses with the upper arm where nothing can be touched."""
    poses = dict(loaded("zyyzyz_6r").link_poses(q))
    for name in ("link_2", "link_3"):
        poses[name] = poses[name].copy()
        poses[name][..., 2, 3] += 100.0
    return poses


def dropped(q: np.ndarray, valid: np.ndarray) -> None:
    """One branch is never found."""
    q[:, 3], valid[:, 3] = np.nan, False


def perturbed(q: np.ndarray, valid: np.ndarray) -> None:
    """One joint of one branch is a hair off: far more than the contract allows, far less than one sees."""
    q[:, 5, 1] += 1e-8


def valid_nan(q: np.ndarray, valid: np.ndarray) -> None:
    """A solution that is no number is called valid."""
    q[:, 2] = np.nan


def twisted(q: np.ndarray, valid: np.ndarray) -> None:
    """The last joint, which moves no position, is off."""
    q[:, 6, 5] += 1e-6


def doubled(q: np.ndarray, valid: np.ndarray) -> None:
    """One branch is given twice, the second time a turn and a rounding error away."""
    q[:, 1] = q[:, 0] + 2 * np.pi + 1e-12


DAMAGE = {
    "one sign wrong": ({"fk": mirrored_fk}, {"forward kinematics, position", "forward kinematics, rotation"}),
    "NaN pose": ({"fk": fk_not_a_number}, {"forward kinematics, position", "forward kinematics, rotation"}),
    "stretched rotation": ({"fk": stretched_fk}, {"forward kinematics, rotation"}),
    "Jacobian's rows swapped": ({"jacobian": swapped_jacobian}, {"Jacobian"}),
    "single fk differs": ({"fk": fk_other_alone}, {"batch = single, kinematics"}),
    "link shifted": ({"link_poses": shifted_link}, {"links, position", "collision, distance"}),
    "link turned": ({"link_poses": turned_link}, {"links, rotation", "collision, distance"}),
    "link missing": (
        {"link_poses": missing_link},
        {"links, position", "links, rotation", "collision, verdict", "collision, distance"},
    ),
    "links out of contact": (
        {"link_poses": far_link},
        {"links, position", "collision, verdict", "collision, distance"},
    ),
    "branch dropped": ({"ik": damaged_ik(dropped)}, {"planted joint vector"}),
    "solution perturbed": ({"ik": damaged_ik(perturbed)}, {"solutions, position", "solutions, rotation"}),
    "tool twisted": ({"ik": damaged_ik(twisted)}, {"solutions, rotation"}),
    "valid NaN": ({"ik": damaged_ik(valid_nan)}, {"solutions, position", "solutions, rotation"}),
    "perturbed in batch": ({"ik": damaged_ik(perturbed, where="batch")}, {"batch = single, solutions"}),
    "dropped alone": ({"ik": damaged_ik(dropped, where="single")}, {"batch = single, solutions"}),
    "branch doubled": ({"ik": damaged_ik(doubled)}, {"duplicates"}),
    "limits wrong": ({"limits": np.tile([-3.0, 3.0], (6, 1))}, {"joints and limits"}),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_damage_is_caught_by_its_row(damage: str) -> None:
    """The rows that are there for the damage fail, with a place that replays; untouched properties still hold."""
    members, rows = DAMAGE[damage]
    arm = Damaged(**members)
    report = check(arm, 40, seed=2)
    failed = {row.name for row in report.failed}
    assert not report.passed
    assert rows <= failed, str(report)
    touched = {
        "fk": ("forward kinematics", "batch = single, kin"),
        "jacobian": ("Jacobian", "batch = single, kin"),
        "link_poses": ("links", "collision"),
        "ik": ("solutions", "planted", "batch = single, sol", "duplicates"),
        "limits": ("joints",),
    }[next(iter(members))]
    assert all(name.startswith(touched) for name in failed), str(report)
    for row in report.failed:
        assert row.worst > row.tolerance
        if row.name != "joints and limits":
            planted, T = replay(arm, report.seed, row.index)
            if "not finite" in row.detail:
                assert row.q == tuple(planted)
            elif row.name.startswith("solutions"):
                assert max(Reference(arm.model, arm.base, arm.tip).error(row.q, T)) > row.tolerance
            elif row.name.startswith(("forward", "Jacobian", "planted", "duplicates")):
                assert row.q == tuple(planted)


def test_the_worst_case_is_the_worst() -> None:
    """A row holds the greatest of all values, and the place where it is."""
    at = {5: 1e-6, 17: 3e-6, 30: 2e-6}
    sound = loaded("zyyzyz_6r")

    def fk(q: np.ndarray) -> np.ndarray:
        T = sound.fk(q)
        if T.ndim == 3:
            for index, offset in at.items():
                T[index, 2, 3] += offset
        return T

    row = check(Damaged(fk=fk), 40, collision=False).row("forward kinematics, position")
    assert row.worst == pytest.approx(3e-6, rel=1e-6)
    assert (row.index, row.q, row.checked) == (17, tuple(replay(sound, 0, 17)[0]), 40)


def test_other_joints_are_no_crash() -> None:
    """An arm whose joints are not Pinocchio's fails in the first row, and the rest is not attempted."""
    report = check(Damaged(joint_names=tuple(reversed(loaded("zyyzyz_6r").joint_names))), FEW)
    assert not report.passed
    assert [row.name for row in report.rows] == ["joints and limits"]
    assert "joint_6, joint_5" in report.rows[0].detail
    assert report.skipped[0][0] == "all else"


# ---------------------------------------------------------------- the report


def test_a_report_survives_json() -> None:
    """A report with infinite values is strict JSON, and comes back equal."""
    report = check(Damaged(ik=damaged_ik(valid_nan), fk=fk_not_a_number), FEW, collision=False)
    assert report.row("solutions, position").worst == np.inf

    def refuse(constant: str) -> None:
        pytest.fail(f"{constant} is no JSON")

    data = json.loads(report.to_json(), parse_constant=refuse)
    assert data["passed"] is False
    assert data["rows"][1]["worst"] == "inf"
    assert CrossCheck.from_dict(data) == report
    assert CrossCheck.from_json(report.to_json()) == report
