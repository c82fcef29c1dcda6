"""The arms that this project describes itself: what they claim to be, Pinocchio must read out of the file."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from oracle import Oracle

from urdf_ik.model import catalogue

Array = NDArray[np.float64]

# The published table: alpha [rad], a [m], d [m], theta0 [rad], in the modified (Craig) convention.
DH_ROWS = (
    (0.0, 0.0, 0.1, 0.0),
    (math.pi / 2, 0.0, 0.0, 0.0),
    (0.0, 0.5, 0.0, math.pi / 2),
    (math.pi / 2, 0.0, 0.5, 0.0),
    (-math.pi / 2, 0.0, 0.0, 0.0),
    (math.pi / 2, 0.0, 0.0, 0.0),
)


def path_of(name: str) -> Path:
    """The arm's file."""
    return catalogue.resolve(name).path


def oracle_of(name: str) -> Oracle:
    """Pinocchio's view of the arm, base_link to tool0."""
    return Oracle(path_of(name), base="base_link", tip="tool0")


def draw_within_limits(oracle: Oracle, rng: np.random.Generator, m: int) -> Array:
    """Joint vectors (m, n) [rad], uniform inside the limits."""
    return rng.uniform(oracle.model.lowerPositionLimit, oracle.model.upperPositionLimit, (m, oracle.dof))


def elementary(axis: str, angle: float = 0.0, shift: Sequence[float] = (0.0, 0.0, 0.0)) -> Array:
    """A rotation by an angle [rad] about x, y or z, with a translation [m], as a matrix (4, 4)."""
    T = np.eye(4)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    T[i, i] = T[j, j] = math.cos(angle)
    T[i, j], T[j, i] = -math.sin(angle), math.sin(angle)
    T[:3, 3] = shift
    return T


# ---------------------------------------------------------------- kinematics


def test_zyyzyz_forward_kinematics() -> None:
    """Pinocchio's pose is the product of six rotations about z y y z y z and of the six link lengths."""
    oracle = oracle_of("zyyzyz_6r")
    for q in draw_within_limits(oracle, np.random.default_rng(1), 50):
        expected = np.eye(4)
        for axis, angle, length in zip("zyyzyz", q, (1.0, 1.0, 1.0, 0.1, 0.1, 0.1), strict=True):
            expected = expected @ elementary(axis, angle) @ elementary("z", shift=(0.0, 0.0, length))
        np.testing.assert_allclose(oracle.pose(q), expected, atol=1e-14)


def test_dh_forward_kinematics() -> None:
    """Pinocchio's pose is Rx(alpha) Tx(a) Rz(theta0 + q) Tz(d), row by row of the table, in every frame."""
    oracle = oracle_of("dh_6r")
    for q in draw_within_limits(oracle, np.random.default_rng(2), 50):
        expected = np.eye(4)
        pin.framesForwardKinematics(oracle.model, oracle.data, q)
        for i, ((alpha, a, d, theta0), angle) in enumerate(zip(DH_ROWS, q, strict=True), start=1):
            expected = expected @ elementary("x", alpha) @ elementary("x", shift=(a, 0.0, 0.0))
            expected = expected @ elementary("z", theta0 + angle) @ elementary("z", shift=(0.0, 0.0, d))
            frame = oracle.data.oMf[oracle.model.getFrameId(f"link_{i}", pin.FrameType.BODY)]
            np.testing.assert_allclose(frame.homogeneous, expected, atol=1e-14)
        np.testing.assert_allclose(oracle.pose(q), expected, atol=1e-14)


def test_dh_example_target_has_eight_solutions_within_the_limits() -> None:
    """Newton from many starts finds eight joint vectors for the published target, and the limits hold them all."""
    oracle = oracle_of("dh_6r")
    x, y, z, w = 0.0, 0.0, 0.8, 0.6
    target = pin.SE3(pin.Quaternion(w, x, y, z).matrix(), np.array([0.5, 0.11, 0.26])).homogeneous
    solutions = oracle.solutions(target, np.random.default_rng(3))
    assert len(solutions) == 8
    assert max(oracle.error(q, target) for q in solutions) < 1e-10
    assert (solutions > oracle.model.lowerPositionLimit).all()
    assert (solutions < oracle.model.upperPositionLimit).all()


# ---------------------------------------------------------------- limits, masses, shapes
