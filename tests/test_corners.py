"""Poses as people teach them: right angles, straight and folded elbows, aligned wrists, several at once, and beside them."""

from __future__ import annotations

import arms
import arms_closed_forms
import closed_forms
import contract
import pytest
from cases import MEMBERS_OF, from_catalogue, named

FAMILIES = tuple(arms.KINDS)
MORE = tuple(arms_closed_forms.KINDS)
CATALOGUE = ("zyyzyz_6r", "dh_6r", "ur5", "ur10")


@pytest.mark.parametrize("name", CATALOGUE)
def test_catalogue(name: str) -> None:
    """Arms of the catalogue."""
    contract.holds_at_corners(from_catalogue(name), 24, 1)


@pytest.mark.parametrize("kind", FAMILIES)
def test_families(kind: str) -> None:
    """Spherical wrists and three parallel axes, oblique, at right angles, and with rounded frames."""
    for name in MEMBERS_OF[kind]:
        contract.holds_at_corners(named(name), 12, 2)


@pytest.mark.parametrize("kind", MORE)
def test_closed_forms(kind: str) -> None:
    """Three parallel axes at one end, a spherical triple in the middle."""
    for case in closed_forms.members(kind)[:2]:
        contract.holds_at_corners(case, 8, 3)


@pytest.mark.parametrize("name", CATALOGUE)
def test_round_poses(name: str) -> None:
    """Round positions with round orientations."""
    contract.holds_at_round_poses(from_catalogue(name), 2, 4)
