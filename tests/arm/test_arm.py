"""An arm: its repr, immutability, pickling, threads, and the arms that it refuses to solve."""

import pickle
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from arms import DescribedArm, industrial, random_arm, serial_urdf, ur_like
from cases import described, from_catalogue, nearest, rows
from numpy.typing import NDArray
from oracle import Oracle, angle_distance

import urdf_ik
from urdf_ik.errors import PoseError, UnsupportedArm
from urdf_ik.show.shapes import stick

Array = NDArray[np.float64]
Q = np.array([0.3, 0.5, 0.9, 0.4, 0.8, -0.2])
TEXT = ur_like().urdf


# ---------------------------------------------------------------- what an arm says of itself


@pytest.mark.parametrize("attribute", ["name", "base", "tip", "joint_names", "dof", "limits"])
def test_an_arm_does_not_change(attribute: str) -> None:
    """Attributes of an arm cannot be assigned, and its arrays cannot be written to."""
    arm = urdf_ik.load(TEXT, "base", "tool")
    with pytest.raises(AttributeError):
        setattr(arm, attribute, None)
    with pytest.raises(ValueError, match="read-only"):
        arm.limits[0] = 0.0


@pytest.mark.parametrize("used", [False, True])
@pytest.mark.parametrize(
    "described_arm", [industrial(), ur_like(), random_arm("wrist, general", 1)], ids=lambda arm: arm.name
)
def test_pickle(described_arm: DescribedArm, used: bool) -> None:
    """An arm comes back from pickling with its structure and, before or after its first use, the same answers."""
    arm = urdf_ik.load(described_arm.urdf, "base", "tool")
    target = arm.fk(Q)
    expected = urdf_ik.load(described_arm.urdf, "base", "tool").ik(target)
    if used:
        arm.ik(target)
    again = pickle.loads(pickle.dumps(arm))
    assert repr(again) == repr(arm)
    assert again.structure == arm.structure
    np.testing.assert_array_equal(again.fk(Q), arm.fk(Q))
    np.testing.assert_array_equal(again.limits, arm.limits)
    np.testing.assert_array_equal(again.ik(target).q, expected.q)
    assert again.model.xml == arm.model.xml


# ---------------------------------------------------------------- ik


def test_nested_lists_of_pinocchio_poses() -> None:
    """SE3 objects in lists of lists are a batch of that shape."""
    case = from_catalogue("zyyzyz_6r")
    targets = case.oracle.poses(case.oracle.draw(np.random.default_rng(0), 6)).reshape(2, 3, 4, 4)
    given = [[pin.SE3(pose) for pose in row] for row in targets]
    solutions = case.arm.ik(given)
    assert solutions.q.shape == (2, 3, 8, 6)
    np.testing.assert_allclose(solutions.q, case.arm.ik(targets).q, atol=1e-12, equal_nan=True)


@pytest.mark.parametrize("form", ["array", "Fortran", "read-only view", "float32", "list"])
def test_answers_do_not_follow_the_callers_array(form: str) -> None:
    """Overwriting the target after the call changes neither the solutions nor the pose that they belong to."""
    case = from_catalogue("zyyzyz_6r")
    far = np.eye(4)
    far[0, 3] = 3.0
    for target in (case.oracle.pose(Q), far):
        mine: Any = {
            "array": target.copy(),
            "Fortran": np.asfortranarray(target),
            "read-only view": target.copy(),
            "float32": target.astype(np.float32),
            "list": target.tolist(),
        }[form]
        given = mine
        if form == "read-only view":
            given = mine.view()
            given.setflags(write=False)
        wanted = np.array(mine, dtype=np.float64)
        solutions = case.arm.ik(given)
        q, text = solutions.q.copy(), solutions.explain()
        for row in mine:
            row[:] = [9.0] * 4
        np.testing.assert_array_equal(solutions.q, q)
        np.testing.assert_array_equal(solutions.poses, wanted)
        assert solutions.explain() == text


@pytest.mark.parametrize("bad", [(0,), (1700,), (2999,), (2500, 700), (700, 1600, 2999)])
def test_the_first_bad_pose_is_named_whatever_thread_meets_it(bad: tuple[int, ...]) -> None:
    """With bad poses in several threads' shares the error still tells the first."""
    arm = from_catalogue("zyyzyz_6r").arm
    targets = np.tile(np.eye(4), (3000, 1, 1))
    targets[:, 2, 3] = 2.0
    for index in bad:
        targets[index, 0, 0] = np.nan
    for threads in (1, 2, 4):
        with pytest.raises(PoseError) as error:
            arm.ik(targets, threads=threads)
        assert error.value.index == (min(bad),)


