"""The elimination's constant matrices and the bound on their error, on real joint vectors of the arm."""

import numpy as np
import pytest
from arms_general import calibrated_ur
from cases import described
from numpy.typing import NDArray

from urdf_ik.ik.families.parts.elimination import elimination_arm
from urdf_ik.ik.families.parts.inexact import inexact
from urdf_ik.ik.families.parts.written import Numbers
from urdf_ik.kinematics.chain import Chain

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def chain() -> Chain:
    """Three axes that are parallel but for some 1e-3 rad."""
    return described(calibrated_ur()).arm.chain


@pytest.fixture(scope="module")
def arm(chain: Chain) -> Numbers:
    """Its elimination."""
    return elimination_arm(chain, near=True)


def on_lines(R: Array, t: Array) -> Array:
    """How a motion acts on (1, p, p.p / 2, l, p x l, p.l, (p.p / 2) l - (p.l) p), from its action on 40 lines."""
    rng = np.random.default_rng(0)
    p, d = rng.normal(size=(2, 40, 3))

    def numbers(p: Array, d: Array) -> Array:
        h, along = 0.5 * (p * p).sum(1, keepdims=True), (p * d).sum(1, keepdims=True)
        return np.hstack([np.ones((40, 1)), p, h, d, np.cross(p, d), along, h * d - along * p])

    return np.asarray(np.linalg.lstsq(numbers(p, d), numbers(p @ R.T + t, d @ R.T), rcond=None)[0].T)


def left_over(chain: Chain, arm: Numbers, q: Array) -> float:
    """What the six equations leave at a joint vector, relative to the products of (1, cos, sin) that enter them."""
    variant = arm.counter
    first, back = int(variant.first[0]), bool(variant.reversed[0])
    T = chain.fk(q[None])[0]
    M = T @ np.vstack([arm.home_inverse, [0.0, 0.0, 0.0, 1.0]])
    R, t = M[:3, :3], arm.scale * (M[:3, 3] - arm.centre)
    loop = q
    if back:
        R, t, loop = R.T, -R.T @ t, q[::-1]
    A = variant.left[0].T[: 6 * 3**first] @ on_lines(R, t) @ variant.right[0][:, : 3 ** (3 - first)]
    A = A.reshape(6, 27)
    hidden, behind, kept = (np.array([1.0, np.cos(x), np.sin(x)]) for x in (loop[(first + k) % 6] for k in (5, 4, 3)))
    products = np.einsum("i,j,k->ijk", hidden, behind, kept).ravel()
    return float(np.linalg.norm(A @ products) / np.linalg.norm(products))


def test_the_equations_hold_at_joint_vectors_up_to_the_bound(chain: Chain, arm: Numbers) -> None:
    """The matrix errs by at most twice what the equations do, and both by little more than rounding."""
    rng, a = np.random.default_rng(1), arm.counter.inexact[0]
    reach = arm.scale * 2.0 * chain.size
    bound = a[0] + a[1] * reach + a[2] * reach**2
    assert bound < 1e-11
    # Lines as numbers err by some 1e-13 in the least-squares fit.
    assert max(left_over(chain, arm, rng.uniform(-np.pi, np.pi, 6)) for _ in range(20)) <= bound + 1e-12


@pytest.mark.parametrize("off", [1e-9, 1e-6, 1e-3])
def test_the_bound_holds_what_other_factors_leave(chain: Chain, arm: Numbers, off: float) -> None:
    """Factors that were changed leave more; the bound grows with it, and no further than it must by some orders."""
    rng = np.random.default_rng(2)
    left = arm.counter.left.copy()
    left[0] += off * rng.normal(size=left[0].shape)
    variant = arm.counter.but(left=left)
    cut = int(variant.first[0]), bool(variant.reversed[0])
    steps = arm.written.steps
    a, rest = inexact(steps, arm.centre, arm.scale, cut, left[0], variant.right[0])
    changed = arm.but(counter=variant)
    reach = arm.scale * 2.0 * chain.size
    bound = a[0] + a[1] * reach + a[2] * reach**2
    worst = max(left_over(chain, changed, rng.uniform(-np.pi, np.pi, 6)) for _ in range(20))
    assert 0.1 * off < worst <= bound < 1e6 * off
    # The rest holds what was changed, to the digits of a double.
    assert 0.1 * off < np.abs(rest.left).max() < 1e2 * off
    assert (rest.inexact < 1e-13 * off).all()


def test_the_rest_of_the_factors_is_rounding_and_leaves_that_of_twice_the_digits(arm: Numbers) -> None:
    """What rounding leaves out is below 1e-13, nothing where the factors are padded; the bound falls by 16 digits."""
    left, right, bound = arm.counter_rest.left, arm.counter_rest.right, arm.counter_rest.inexact
    assert 0.0 < np.abs(left).max() < 1e-13
    assert 0.0 < np.abs(right).max() < 1e-13
    padded = (arm.counter.left[0] == 0.0).all(axis=0)
    assert (left[:, padded] == 0.0).all()
    assert (bound < 1e-14 * arm.counter.inexact[0]).all()
