"""Cuspidal arms: known ones are found and their paths hold, proven others are not, and what this rests on is true."""

import math

import numpy as np
import pytest
from arms import random_arm, rotation, serial_urdf, ur_like
from arms_general import X, Z, crx_like, from_screws, jaco_like, standard_dh
from cases import Case, described, from_catalogue, member
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.ik.cuspidality import is_cuspidal, keeps_its_sign, nonsingular_change

Array = NDArray[np.float64]

QUADRATIC = ("wrist, 2||3", "wrist, 2||3, 1x2", "wrist, 1x2", "wrist, 1||2", "2||3||4, 5x6", "2||3||4, 1x2, 5x6")


def wenger() -> Case:
    """Wenger's cuspidal 3R arm, d2 = 1, d3 = 2, d4 = 1.5, r2 = 1, with a spherical wrist at its end."""
    quarter = 0.5 * math.pi
    alpha, a = (-quarter, quarter, 0.3, quarter, quarter, 0.0), (1.0, 2.0, 1.5, 0.0, 0.0, 0.0)
    return described(standard_dh("wenger", alpha, a, (0.0, 1.0, 0.0, 0.0, 0.0, 0.2)))


def determinant(arm: urdf_ik.Arm, q: Array) -> Array:
    """Determinants (...) of the Jacobian at q (..., 6)."""
    return np.linalg.det(arm.jacobian(q))


def case(name: str) -> Case:
    """One of the arms that the literature calls cuspidal."""
    return {"wenger": wenger, "jaco": lambda: described(jaco_like()), "crx": lambda: described(crx_like())}[name]()


@pytest.mark.parametrize("name", ["wenger", "jaco", "crx"])
def test_wenger_jaco_and_crx_are_cuspidal(name: str) -> None:
    """The path joins two solutions of one pose, and the Jacobian's determinant keeps its sign along it."""
    arm, oracle = case(name).arm, case(name).oracle
    assert is_cuspidal(arm.solver) is True
    path = nonsingular_change(arm.solver)
    assert path is not None
    start, end = path[0], path[-1]
    assert np.abs(np.remainder(start - end + np.pi, 2.0 * np.pi) - np.pi).max() > 1e-3
    assert oracle.error(end, oracle.pose(start)) < 1e-9
    moves = np.remainder(np.diff(path, axis=0) + np.pi, 2.0 * np.pi) - np.pi
    assert ((np.abs(moves[:, 1:5]) > 1e-12).sum(axis=1) <= 1).all()
    assert np.abs(moves).max() < np.pi
    along = np.linspace(0.0, 1.0, 200)[:, None]
    values = np.concatenate([determinant(arm, q + along * move) for q, move in zip(path, moves, strict=False)])
    assert (values > 0.0).all() or (values < 0.0).all()


@pytest.mark.parametrize("name", ["zyyzyz_6r", "dh_6r", "ur5"])
def test_zyyzyz_dh_6r_and_ur5_are_not_cuspidal(name: str) -> None:
    """Arms solved by quadratics are proven not cuspidal, and the search finds no path that contradicts it."""
    arm = from_catalogue(name).arm
    assert is_cuspidal(arm.solver) is False
    assert nonsingular_change(arm.solver) is None


@pytest.mark.parametrize("kind", QUADRATIC)
def test_members_of_quadratic_families_are_not_cuspidal(kind: str) -> None:
    """Random members of the families with a proof: the search finds no path, from either end."""
    arm = member(kind, 4).arm
    assert is_cuspidal(arm.solver) is False
    assert nonsingular_change(arm.solver) is None


def test_branches_of_quadratics_differ_in_the_signs_of_their_factors() -> None:
    """What the proof rests on: on an arm with 2 || 3, all four solutions of one wrist sign lie in other regions."""
    arm = member("wrist, 2||3", 5).arm
    rng = np.random.default_rng(3)
    for q in rng.uniform(-np.pi, np.pi, (30, 6)):
        found = arm.ik(arm.fk(q))
        signs = np.sign(determinant(arm, found.to_array()))
        # Equal numbers of both signs, so a change that keeps the sign must change two factors, which it cannot.
        assert signs.sum() == 0


def test_a_perturbed_arm_is_never_called_proven() -> None:
    """A calibrated arm is not a member of its family, so the family's proof does not apply: never False."""
    described_arm = ur_like()
    axes = described_arm.axes.copy()
    axes[2] = rotation(X, 1e-3) @ axes[2]
    arm = described(from_screws("off", "2||3||4", axes, described_arm.points, described_arm.points[-1] + 0.1)).arm
    assert not arm.structure.is_exact
    assert is_cuspidal(arm.solver) is not False


def test_six_parallel_axes_are_not_cuspidal_by_rounding() -> None:
    """With six parallel axes the determinant is rounding of zero, whose sign means nothing."""
    axes = [Z] * 6
    points = [(0.3 * i, 0.1 * i * i, 0.0) for i in range(6)]
    arm = described(from_screws("planar", "parallel", axes, points, (2.0, 0.0, 0.0))).arm
    q = np.array([0.1, 0.5, -0.4, 0.3, 0.8, 0.2])
    assert not keeps_its_sign(arm.chain, q, 2, 0.5)


def test_the_determinant_has_two_harmonics_in_each_joint() -> None:
    """On random arms the determinant is a trigonometric polynomial of degree two in joints 2 to 5, constant in 1, 6."""
    for kind in ("wrist, general", "2||3||4"):
        chain = urdf_ik.load(random_arm(kind, 8).urdf, base="base", tip="tool").chain
        for joint in range(6):
            Q = np.tile(np.random.default_rng(joint).uniform(-np.pi, np.pi, 6), (16, 1))
            Q[:, joint] = 2.0 * np.pi * np.arange(16) / 16
            harmonics = np.abs(np.fft.rfft(np.linalg.det(chain.jacobian(Q))))
            highest = 0 if joint in (0, 5) else 2
            assert harmonics[highest + 1 :].max() < 1e-12 * harmonics.max()


def test_zyyzyz_elbow_does_not_keep_its_sign_through_straight() -> None:
    """The determinant keeps its sign up to just before the elbow is straight, not to it or through it."""
    chain = from_catalogue("zyyzyz_6r").arm.chain
    q = np.array([0.3, 0.4, 1.0, 0.2, 0.8, 0.1])
    assert keeps_its_sign(chain, q, 2, 0.3)
    assert not keeps_its_sign(chain, q, 2, -0.3)
    assert not keeps_its_sign(chain, q, 2, 0.0)


def test_an_unsolved_arm_is_undecided() -> None:
    """A chain of two joints gives None."""
    text = serial_urdf("two", [(np.zeros(3), (0, 0, 0)), (Z, (0, 0, 0)), (X, (0, 0, 0))], [Z, X, None])
    assert is_cuspidal(urdf_ik.load(text, base="base", tip="tool").solver) is None
