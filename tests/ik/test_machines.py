"""Machine tools with two rotary axes and three slides in any order, and surgical parallelograms, by Pinocchio."""

from itertools import permutations

import numpy as np
import pytest
from arms_few import case_of
from chains import joint, robot

KINDS = sorted(set(permutations("PPPRR")))


def machine(joints: list[tuple[str, str, str, str]]) -> str:
    """A URDF of joints in a row, each a type, an origin, an axis and what else it has."""
    names = ["base", *(f"l{k}" for k in range(1, len(joints))), "tool"]
    rows = enumerate(joints)
    return robot(
        *(joint(f"j{k}", kind, *names[k : k + 2], xyz, axis=axis, more=more) for k, (kind, xyz, axis, more) in rows)
    )


def words(vector: object) -> str:
    """Numbers as a URDF has them."""
    return " ".join(f"{x:.4f}" for x in np.asarray(vector, dtype=np.float64))


@pytest.mark.parametrize("order", KINDS, ids="".join)
def test_two_rotary_axes_and_three_slides(order: tuple[str, ...]) -> None:
    """Every joint vector behind a pose comes back, exactly, with axes of any directions and offsets."""
    rng = np.random.default_rng(KINDS.index(order))
    slides = iter(np.linalg.qr(rng.normal(size=(3, 3)))[0])
    axes = [next(slides) if kind == "P" else rng.normal(size=3) for kind in order]
    names = {"P": "prismatic", "R": "revolute"}
    case = case_of(
        machine([(names[k], words(rng.normal(size=3)), words(a), "") for k, a in zip(order, axes, strict=True)])
    )
    for q in rng.uniform(-1.4, 1.4, (5, 5)):
        T = case.oracle.pose(q)
        s = case.arm.ik(T)
        assert np.abs(s.q[s.valid] - q).max(axis=1).min() < 1e-7
        for one in s:
            assert np.abs(case.oracle.pose(one.q) - T).max() < 1e-9


@pytest.mark.parametrize("gains", [(1.0, -1.0, 1.0), (1.0, -1.0, 1.0, -1.0, 1.0)])
def test_a_parallelogram_is_one_turn(gains: tuple[float, ...]) -> None:
    """Pitch, -pitch, pitch, with an insertion and a wrist: Pinocchio with mimic joints has these poses."""
    rng = np.random.default_rng(3)
    follow = [f'<mimic joint="j1" multiplier="{gain}"/>' if k else "" for k, gain in enumerate(gains)]
    pitch = [("revolute", words(rng.normal(size=3)), "1 0 0", more) for more in follow]
    behind = [("prismatic", "0 0 -0.3", "0 0 -1", ""), ("revolute", "0 0 0", "0 0 -1", "")]
    wrist = [("revolute", "0 0 -0.05", "1 0 0", ""), ("revolute", "0 0 -0.01", "0 1 0", "")]
    case = case_of(machine([("revolute", "0 0 0", "0 0 1", ""), *pitch, *behind, *wrist]))
    assert case.arm.dof == 6
    for q in rng.uniform(-1.2, 1.2, (5, 6)):
        T = case.arm.cell.reference.pose(q)
        s = case.arm.ik(T)
        assert np.abs(s.q[s.valid] - q).max(axis=1).min() < 1e-7
        for one in s:
            assert np.abs(case.arm.cell.reference.pose(one.q) - T).max() < 1e-9
