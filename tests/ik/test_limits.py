"""Joint limits and +-2 pi images, against an oracle that tries every number of turns."""

import itertools

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from urdf_ik import UrdfIkError
from urdf_ik.ik.solutions import limits

Array = NDArray[np.float64]

PI = np.pi
TOL = limits.LIMIT_TOLERANCE
MOST = 12  # turns that the oracle tries in either direction

values = st.one_of(
    st.floats(-PI, PI, exclude_min=True),
    st.sampled_from([PI, np.nextafter(PI, 0), np.nextafter(-PI, 0), 0.0, 3.14, 3.1416 - 2 * PI, -1.0, 1e-12, -1e-12]),
)
bounds = st.one_of(
    st.tuples(st.floats(-30.0, 30.0), st.floats(0.0, 30.0)).map(lambda b: (b[0], b[0] + b[1])),
    st.sampled_from(
        [(-PI, PI), (-3.1416, 3.1416), (-3.14, 3.14), (-2 * PI, 2 * PI), (-6.2832, 6.2832), (0.0, 2 * PI), (PI, PI),
         (0.0, 0.0), (-PI, 0.0), (PI, 3 * PI), (4.0, 5.0), (-np.inf, np.inf), (-1.0, np.inf), (-np.inf, -4.0)]
    ),
)  # fmt: skip
tolerances = st.sampled_from([TOL, 0.0, 1e-6, -0.05])
joints = st.lists(st.tuples(values, bounds, st.booleans()), min_size=1, max_size=4)


def images(value: float, bound: tuple[float, float], turns: bool, tol: float) -> list[float]:
    """Numbers of turns that bring the value inside, fewest first, then the one nearer to zero."""
    steps = range(-MOST, MOST + 1) if turns else (0,)
    inside = [k for k in steps if bound[0] - tol <= value + k * (2 * PI) <= bound[1] + tol]
    inside.sort(key=lambda k: (abs(k), k * value > 0))
    return inside if np.isfinite(bound).all() else inside[:1]


@given(joints, tolerances)
def test_nearest_image_is_the_one_of_fewest_turns(
    case: list[tuple[float, tuple[float, float], bool]], tol: float
) -> None:
    """Each value becomes its image inside the limits that is fewest turns away; without one the row is dropped."""
    q = np.array([value for value, _, _ in case])
    expected = [images(*joint, tol) for joint in case]
    got, inside = limits.nearest_image(q, np.array([b for _, b, _ in case]), np.array([t for _, _, t in case]), tol)
    assert inside == all(expected)
    if inside:
        np.testing.assert_array_equal(got, q + 2 * PI * np.array([k[0] for k in expected]))
        for value, (_, (lower, upper), _) in zip(got, case, strict=True):
            assert lower - tol <= value <= upper + tol
    else:
        assert np.isnan(got).all()


@given(joints, tolerances)
def test_turns_are_all_images_once(case: list[tuple[float, tuple[float, float], bool]], tol: float) -> None:
    """``turns`` gives every combination of images inside the limits, once."""
    q = np.array([value for value, _, _ in case])
    bound, turning = np.array([b for _, b, _ in case]), np.array([t for _, _, t in case])
    expected = [q + 2 * PI * np.array(k) for k in itertools.product(*[images(*joint, tol) for joint in case])]
    got = limits.turns(q[None], bound, turning, tol)
    np.testing.assert_array_equal(got.q[got.valid].reshape(-1, len(q)), np.array(expected).reshape(-1, len(q)))
    assert np.isnan(got.q[~got.valid]).all()


@given(joints, tolerances)
@example([(-0.03125, (0.0, 0.0), True)], -0.05)
def test_excess_is_the_least_over_all_images(case: list[tuple[float, tuple[float, float], bool]], tol: float) -> None:
    """The distance from the limits is that of the image that is least far out, with its side as the sign."""
    q = np.array([value for value, _, _ in case])
    bound, turning = np.array([b for _, b, _ in case]), np.array([t for _, _, t in case])
    image, out = limits.excess(q, bound, turning, tol)
    for i, (value, (lower, upper), turns) in enumerate(case):
        tried = [value + 2 * PI * k for k in (range(-MOST, MOST + 1) if turns else (0,))]
        least = min(max(lower - tol - v, v - upper - tol, 0.0) for v in tried)
        assert abs(out[i]) == pytest.approx(least, abs=1e-13)
        if out[i] > 0:
            assert out[i] == pytest.approx(image[i] - upper - tol, abs=1e-13)
        elif out[i] < 0:
            assert -out[i] == pytest.approx(lower - tol - image[i], abs=1e-13)
        else:
            assert lower - tol <= image[i] <= upper + tol


