"""Rows of NaN, as solutions are padded with, pass through every function that takes joint vectors."""

from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik.errors import ArgumentError

NAMES = ("zyyzyz_6r", "srs_7r", "panda", "planar_2r")
ASKED = ("fk", "jacobian", "link_poses", "manipulability", "limit_margin", "to_pinocchio", "redundancy_of", "clearance")


def padded(arm: urdf_ik.Arm) -> np.ndarray:
    """Joint vectors (2, 3, n), of which the second of each three is NaN."""
    q = np.random.default_rng(5).uniform(-0.3, 0.3, size=(2, 3, arm.dof))
    q[:, 1] = np.nan
    return q


def compare(whole: Any, alone: Any) -> None:
    """The answers where there is a joint vector are those of the joint vector alone; the others are NaN."""
    np.testing.assert_array_equal(whole[:, [0, 2]], alone)
    assert np.isnan(whole[:, 1]).reshape(2, -1).any(axis=1).all()


@pytest.mark.parametrize("ask", ASKED)
@pytest.mark.parametrize("name", NAMES)
def test_rows_of_nan_give_nan(name: str, ask: str) -> None:
    """Every method of an arm answers the other rows as if these were alone."""
    arm = urdf_ik.load(name)
    if ask == "redundancy_of" and arm.redundancy is None:
        return
    q = padded(arm)
    whole, alone = getattr(arm, ask)(q), getattr(arm, ask)(q[:, [0, 2]])
    if isinstance(whole, dict):
        for link in whole:
            compare(whole[link], alone[link])
    else:
        compare(whole, alone)


def test_the_padding_of_ik_passes() -> None:
    """What `ik` returns for an arm with fewer solutions than columns can be asked about as it is."""
    arm = urdf_ik.load("panda")
    s = arm.ik(arm.fk([[0.0, -0.3, 0.0, -2.0, 0.0, 1.8, 0.5], [0.1, 0.3, 0.2, -1.0, 0.0, 1.5, 0.2]]))
    assert not s.valid.all()
    np.testing.assert_array_equal(np.isnan(arm.limit_margin(s.q)), ~s.valid)
    position = np.linalg.norm(arm.fk(s.q)[..., :3, 3] - s.poses[:, None, :3, 3], axis=-1)
    assert np.nanmax(position) < 1e-9 and np.array_equal(np.isnan(position), ~s.valid)


def test_a_motion_to_nowhere_is_not_free() -> None:
    """It is not proven, and has no first contact."""
    arm = urdf_ik.load("zyyzyz_6r")
    q = padded(arm)[0]
    motions = arm.motion_is_free(q[0], q)
    assert motions.free.tolist() == [True, False, arm.motion_is_free(q[0], q[2]).free]
    assert np.isnan(motions.share[1]) and motions.pairs[1] is None
    assert not arm.motion_is_free(q[0], q[1])


def test_a_row_that_is_nan_in_part_is_refused() -> None:
    """That is no padding, but a mistake: the joint is named."""
    arm = urdf_ik.load("zyyzyz_6r")
    q = padded(arm)[0]
    q[2, 3] = np.nan
    with pytest.raises(ArgumentError, match=r"joint vector\[2\]: joint 'joint_4' is nan"):
        arm.fk(q)
