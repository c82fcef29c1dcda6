"""Families with three parallel axes at one end or a spherical middle, also reversed: the contract of ``ik``."""

import closed_forms
import contract
import pytest
from arms_closed_forms import KINDS, PARALLEL_SHOULDER, SPHERICAL_MIDDLE
from cases import thinned
from closed_forms import member, members, near_member


@pytest.mark.parametrize("kind", KINDS)
def test_random_poses(kind: str) -> None:
    """Planted joint vectors are found, all solutions are exact, none is given twice; a batch is its poses."""
    for case in members(kind):
        contract.holds(case, 40, 1)
    contract.batch_equals_single_but_for_one(member(kind), 4)


@pytest.mark.parametrize("kind", thinned(KINDS, 4))
def test_many_members(kind: str) -> None:
    """Over many arms, with all signs and proportions, the same holds."""
    for seed in range(10, 22):
        contract.holds(member(kind, seed, bool(seed % 2), bool(seed // 2 % 2)), 6, seed)


@pytest.mark.parametrize("kind", thinned(KINDS, 4))
def test_singularities(kind: str) -> None:
    """At 1e-1 to 1e-8 rad from any every planted one is found, on one there are marked solutions and the reference."""
    for case in members(kind):
        contract.holds_near_singularities(case, 10, 2, decades=8)
        contract.holds_on_singularities(case, 8, 3)
        closed_forms.returns_its_reference(case, 8, 3)


@pytest.mark.parametrize("kind", thinned(KINDS, 3))
def test_quarter_turns(kind: str) -> None:
    """Where several joints are free at once there is still an exact solution."""
    for case in members(kind)[1:]:
        closed_forms.at_quarter_turns(case, 30, 4)


@pytest.mark.parametrize("kind", thinned(KINDS, 19))
def test_agrees_with_the_elimination(kind: str) -> None:
    """The general elimination finds the same solutions."""
    closed_forms.agrees_with_elimination(member(kind), 10, 5)


@pytest.mark.parametrize("kind", thinned(KINDS, 4))
def test_no_solution_is_missing(kind: str) -> None:
    """A multi-start Newton search on Pinocchio's model finds no further solution."""
    contract.is_complete(member(kind), 2, 6)


@pytest.mark.parametrize("kind", [*PARALLEL_SHOULDER, *SPHERICAL_MIDDLE])
def test_edge_of_reach(kind: str) -> None:
    """Across the edge of what the arm can do, two solutions vanish together."""
    closed_forms.has_a_clean_edge(member(kind), 7)


@pytest.mark.parametrize("kind", thinned(KINDS, 5))
@pytest.mark.parametrize("eps", [1e-12, 1e-6, 1e-3])
def test_imperfect_members(kind: str, eps: float) -> None:
    """Off by 1e-12 to 1e-3 the contract holds, with the method of the nearest family or with elimination."""
    contract.holds(near_member(kind, eps), 15, 8)
