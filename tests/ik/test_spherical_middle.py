"""Axes 2, 3 and 4 through one point, or 3, 4 and 5: the family, and why a pose is out of reach."""

from __future__ import annotations

import contract
import numpy as np
import pytest
from arms import random_arm
from arms_closed_forms import KINDS, SPHERICAL_MIDDLE, TWICE
from cases import described
from closed_forms import member, members

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
