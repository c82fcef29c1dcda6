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


def damaged_ik(
    branch: int,
    joint: int | slice = slice(None),
    by: float = np.nan,
    *,
    of: int | None = None,
    valid: bool = True,
    where: str = "both",
) -> dict[str, Any]:
    """An ``ik`` in which one branch, or what another one gives in its place, is off by a number."""

    def ik(T: np.ndarray, redundancy: Any = None) -> Any:
        sound = loaded("zyyzyz_6r").ik(T)
        q, flags = np.array(sound.q), np.array(sound.valid)
        if where == "both" or (where == "batch") == (T.ndim == 3):
            q[..., branch, joint] = sound.q[..., branch if of is None else of, joint] + by
            flags[..., branch] &= valid
        return SimpleNamespace(q=q, valid=flags, branches=sound.branches)

    return {"ik": ik}


def after(member: str, change: Callable[[np.ndarray, Any], Any]) -> dict[str, Any]:
    """A member whose value goes through ``change``, which also gets the joint vectors."""
    return {member: lambda q: change(np.asarray(q), getattr(loaded("zyyzyz_6r"), member)(q))}


def elsewhere(**places: np.ndarray) -> dict[str, Any]:
    """Link poses of which some are moved in their own frames."""
    return after("link_poses", lambda q, T: {name: each @ places.get(name, np.eye(4)) for name, each in T.items()})


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


def test_collision_is_not_compared_where_it_is_not_wanted() -> None:
    """The report says why it is left out."""
    arm = loaded("zyyzyz_6r")
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


FAR = urdf_ik.pose([0.0, 0.0, 100.0])
DAMAGE: dict[str, tuple[dict[str, Any], set[str]]] = {
    "one sign wrong": (
        {"fk": lambda q: loaded("zyyzyz_6r").fk(np.asarray(q) * [1, 1, -1, 1, 1, 1])},
        {"forward kinematics, position", "forward kinematics, rotation"},
    ),
    "NaN pose": (
        after("fk", lambda q, T: np.where(q[..., :1, None] > 0, np.nan, T)),
        {"forward kinematics, position", "forward kinematics, rotation"},
    ),
    # A rotation that is none, though it shows no angle.
    "stretched rotation": (
        after("fk", lambda q, T: T * np.where([True, True, True, False], 1.0 + 1e-9, 1.0)),
        {"forward kinematics, rotation"},
    ),
    "Jacobian's rows swapped": (after("jacobian", lambda q, J: np.roll(J, 3, axis=-2)), {"Jacobian"}),
    "single fk differs": (after("fk", lambda q, T: T + 1e-11 * (T.ndim == 2)), {"batch = single, kinematics"}),
    "link shifted": (elsewhere(link_4=urdf_ik.pose([0.0, 1e-3, 0.0])), {"links, position", "collision, distance"}),
    "link turned": (elsewhere(link_2=np.diag([-1.0, -1.0, 1.0, 1.0])), {"links, rotation", "collision, distance"}),
    "link missing": (
        after("link_poses", lambda q, T: {name: each for name, each in T.items() if name != "link_3"}),
        {"links, position", "links, rotation", "collision, verdict", "collision, distance"},
    ),
    "links out of contact": (
        elsewhere(link_2=FAR, link_3=FAR),
        {"links, position", "collision, verdict", "collision, distance"},
    ),
    "branch dropped": (damaged_ik(3, valid=False), {"planted joint vector"}),
    # Far more than the contract allows, far less than one sees.
    "solution perturbed": (damaged_ik(5, 1, 1e-8), {"solutions, position", "solutions, rotation"}),
    "tool twisted": (damaged_ik(6, 5, 1e-6), {"solutions, rotation"}),
    "valid NaN": (damaged_ik(2), {"solutions, position", "solutions, rotation"}),
    "perturbed in batch": (damaged_ik(5, 1, 1e-8, where="batch"), {"batch = single, solutions"}),
    "dropped alone": (damaged_ik(3, valid=False, where="single"), {"batch = single, solutions"}),
    "branch doubled": (damaged_ik(1, by=2 * np.pi + 1e-12, of=0), {"duplicates"}),
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
    report = check(Damaged(**DAMAGE["valid NaN"][0], **DAMAGE["NaN pose"][0]), FEW, collision=False)
    assert report.row("solutions, position").worst == np.inf

    def refuse(constant: str) -> None:
        pytest.fail(f"{constant} is no JSON")

    data = json.loads(report.to_json(), parse_constant=refuse)
    assert data["passed"] is False
    assert data["rows"][1]["worst"] == "inf"
    assert CrossCheck.from_dict(data) == report
    assert CrossCheck.from_dict(json.loads(report.to_json())) == report
