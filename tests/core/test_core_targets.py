"""Steps of the core: target poses, their defects and the nearest rotation."""

import math

import core_steps
import numpy as np
import pytest
from arms import rotation
from core_samples import PI, step
from numpy.typing import NDArray

Array = NDArray[np.float64]


def defects(T: Array) -> list[float]:
    """The defect of a pose, alone and in a block."""
    numbers = T.reshape(1, 16)
    return [float(core_steps.step("pose_defect", numbers, side_by_side=many)[0, 0]) for many in (False, True)]


@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-8, 1e-5, 1e-2])
def test_project_rotation_gives_the_nearest(size: float) -> None:
    """The rotation becomes the orthogonal factor of its singular value decomposition; the rest of the pose stays."""
    rng = np.random.default_rng(1)
    for _ in range(10):
        T = np.eye(4)
        T[:3, :3] = rotation(rng.normal(size=3), rng.uniform(0, PI)) + size * rng.normal(size=(3, 3))
        T[:3, 3] = rng.normal(size=3)
        left, _, right = np.linalg.svd(T[:3, :3])
        out = np.array(step("project_rotation", *T.ravel())).reshape(4, 4)
        np.testing.assert_allclose(out[:3, :3], left @ right, atol=2e-15)
        np.testing.assert_array_equal(out[:, 3], T[:, 3])
        np.testing.assert_array_equal(out[3], T[3])


def spoilt(place: tuple[int, int], number: float) -> Array:
    """A pose with one number replaced."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation(np.array([1.0, 2.0, 3.0]), 0.5), [0.3, 0.2, 0.1]
    T[place] = number
    return T


def test_defect_of_what_is_not_finite() -> None:
    """One NaN or infinity anywhere makes the defect exceed every tolerance, in a block and alone."""
    for place in np.ndindex(4, 4):
        for number in (math.nan, math.inf, -math.inf):
            assert not any(defect <= 1e300 for defect in defects(spoilt(place, number))), (place, number)


def test_defect_of_reflections_and_last_rows() -> None:
    """A reflection has an infinite defect though it is orthogonal; a last row counts by how far it is off."""
    turned_in = spoilt((3, 3), 1.0) @ np.diag([1.0, -1.0, 1.0, 1.0])
    for T, defect in (
        (turned_in, math.inf),
        (spoilt((3, 1), 0.25), 0.25),
        (spoilt((3, 3), 0.5), 0.5),
        (np.zeros((4, 4)), math.inf),
    ):
        assert defects(T) == [defect, defect]
