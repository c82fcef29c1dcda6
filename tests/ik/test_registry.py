"""The registry of families: records are whole, every arm has a reason, and a family is added by a record and a row."""

import re
from dataclasses import replace

import contract
import numpy as np
import pytest
from arms import industrial, random_arm
from arms_closed_forms import KINDS as CLOSED_FORMS
from cases import described

import urdf_ik
from urdf_ik.ik.families import every, registry, spherical_wrist
from urdf_ik.kinematics.structure import Structure
from urdf_ik.model import catalogue

FAMILIES = every()


def test_a_reason_is_counted_from_the_base() -> None:
    """The reason numbers the axes from the base, also for an arm that is solved from its tip."""
    family = spherical_wrist.TWO_PARALLEL
    assert family.why() == "axes 4, 5 and 6 meet in a point, and axes 2 and 3 are parallel"
    assert family.why(from_tip=True) == "axes 1, 2 and 3 meet in a point, and axes 4 and 5 are parallel"


@pytest.mark.parametrize("name", catalogue.BUNDLED)
def test_every_bundled_arm_has_a_reason(name: str) -> None:
    """The structure of every solved arm gives the reason why it can be solved."""
    structure = urdf_ik.load(name).structure
    assert bool(structure.family) == bool(structure.reason)
    assert not re.search(r"[{}]|  ", structure.reason)


@pytest.mark.parametrize("kind", [kind for kind in CLOSED_FORMS if "reversed" not in kind])
def test_an_arm_whose_joints_follow_from_quadratics_is_not_cuspidal(kind: str) -> None:
    """Where no quartic gives a joint, the record says that no change of branch leads around the singularities."""
    structure = described(random_arm(kind, 4, kinds=CLOSED_FORMS)).arm.structure
    assert structure.by_quadratics == ("position" not in structure.branches[0])
    assert structure.cuspidal is (False if structure.by_quadratics else None)


def test_a_toy_family_is_added_by_a_record_and_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    """A record and a row make a family that is chosen first and passes the contract of ``ik``.

    Its header is one that is compiled already: wrists whose axes meet at right angles are the toy.
    """

    def is_square(structure: Structure) -> bool:
        return all(abs(structure.pairs[k].angle - np.pi / 2.0) < 1e-12 for k in (3, 4))

    whole = spherical_wrist.TWO_PARALLEL
    toy = replace(
        whole,
        name="6R toy",
        reason="axes {4, 5, 6} meet at right angles",
        matches=lambda structure, chain: whole.matches(structure, chain) and is_square(structure),
    )
    monkeypatch.setattr(registry, "SIX_TURNING", [toy, *registry.SIX_TURNING])
    case = described(industrial())
    assert case.arm.structure.family.startswith("6R toy")
    assert case.arm.structure.reason == "axes 4, 5 and 6 meet at right angles"
    assert "6R toy" in str(case.arm.structure)
    contract.holds(case, poses=20, seed=1)
    contract.is_complete(case, poses=2, seed=2)
    contract.batch_equals_single(case, case.oracle.poses(case.oracle.draw(np.random.default_rng(3), 7)))
