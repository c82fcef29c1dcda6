"""Measurements from arrays and files: what is read, and what is refused in words."""

import io
from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik.calibration import measured, read_measurements
from urdf_ik.errors import ArgumentError, PoseError
from urdf_ik.model.poses import to_quat_wxyz, to_rpy

ARM = urdf_ik.load("zyyzyz_6r")
Q = np.random.default_rng(0).uniform(-1.0, 1.0, (12, 6))
T = ARM.fk(Q)


def csv(header: str, rows: Any) -> io.BytesIO:
    """A CSV file."""
    return io.BytesIO("\n".join([header, *(",".join(map(repr, row)) for row in np.asarray(rows).tolist())]).encode())


def test_a_csv_is_read_by_its_names() -> None:
    """Columns stand in any order and beside others; orientations and degrees as they are called."""
    names = ",".join(reversed(ARM.joint_names))
    rows = np.hstack([Q[:, ::-1], T[:, :3, 3], to_quat_wxyz(T), np.arange(12.0)[:, None]])
    given = read_measurements(ARM, csv(f"{names},x,y,z,qw,qx,qy,qz,number", rows))
    assert given.kind == "pose"
    np.testing.assert_array_equal(given.q, Q)
    np.testing.assert_allclose(given.values, T, atol=1e-12)
    names = ",".join(ARM.joint_names)
    rows = np.hstack([np.rad2deg(Q), T[:, :3, 3], np.rad2deg(to_rpy(T))])
    given = read_measurements(ARM, csv(f"{names},x,y,z,roll,pitch,yaw", rows), degrees=True)
    np.testing.assert_allclose(given.values, T, atol=1e-9)
    np.testing.assert_allclose(given.q, Q, atol=1e-12)


def test_without_an_orientation_it_is_a_position() -> None:
    """The columns say what was measured."""
    given = read_measurements(ARM, csv(",".join([*ARM.joint_names, "x", "y", "z"]), np.hstack([Q, T[:, :3, 3]])))
    assert given.kind == "position"
    np.testing.assert_array_equal(given.values, T[:, :3, 3])


@pytest.mark.parametrize(
    ("q", "values", "words"),
    [
        (np.rad2deg(Q) * 4.0, T, "are they in degrees"),
        (Q, T[:, :3, 3] * 1000.0, "are they in mm"),
        (np.vstack([Q, Q[3]]), np.concatenate([T, T[3:4]]), "measurements 3 and 12 are the same"),
        (np.where(np.arange(6) == 2, np.nan, Q), T, "'joint_3' is nan"),
        (Q, np.where(np.arange(4) == 3, np.nan, T), "not finite|nan"),
        (Q, T[:5], r"shape \(5, 4, 4\) given; finite numbers \(12, 4, 4\)"),
        (Q[0], T[0], r"\(m, 6\) are needed"),
        (Q, np.zeros(12), "poses|shape"),
    ],
)
def test_arrays_that_do_not_fit_are_refused_in_words(q: Any, values: Any, words: str) -> None:
    """Degrees for rad, mm for m, copies, NaN, other shapes."""
    with pytest.raises((ArgumentError, PoseError), match=words):
        measured(ARM, q, values)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("joint_1,joint_2,joint_3,joint_4,joint_5,joint_6,x,y\n1,2,3,4,5,6,7,8", "no column z"),
        ("0.1,0.2,0.3,0.4,0.5,0.6,0.1,0.2,0.3", "no header"),
        ("joint_1,joint_2,joint_3,joint_4,joint_5,x,y,z\n1,2,3,4,5,6,7,8", "'joint_6': no column"),
        ("joint_1,joint_2,joint_3,joint_4,joint_5,joint_6,x,y,z\n1,2,3,4,5,six,7,8,9", "'six' is no finite number"),
        ("joint_1,joint_2,joint_3,joint_4,joint_5,joint_6,x,y,z\n1,2,3", "line 2: 3 values; 9 are needed"),
        ("", "is empty"),
    ],
)
def test_files_that_do_not_fit_are_refused_with_their_line(text: str, words: str) -> None:
    """A file without a header, without a joint, with a word, with a short line."""
    with pytest.raises(ArgumentError, match=words):
        read_measurements(ARM, io.BytesIO(text.encode()))
