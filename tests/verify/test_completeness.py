"""Two ways to all solutions: sound arms agree, a crippled solver is caught, one solution is no difference."""

from collections.abc import Callable
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from arms_general import calibrated_ur, crx_like, jaco_like, standard_dh
from cases import described, from_catalogue

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import UnsupportedArm
from urdf_ik.verify import completeness
from urdf_ik.verify.completeness import (
    BOTH,
    CONTINUUM,
    CORNER,
    DISTANCES,
    SECOND,
    SOLVER,
    Sameness,
)

FEW = 16

Change = Callable[[np.ndarray, np.ndarray], None]


@lru_cache
def loaded(name: str) -> Any:
    """An arm by name."""
    return {"crx": lambda: described(crx_like()).arm, "jaco": lambda: described(jaco_like()).arm}.get(
        name, lambda: from_catalogue(name).arm
    )()


class Crippled:
    """A sound arm whose answers go through ``change(q, valid)``."""

    def __init__(self, name: str, change: Change) -> None:
        self._sound, self._change = loaded(name), change

    def __getattr__(self, name: str) -> Any:
        return getattr(object.__getattribute__(self, "_sound"), name)

    def ik(self, T: np.ndarray) -> Any:
        """Its answer, changed."""
        sound = self._sound.ik(T)
        q, valid = np.array(sound.q), np.array(sound.valid)
        self._change(q, valid)
        return SimpleNamespace(q=q, valid=valid, branches=sound.branches)


def reference_of(name: str) -> Sameness:
    """The reference of an arm's solutions."""
    arm = loaded(name)
    return Sameness(arm.chain, Reference(arm.model, arm.base, arm.tip))


@pytest.mark.parametrize("name", ["zyyzyz_6r", "ur5"])
def test_a_closed_form_is_complete(name: str) -> None:
    """Against the elimination no solution is missing, and on random poses neither has more than the other."""
    report = completeness.compare(loaded(name), FEW, seed=2)
    assert report.passed, str(report)
    assert "elimination" in report.second and "Newton" in report.second
    assert [group.near for group in report.groups] == [None, *DISTANCES, CORNER]
    assert report.groups[0].poses == FEW and sum(group.poses for group in report.groups) == 3 * FEW
    assert report.groups[0].solver == report.groups[0].second > 4 * FEW
    assert report.groups[0].differences == 0


@pytest.mark.parametrize("name", ["crx", "jaco"])
def test_a_general_arm_is_compared_with_other_ways(name: str) -> None:
    """Where the solver is an elimination, another one and Newton's method find the same on random poses."""
    report = completeness.compare(loaded(name), FEW, seed=3)
    assert report.groups[0].solver == report.groups[0].second
    assert report.groups[0].differences == 0


@pytest.mark.parametrize("name", ["zyyzyz_6r", "crx"])
def test_a_solver_that_loses_a_branch_is_caught(name: str) -> None:
    """What is taken from the answers is reported: pose, solution, neighbours, conditioning, errors."""

    def drop_last(q: np.ndarray, valid: np.ndarray) -> None:
        for row in range(len(q)):
            last = np.flatnonzero(valid[row])[-1]
            valid[row, last], q[row, last] = False, np.nan

    arm = Crippled(name, drop_last)
    report = completeness.compare(arm, FEW, seed=2)
    assert not report.passed
    lost = [d for d in report.differences if d.missed_by in (SOLVER, BOTH) and d.near is None]
    assert {d.index for d in lost} == set(range(FEW))
    for difference in lost:
        planted, T = completeness.replay(arm, FEW, 2, difference.index)
        assert difference.planted == tuple(planted)
        q, sound = np.array(difference.q), loaded(name).ik(T)
        assert np.abs(np.remainder(sound.to_array() - q + np.pi, 2 * np.pi) - np.pi).max(axis=1).min() < 1e-6
        assert 1e-6 < difference.nearest <= np.pi
        assert difference.sigma_min > 0.0
        assert max(difference.position_error, difference.rotation_error) < 1e-9
    assert "FAILED" in report.verdict()
    assert f"pose {lost[0].index}" in str(report)


