"""Axes 2, 3 and 4 through one point, or 3, 4 and 5: complete, exact, without duplicates, at singularities too."""

from __future__ import annotations

import closed_forms
import numpy as np
import pytest
from arms import random_arm
from arms_closed_forms import KINDS, SPHERICAL_MIDDLE, TWICE
from cases import described
from closed_forms import member, members, near_member

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
def test_random_poses(kind: str) -> None:
    """Planted joint vectors come back, all are exact, none comes twice."""
    for case in members(kind):
        closed_forms.holds(case, 40, 1)


@pytest.mark.parametrize("kind", MINE)
def test_many_members(kind: str) -> None:
    """Over many arms, with all signs and proportions, the same holds."""
    for seed in range(10, 22):
        closed_forms.holds(member(kind, seed, bool(seed % 2), bool(seed // 2 % 2)), 6, seed)


@pytest.mark.parametrize("kind", MINE)
def test_near_singularities(kind: str) -> None:
    """At 1e-1 to 1e-8 rad from any singularity every planted one is found."""
    for case in members(kind):
        closed_forms.holds_near_singularities(case, 10, 2)


@pytest.mark.parametrize("kind", MINE)
def test_on_singularities(kind: str) -> None:
    """Exactly singular poses have marked solutions, and the planted one where it is the reference."""
    for case in members(kind):
        closed_forms.holds_on_singularities(case, 8, 3)


@pytest.mark.parametrize("kind", MINE)
def test_quarter_turns(kind: str) -> None:
    """Where several joints are free at once there is still an exact solution."""
    for case in members(kind)[1:]:
        closed_forms.at_quarter_turns(case, 30, 4)


@pytest.mark.parametrize("kind", MINE)
def test_agrees_with_the_elimination(kind: str) -> None:
    """The general elimination finds the same solutions."""
    closed_forms.agrees_with_elimination(member(kind), 10, 5)


@pytest.mark.parametrize("kind", MINE)
def test_no_solution_is_missing(kind: str) -> None:
    """A multi-start Newton search on Pinocchio's model finds no further solution."""
    closed_forms.is_complete(member(kind), 2, 6)


@pytest.mark.parametrize("kind", MINE)
def test_batch_equals_single(kind: str) -> None:
    """A stack of poses gives what each pose gives."""
    closed_forms.batch_equals_single(member(kind))


@pytest.mark.parametrize("kind", SPHERICAL_MIDDLE)
def test_edge(kind: str) -> None:
    """Across the edge of what the arm can do, two solutions vanish together."""
    closed_forms.has_a_clean_edge(member(kind), 7)


@pytest.mark.parametrize("kind", MINE)
@pytest.mark.parametrize("eps", [1e-12, 1e-6, 1e-3])
def test_imperfect_members(kind: str, eps: float) -> None:
    """Off by 1e-12 to 1e-3 the contract holds, with the method of the nearest family or with elimination."""
    closed_forms.holds(near_member(kind, eps), 15, 8)


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
    closed_forms.holds(case, 30, 10)
    closed_forms.holds_near_singularities(case, 8, 11)
    closed_forms.is_complete(case, 1, 12)
