"""Axes 2, 3 and 4 through one point, or 3, 4 and 5: the family, and why a pose is out of reach."""

from collections.abc import Sequence

import contract
import numpy as np
import pytest
from arms import random_arm, serial_urdf
from arms_closed_forms import KINDS, SPHERICAL_MIDDLE, TWICE
from cases import Case, described
from closed_forms import member, members
from numpy.typing import NDArray
from oracle import Oracle, angle_distance

import urdf_ik

MINE = tuple(kind for kind in KINDS if kind.removesuffix(", reversed") in SPHERICAL_MIDDLE)


def family_of(kind: str) -> str:
    """The family's name for one of the kinds."""
    if kind == "2x3x4, 4||5||6, reversed":
        return "6R 1||2||3 and 4x5"  # as good as the other way round, and tried first
    wrist = next((f" and {relation}" for relation in ("5x6", "5||6") if relation in kind), "")
    return f"6R 2x3x4{wrist}{', reversed' if kind.endswith('reversed') else ''}"


@pytest.mark.parametrize("kind", MINE)
def test_structure(kind: str) -> None:
    """The family is named after its cheapest relation, is exact, and has eight columns with names of their own."""
    for case in members(kind):
        structure = case.arm.structure
        assert structure.family == family_of(kind)
        assert len(set(structure.branches)) == structure.max_solutions == 8
        assert max(structure.imperfection) < 1e-13
        assert structure.method.startswith("Closed form")


@pytest.mark.parametrize("kind", MINE)
def test_out_of_reach(kind: str) -> None:
    """A pose 20 m away has no solution, and the reason says what is too far with a number."""
    case = member(kind)
    for q in case.oracle.draw(np.random.default_rng(9), 3):
        target = case.oracle.pose(q)
        target[:3, 3] += [20.0, -15.0, 10.0]
        solutions = case.arm.ik(target)
        assert len(list(solutions)) == 0
        assert " m" in solutions.explain()


@pytest.mark.parametrize("seed", range(4))
def test_the_cheapest_family_comes_first(seed: int) -> None:
    """An arm with a spherical wrist that asks for a quartic is solved by its spherical middle, without one."""
    case = described(random_arm("2x3x4, 4x5x6", seed, orthogonal=bool(seed % 2), kinds=TWICE))
    assert case.arm.structure.family.removesuffix(", reversed") == "6R 2x3x4 and 5x6"
    contract.holds(case, 30, 10)
    contract.holds_near_singularities(case, 8, 11, decades=8)
    contract.is_complete(case, 1, 12)


def elbowed(first: Sequence[float], elbow: Sequence[float], last: Sequence[float], axes: str) -> Case:
    """Three axes that meet, on a joint ``first`` away, and two joints behind them, like a humanoid's arm."""
    origins = [((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), (first, (0.0, 0.0, 0.0)), *[((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))] * 2]
    origins += [(elbow, (0.0, 0.0, 0.0)), (last, (0.0, 0.0, 0.0)), ((0.0, 0.0, 0.14), (0.0, 0.0, 0.0))]
    directions = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
    urdf = serial_urdf("elbowed", origins, [*(directions[axis] for axis in axes), None])
    return Case("elbowed", urdf_ik.load(urdf, base="base", tip="tool"), Oracle(urdf))


def nearly_round(rng: np.random.Generator, count: int) -> NDArray[np.float64]:
    """Joint vectors with some joints near a multiple of a right angle, where several singularities meet."""
    q = rng.choice([0.0, 0.5 * np.pi, -0.5 * np.pi, np.pi], (count, 6))
    elsewhere = rng.random((count, 6)) < rng.choice([0.2, 0.5, 0.8], (count, 1))
    q = np.where(elsewhere, rng.uniform(-np.pi, np.pi, (count, 6)), q)
    return q + rng.normal(size=(count, 6)) * 10.0 ** rng.uniform(-8.5, -2.0, (count, 1))


@pytest.mark.parametrize(
    ("first", "elbow", "last", "axes"),
    [
        ((-0.11, 0.0, -0.14), (0.0, -0.015, 0.15), (0.0, 0.015, 0.0), "zxyzxz"),
        ((0.14, 0.03, 0.0), (0.0, 0.0, 0.11), (0.0, 0.0, 0.26), "xyxzyx"),
    ],
)
def test_solutions_where_singularities_meet(
    first: Sequence[float], elbow: Sequence[float], last: Sequence[float], axes: str
) -> None:
    """Where two singularities meet, what one leaves open does not hide the solutions of the other: none is lost."""
    case = elbowed(first, elbow, last, axes)
    assert "2x3x4" in case.arm.structure.family
    q = nearly_round(np.random.default_rng(3), 4000)
    s = case.arm.ik(case.oracle.poses(q))
    weakest = np.array([case.oracle.sigma_min(x) for x in q])
    apart = np.where(s.valid, angle_distance(s.q, q[:, None]), np.inf).min(axis=1)
    # A pose's rounding moves its solution by the rounding over the smallest singular value.
    regular = weakest > 1e-9
    assert (apart <= 1e-6 + 1e-11 / weakest)[regular].all(), q[regular & (apart > 1e-6 + 1e-11 / weakest)]