def test_images_on_a_limit_to_the_last_bit() -> None:
    """Without a tolerance, an image that rounds to the limit itself is inside, and one bit beyond is outside."""
    rng = np.random.default_rng(6)
    turning = np.array([True])
    for _ in range(300):
        value, k = rng.uniform(-PI, PI), float(rng.integers(-9, 10))
        limit = value + k * (2 * PI)
        q = np.array([[value]])
        beyond, before = np.nextafter(limit, np.inf), np.nextafter(limit, -np.inf)
        for inside in ((limit, limit), (limit, limit + 1.0), (limit - 1.0, limit)):
            assert limits.turns(q, np.array([inside]), turning, 0.0).q.tolist() == [[limit]]
        for outside in ((beyond, limit + 1.0), (limit - 1.0, before)):
            assert not limits.turns(q, np.array([outside]), turning, 0.0).valid.any()


def test_order_of_the_images() -> None:
    """Fewest turns first, and of as many turns to either side the image nearer to zero, also off centre."""
    turning, wide = np.array([True]), np.array([[-4.1 * PI, 4.1 * PI]])
    for value, expected in ((1.0, [0, -1, 1, -2]), (-1.0, [0, 1, -1, 2]), (0.1, [0, -1, 1, -2, 2])):
        got = limits.turns(np.array([[value]]), wide, turning).q[:, 0]
        np.testing.assert_array_equal(got, value + 2 * PI * np.array(expected))
    far = limits.turns(np.array([[1.0]]), np.array([[10.0, 30.0]]), turning).q[:, 0]
    np.testing.assert_array_equal(far, 1.0 + 2 * PI * np.array([2.0, 3.0, 4.0]))


def test_batches_are_their_rows() -> None:
    """Each row of a batch gives what it gives alone; a row of NaN stays NaN."""
    rng = np.random.default_rng(5)
    q = rng.uniform(-PI, PI, (3, 4, 5, 6))
    q[rng.random((3, 4, 5)) < 0.2] = np.nan
    bound = np.array([[-2 * PI, 2 * PI], [0, 2 * PI], [-1, 1], [-np.inf, np.inf], [-7, 7], [-0.5, 2]])
    turning = np.array([True, True, True, True, True, False])
    image, inside = limits.nearest_image(q, bound, turning)
    turned = limits.turns(q, bound, turning)
    every = turned.q.reshape(3, 4, 5, -1, 6)
    assert 0 < inside.sum() < inside.size
    for place in np.ndindex(3, 4, 5):
        one, alone = limits.nearest_image(q[place], bound, turning)
        np.testing.assert_array_equal(image[place], one)
        assert inside[place] == alone
        # The first column of a branch is its nearest image.
        np.testing.assert_array_equal(every[place][0], one)
        rows = every[place][~np.isnan(every[place]).any(axis=-1)]
        lone = limits.turns(q[place][None], bound, turning)
        np.testing.assert_array_equal(rows, lone.q[lone.valid])
    assert not inside[np.isnan(q).any(axis=-1)].any()


def test_rounded_limits_of_a_half_turn() -> None:
    """3.1416 allows a half turn on either side, 3.14 on neither."""
    turning = np.array([True])

    def all_of(value: float, bound: float) -> list[float]:
        return limits.turns(np.array([[value]]), np.array([[-bound, bound]]), turning).q[:, 0].tolist()

    assert all_of(PI, PI) == all_of(PI, 3.1416) == [PI, -PI]
    assert all_of(3.1415, PI) == [3.1415]
    assert all_of(3.1415, 3.1416) == [3.1415]
    assert np.isnan(all_of(PI, 3.14)).all()
    assert len(all_of(0.0, 2 * PI)) == len(all_of(0.0, 6.2832)) == 3
    assert len(all_of(0.0, 6.2831)) == 1
    assert len(all_of(1.0, 2 * PI)) == 2


def test_huge_limits_neither_overflow_nor_fill_the_memory() -> None:
    """Limits such as 1e16 or 1e308, written for no limit, neither overflow nor fill the memory."""
    turning = np.array([True, True])
    for huge in (1e16, 1e308):
        bound = np.array([[-huge, huge], [-1.0, 1.0]])
        q = np.array([0.5, 0.2])
        got, inside = limits.nearest_image(q, bound, turning)
        assert inside
        np.testing.assert_array_equal(got, q)
        with pytest.raises(UrdfIkError, match="without listing them"):
            limits.turns(q[None], bound, turning)
