"""Joint vectors that a chain takes: batches of any shape, numbers of any type; and those it refuses."""

import numpy as np
import pytest
from chains import HAND, RIGHT, serial

from urdf_ik.errors import ArgumentError
from urdf_ik.kinematics.chain import from_urdf
from urdf_ik.model import urdf


@pytest.mark.parametrize("shape", [(), (5,), (2, 3), (1,), (0,), (2, 0, 3), (2, 1, 2, 2)])
def test_batches_of_any_shape(shape: tuple[int, ...]) -> None:
    """A batch gives, in its own shape, what each of its joint vectors gives, bit for bit."""
    chain = from_urdf(urdf.read(HAND.format(RIGHT)), "drawer", "tool")
    q = np.random.default_rng(6).uniform(-2.0, 2.0, (*shape, chain.n))
    poses, jacobians, links = chain.fk(q), chain.jacobian(q), chain.link_poses(q)
    assert poses.shape == (*shape, 4, 4)
    assert jacobians.shape == (*shape, 6, chain.n)
    assert {pose.shape for pose in links.values()} == {(*shape, 4, 4)}
    for index in np.ndindex(*shape):
        np.testing.assert_array_equal(poses[index], chain.fk(q[index]))
        np.testing.assert_array_equal(jacobians[index], chain.jacobian(q[index]))
        alone = chain.link_poses(q[index])
        for link, pose in links.items():
            np.testing.assert_allclose(pose[index], alone[link], atol=1e-15)


def test_joint_vectors_of_any_number_type() -> None:
    """Lists, tuples, integers, single precision and strided arrays mean the numbers that they hold."""
    chain = from_urdf(urdf.read(serial("RPR")))
    expected = chain.fk(np.array([1.0, -2.0, 0.5])), chain.jacobian(np.array([1.0, -2.0, 0.5]))
    strided = np.array([[1.0, 9.0, -2.0], [9.0, 9.0, 9.0], [0.5, 9.0, 9.0]])
    for q in (
        [1, -2, 0.5],
        (1.0, -2.0, 0.5),
        np.array([1, -2, 0.5], dtype=np.float32),
        np.array([1, -2, 0.5], dtype=np.float16),
        np.array([0.5, -2.0, 1.0])[::-1],
        strided.ravel()[::2][[0, 1, 3]],
    ):
        np.testing.assert_array_equal(chain.fk(q), expected[0])
        np.testing.assert_array_equal(chain.jacobian(q), expected[1])
    whole = np.array([[1, -2, 3], [0, 0, 0]])
    for kind in (np.int8, np.int64, np.float32):
        np.testing.assert_array_equal(chain.fk(whole.astype(kind)), chain.fk(whole.astype(kind).astype(float)))
    np.testing.assert_array_equal(chain.fk(np.asfortranarray(whole)), chain.fk(whole.astype(float)))


def test_joint_vectors_are_not_modified() -> None:
    """What was handed in is still the same afterwards, and what comes out belongs to the caller."""
    chain = from_urdf(urdf.read(HAND.format(RIGHT)), "base", "tool")
    q = np.array([[0.3, 7.0], [-0.2, -8.0]])
    before = q.copy()
    first = chain.fk(q), chain.jacobian(q), chain.link_poses(q)["tool"]
    np.testing.assert_array_equal(q, before)
    kept = [array.copy() for array in first]
    for array in first:
        array[...] = 0.0
    for again, expected in zip((chain.fk(q), chain.jacobian(q), chain.link_poses(q)["tool"]), kept, strict=True):
        np.testing.assert_array_equal(again, expected)


@pytest.mark.parametrize(
    ("q", "words"),
    [
        ([0.0, 0.0], r"\(2,\).*3 joints \(j0, j1, j2\)"),
        ([[0.0] * 4] * 3, r"\(3, 4\)"),
        (1.0, "last dimension must be 3"),
        ([], r"\(0,\)"),
        ([0.0, np.nan, 0.0], "'j1' is nan"),
        ([0.0, 0.0, -np.inf], "'j2' is -inf"),
        (
            [[[0.0] * 3] * 2, [[0.0] * 3, [np.inf, 0.0, np.nan]]],
            r"\[1, 1\].*'j0' is inf",
        ),
        (
            np.array([1j, 0.0, 0.0]),
            "array of numbers",
        ),
        (["a", "b", "c"], "array of numbers"),
        ([[0.0, 0.0, 0.0], [0.0, 0.0]], "array of numbers"),
        (None, "array of numbers"),
        (np.ones(3, dtype=bool), "type bool"),
        ({"j0": 1.0}, "array of numbers"),
        ([1j, 0.0, 0.0], "array of numbers"),
    ],
)
def test_what_is_no_joint_vector(q: object, words: str) -> None:
    """A wrong shape, or what is not a finite number, raises ArgumentError, which names joint and place."""
    chain = from_urdf(urdf.read(serial("RPR")))
    for ask in (chain.fk, chain.jacobian, chain.link_poses):
        with pytest.raises(ArgumentError, match=words):
            ask(q)  # type: ignore[arg-type]
