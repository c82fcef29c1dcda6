"""Axes 1, 2 and 3 parallel, or 4, 5 and 6: the family, and why a pose is out of reach."""

import numpy as np
import pytest
from arms import random_arm
from arms_closed_forms import DEGENERATE, KINDS, PARALLEL_SHOULDER
from cases import assert_exact, closest_pair, described, flags
from closed_forms import member, members

from urdf_ik.ik.solutions import Singular

MINE = tuple(kind for kind in KINDS if kind.removesuffix(", reversed") in PARALLEL_SHOULDER)
FAMILY = {
    "1||2||3, 5x6": "6R 1||2||3 and 5x6",
    "1||2||3, 3x4, 5x6": "6R 1||2||3 and 5x6",
    "1||2||3, 5||6": "6R 1||2||3 and 5||6",
    "1||2||3, 4x5": "6R 1||2||3 and 4x5",
    "1||2||3, 4x5, 5x6": "6R 1||2||3 and 5x6",
    "1||2||3, 4x5, 5||6": "6R 1||2||3 and 5||6",
    "1||2||3, 4||5": "6R 1||2||3 and 4||5",
    "1||2||3, 4||5, 5x6": "6R 1||2||3 and 5x6",
    "1||2||3": "6R 1||2||3",
    "1||2||3, 3x4": "6R 1||2||3",
}


@pytest.mark.parametrize("kind", MINE)
def test_structure(kind: str) -> None:
    """The family is named after its cheapest relation, is exact, and has eight columns with names of their own."""
    reverse = ", reversed" if kind.endswith("reversed") else ""
    for case in members(kind):
        structure = case.arm.structure
        assert structure.family == FAMILY[kind.removesuffix(", reversed")] + reverse
        assert len(set(structure.branches)) == structure.max_solutions == 8
        assert sum("elbow up" in name for name in structure.branches) == 4
        assert max(structure.imperfection) < 1e-13
        assert structure.method.startswith("Closed form")


@pytest.mark.parametrize("kind", PARALLEL_SHOULDER)
def test_out_of_reach(kind: str) -> None:
    """20 m off along the parallel axes the wrist does not reach, and the reason says by how much; so from the tip."""
    case, back = member(kind), member(f"{kind}, reversed")
    for q in case.oracle.draw(np.random.default_rng(9), 3):
        target = case.oracle.pose(q)
        target[:3, 3] += 20.0 * case.arm.chain.H[0]
        solutions = case.arm.ik(target)
        assert len(list(solutions)) == 0
        assert " m from axis 1" in solutions.explain()
        assert back.arm.explain(target).startswith("seen from the tip, ")


@pytest.mark.parametrize("kind", DEGENERATE)
def test_arms_that_are_singular_everywhere(kind: str) -> None:
    """A fourth parallel axis, a wrist that meets or is parallel, two axes in line: samples of the continuum, marked."""
    case = described(random_arm(kind, 0, kinds=DEGENERATE))
    assert case.arm.structure.family == "6R singular everywhere"
    for q in case.oracle.draw(np.random.default_rng(11), 20):
        assert case.oracle.sigma_min(q) < 1e-12
        target = case.oracle.pose(q)
        solutions = case.arm.ik(target)
        found = assert_exact(case, solutions, target)
        assert len(found) > 1
        assert (flags(solutions) == Singular.OTHER).all()
        assert closest_pair(found) > 0.1
