"""The arm and its answers in other programs: joint states."""

import numpy as np
import pytest

import urdf_ik
from urdf_ik import interop
from urdf_ik.errors import ArgumentError

Q = np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])


@pytest.fixture(scope="module")
def arm() -> urdf_ik.Arm:
    """An arm with a spherical wrist."""
    return urdf_ik.load("zyyzyz_6r")


def test_joint_states_are_matched_by_name(arm: urdf_ik.Arm) -> None:
    """Any order of names, with others between them, leads there and back; others keep what they had."""
    names = [*reversed(arm.joint_names), "gripper"]
    batch = np.stack([Q, 2.0 * Q])
    message = interop.to_joint_state(arm, batch, names, others=np.full(7, 0.5))
    assert message.shape == (2, 7) and (message[:, -1] == 0.5).all()
    assert message[0, names.index("joint_2")] == Q[1]
    np.testing.assert_array_equal(interop.from_joint_state(arm, names, message), batch)
    assert np.isnan(interop.to_joint_state(arm, Q, names)[-1])


@pytest.mark.parametrize(
    ("names", "values", "words"),
    [
        (["joint_1"], [0.0], "lacks joint_2, joint_3"),
        ([f"joint_{k}" for k in (1, 2, 3, 4, 5, 5, 6)], [0.0] * 7, "joint_5 twice"),
        ([f"joint_{k}" for k in range(1, 7)], [0.0] * 5, r"shape \(5,\)"),
        ([f"joint_{k}" for k in range(1, 7)], [np.nan] * 6, "finite"),
    ],
)
def test_joint_states_that_do_not_fit_are_refused(
    names: list[str], values: list[float], words: str, arm: urdf_ik.Arm
) -> None:
    """A joint that is missing, one that is named twice, and too few positions."""
    with pytest.raises(ArgumentError, match=words):
        interop.from_joint_state(arm, names, values)