def test_a_solution_that_is_none_is_caught() -> None:
    """A joint vector that misses the pose is a difference that counts, although only the solver has it."""

    def shift(q: np.ndarray, valid: np.ndarray) -> None:
        valid[:] = True
        q[:] = np.nan_to_num(q, nan=0.5)
        q[:, 3] = q[:, 2] + 1e-4

    report = completeness.compare(Crippled("zyyzyz_6r", shift), 2, seed=2)
    assert not report.passed
    assert any(d.counts and d.missed_by == SECOND and d.position_error > 1e-9 for d in report.differences)


def test_representatives_of_one_continuum_are_no_difference() -> None:
    """At a wrist singularity any q4 stands for the continuum; the other wrist, which is another pose, does not."""
    reference, arm = reference_of("zyyzyz_6r"), loaded("zyyzyz_6r")
    q = np.array([0.4, -0.7, 1.1, 0.3, 0.0, -0.5])
    elsewhere = q + [0.0, 0.0, 0.0, 1.9, 0.0, -1.9]
    T = arm.fk(q)
    answer = reference.unmatched(T, q, q[None], elsewhere[None])
    assert (answer.only_first, answer.only_second, answer.planted_lost) == ([], [], False)
    assert answer.how[CONTINUUM] == 2
    solutions = arm.ik(T).to_array()
    other = solutions[np.abs(solutions[:, 2] - q[2]) > 0.1][:1]
    answer = reference.unmatched(T, q, q[None], other)
    assert len(answer.only_first) == len(answer.only_second) == 1


def test_a_curved_continuum_is_one_too() -> None:
    """With a stretched q5 an arm of three parallel axes slides along a curve in four joints: one continuum."""
    reference, arm = reference_of("ur5"), loaded("ur5")
    q = np.array([0.4, -0.9, 1.1, 0.6, 0.0, 0.2])
    T = arm.fk(q)
    # The representatives of the solver for two reference vectors.
    first, second = (arm.ik(T, q_ref=np.full(6, r)).to_array() for r in (0.0, 0.9))
    on_first = [x for x in first if np.abs(np.sin(x[4])) < 1e-9]
    on_second = [x for x in second if np.abs(np.sin(x[4])) < 1e-9]
    assert on_first and on_second
    answer = reference.unmatched(T, q, np.array(on_first), np.array(on_second))
    assert answer.only_first == answer.only_second == [] and not answer.planted_lost


def test_a_double_root_is_one_solution() -> None:
    """Two elbows that rounding cannot keep apart are one solution; a thousand times further apart they are two."""
    reference, arm = reference_of("zyyzyz_6r"), loaded("zyyzyz_6r")
    for bend, number in ((1e-7, 1), (1e-4, 2)):
        up = np.array([0.4, -0.7, bend, 0.3, 0.6, -0.5])
        T = arm.fk(up)
        found = arm.ik(T).to_array()
        pair = found[np.abs(found - up).max(axis=1) < 1e-2]
        down = pair[np.argmin(pair[:, 2])]
        answer = reference.unmatched(T, up, up[None], down[None])
        assert len(answer.only_first) == len(answer.only_second) == number - 1


def test_poses_lie_where_they_are_said_to() -> None:
    """The Jacobian's determinant changes sign within the distance that a pose is planted at."""
    arm, n = loaded("zyyzyz_6r"), len(DISTANCES)
    for index, near in enumerate(DISTANCES, start=n):
        q, _ = completeness.replay(arm, n, 7, index)
        signs = set()
        for joint in range(6):
            for step in (-1.01 * near - 1e-12, 1.01 * near + 1e-12):
                moved = q.copy()
                moved[joint] += step
                signs.add(np.sign(np.linalg.det(arm.jacobian(moved))))
        assert len(signs) == 2


def test_an_arm_of_five_joints_is_refused() -> None:
    """The second method is for six turning joints."""
    five = standard_dh("five", (1.5, 0.3, 0.9, -0.7, 1.1), (0.1, 0.4, 0.2, 0.1, 0.0), (0.3, 0.0, 0.1, 0.2, 0.1))
    with pytest.raises(UnsupportedArm, match="six turning joints"):
        completeness.compare(urdf_ik.load(five.urdf, base="base", tip="tool"), 1)


def test_an_imperfect_arm_is_compared_with_elimination_and_newton() -> None:
    """An arm off its family by a calibration: nothing is missing on random poses."""
    arm = described(calibrated_ur()).arm
    report = completeness.compare(arm, 6, seed=1)
    assert report.groups[0].differences == 0, str(report)