@pytest.mark.parametrize(
    "turns",
    [(0, 0), (1, -1), (-2, 1), (2, 0), (0, 2), (1, -4)],
    ids=str,
)
def test_reference_a_turn_away(turns: tuple[int, int]) -> None:
    """A reference counts modulo whole turns: near a free wrist the member nearest to it is the planted one.

    A joint with limits of +-2 pi, or a continuous one that has wound up, stands such turns away.
    """
    for name in ("zyyzyz_6r", "ur5"):
        case = from_catalogue(name)
        planted = Q.copy()
        planted[4] = 0.0
        reference = planted.copy()
        reference[[3, 5]] += 2.0 * np.pi * np.array(turns)
        found = rows(case.arm.ik(case.oracle.pose(planted), q_ref=reference))
        assert nearest(found, planted) < 1e-6, name


# ---------------------------------------------------------------- arms that no solver takes


def _long(n: int) -> str:
    """A chain of n skew axes."""
    rng = np.random.default_rng(n)
    origins = [(rng.uniform(0.1, 0.4, 3), rng.uniform(-1.0, 1.0, 3)) for _ in range(n + 1)]
    return serial_urdf(f"{n}R", origins, [*rng.normal(size=(n, 3)), None])


SLIDING = _long(6)


for _joint in ("joint_2", "joint_5"):
    SLIDING = SLIDING.replace(f'name="{_joint}" type="revolute"', f'name="{_joint}" type="prismatic"')


@pytest.mark.parametrize(
    ("text", "words"),
    [(_long(10), "10 joints from 'base' to 'tool'"), (SLIDING, "two slides three joints apart (RPRRPR)")],
    ids=["10R", "RPRRPR"],
)
def test_unsupported_arm(text: str, words: str) -> None:
    """An arm of no family loads, moves and tells its axes; only asking for solutions raises, with a way out."""
    arm = urdf_ik.load(text, "base", "tool")
    names = tuple(f"joint_{i}" for i in range(1, arm.dof + 1))
    oracle = Oracle(text)
    assert arm.joint_names == oracle.names == names
    for q in np.random.default_rng(2).uniform(-1.0, 1.0, (3, arm.dof)):
        np.testing.assert_allclose(arm.fk(q), oracle.pose(q), atol=1e-13)
        np.testing.assert_allclose(arm.jacobian(q), oracle.jacobian(q), atol=1e-13)
        np.testing.assert_allclose(arm.link_poses(q)["tool"], oracle.pose(q), atol=1e-13)
    for ask in (arm.ik, arm.explain):
        with pytest.raises(UnsupportedArm) as error:
            ask(np.eye(4))
        assert words in str(error.value)
        assert "locked={" in str(error.value) or str(arm.structure) in str(error.value)
        assert arm.name in str(error.value)


# ---------------------------------------------------------------- the first call


# ---------------------------------------------------------------- a chain with other ends


@pytest.mark.parametrize("described_arm", [ur_like(), industrial()], ids=lambda a: a.name)
def test_an_arm_that_is_solved_from_its_tool(described_arm: DescribedArm) -> None:
    """With base and tip swapped the arm still loads and moves; where a family takes it, its solutions are exact."""
    arm = urdf_ik.load(described_arm.urdf, "tool", "base")
    forward = described(described_arm)
    q = Q[::-1]
    target = np.linalg.inv(forward.oracle.pose(Q))
    np.testing.assert_allclose(arm.fk(q), target, atol=1e-13)
    assert arm.joint_names == forward.arm.joint_names[::-1]
    if not arm.structure.family:
        return
    found = rows(arm.ik(target))
    expected = rows(forward.arm.ik(np.linalg.inv(target)))
    assert len(found) == len(expected)
    for solution in found:
        assert forward.oracle.error(solution[::-1], np.linalg.inv(target)) < 1e-9
        assert float(angle_distance(expected, solution[::-1]).min()) < 1e-6


def test_the_stick_of_an_arm_runs_either_way() -> None:
    """Between any two links the drawn stick is the same bones: from the tool it runs backwards, and turned."""
    text = industrial().urdf
    forward, back = urdf_ik.load(text, "base", "tool"), urdf_ik.load(text, "tool", "base")
    bones = stick(forward.chain, Q)
    seen_from_tip = np.linalg.inv(Oracle(text).pose(Q))
    np.testing.assert_allclose(
        stick(back.chain, Q[::-1])[::-1], bones @ seen_from_tip[:3, :3].T + seen_from_tip[:3, 3], atol=1e-13
    )
