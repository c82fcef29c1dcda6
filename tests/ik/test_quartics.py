"""Closed forms with a quartic: what an answer claims, against solvers that know nothing of the quartic."""

import numpy as np
import pytest
from arms import random_arm
from cases import Case, described, thinned
from closed_forms import by_elimination, member
from searches import folds

KINDS = ("1||2||3", "2x3x4", "2x3x4, 1x2, 4x5", "2x3x4, 1||2, 4||5")
"""Of ``closed_forms``; a spherical wrist and three parallel axes in the middle come from ``arms``."""


def case_of(kind: str, seed: int) -> Case:
    """A random member, its structure exact to the last digit where the seed is odd."""
    if kind in KINDS:
        return member(kind, seed, seed > 0, seed % 2 == 1)
    return described(random_arm(kind, seed, orthogonal=seed > 0, aligned=seed % 2 == 1))


CASES = [(kind, seed) for kind in (*KINDS, "wrist, general", "2||3||4") for seed in range(2)]


@pytest.mark.parametrize("member_of", thinned(CASES, 4))
def test_random_poses_are_proven_and_elimination_finds_nothing_more(member_of: tuple[str, int]) -> None:
    """The elimination of general arms shares no step with the closed form."""
    case, seed = case_of(*member_of), member_of[1]
    Q = np.random.default_rng(seed).uniform(-np.pi, np.pi, (40, 6))
    s = case.arm.ik(case.arm.fk(Q))
    assert np.count_nonzero(s.certain) >= 38
    for k in np.flatnonzero(s.certain)[:10]:
        others = by_elimination(case, case.arm.fk(Q[k]))
        assert len(others) <= np.count_nonzero(s.valid[k])


@pytest.mark.parametrize(("kind", "seed"), CASES)
def test_where_roots_nearly_meet_no_planted_vector_is_denied(kind: str, seed: int) -> None:
    """1e-1 to 1e-8 rad from a fold, an answer that says certain has the vector that the pose was made from."""
    case = case_of(kind, seed)
    rng = np.random.default_rng(seed)
    Q = folds(case.arm, 24, rng)
    d = rng.normal(size=Q.shape)
    Q = Q + (10.0 ** rng.uniform(-8, -1, len(Q)) / np.linalg.norm(d, axis=1))[:, None] * d
    s = case.arm.ik(case.arm.fk(Q))
    apart = np.abs((s.q - Q[:, None] + np.pi) % (2 * np.pi) - np.pi).max(axis=2)
    found = np.nanmin(np.where(s.valid, apart, 9.0), axis=1) < 1e-4
    assert (found | ~s.certain).all()
