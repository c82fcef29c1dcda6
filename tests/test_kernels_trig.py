"""Kernels of angles and of trigonometric polynomials, against formulas written out and planted roots."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from kernel_samples import PI, angles, apart, interpreted, with_roots
from numpy.typing import NDArray

from urdf_ik._kernels import polynomials, trig

Array = NDArray[np.float64]
Kernel = Callable[..., Any]


# ---------------------------------------------------------------- angles

# On both sides of tan(pi / 8), where the kernel changes its formula, and far from one.
MAGNITUDES = [0.0, 1e-150, 1e-20, 1e-9, 1e-3, 0.3, 0.4142135623730950, 0.4142135623730951, 1.0, 3.0, 1e150]


@pytest.mark.parametrize("as_run", [trig.atan2, interpreted(trig.atan2)], ids=["compiled", "interpreted"])
def test_atan2(as_run: Kernel) -> None:
    """In all quadrants, on the axes and for any ratio it is math.atan2 to 2 units in the last place."""
    rng = np.random.default_rng(0)
    x, y = rng.normal(size=(2, 20_000)) * 10.0 ** rng.uniform(-8, 8, (2, 20_000))
    round_and_round = np.linspace(-PI, PI, 5001)
    points = [
        *zip(y.tolist(), x.tolist(), strict=True),
        *zip(np.sin(round_and_round).tolist(), np.cos(round_and_round).tolist(), strict=True),
        *((s * a, t * b) for a in MAGNITUDES for b in MAGNITUDES if a or b for s in (1, -1) for t in (1, -1)),
    ]
    for y, x in points:
        given, expected = as_run(y, x), math.atan2(y, x)
        assert abs(given - expected) <= 2.0 * math.ulp(expected), (y, x)
        assert math.copysign(1.0, given) == math.copysign(1.0, y)
        assert abs(given) <= PI


def test_atan2_of_zeros() -> None:
    """The angle of nothing is zero; the negative x axis is at pi from above and at -pi from below."""
    assert [trig.atan2(0.0, x) for x in (0.0, -0.0, 1.0)] == [0.0, 0.0, 0.0]
    assert (trig.atan2(0.0, -1.0), trig.atan2(-0.0, -1.0)) == (PI, -PI)
    assert (trig.atan2(1.0, 0.0), trig.atan2(-1.0, -0.0)) == (PI / 2, -PI / 2)


@given(angles(-3.0 * PI + 1e-9, 3.0 * PI - 1e-9))
def test_wrap_is_the_same_angle_in_range(a: float) -> None:
    """Up to a turn outside, the angle moves by whole turns into (-pi, pi], and stays there when wrapped again."""
    for as_run in (trig.wrap, interpreted(trig.wrap)):
        wrapped = as_run(a)
        assert -PI < wrapped <= PI
        turns = (a - wrapped) / (2.0 * PI)
        assert abs(turns - round(turns)) < 1e-15
        assert as_run(wrapped) == wrapped


def test_wrap_at_half_turns() -> None:
    """Both half turns are +pi; their neighbours inside stay, those outside come round to the other side."""
    inside, outside = math.nextafter(PI, 0.0), math.nextafter(PI, 4.0)
    assert [trig.wrap(a) for a in (PI, -PI, inside, -inside)] == [PI, PI, inside, -inside]
    assert trig.wrap(outside) == pytest.approx(-PI, abs=1e-15) and trig.wrap(outside) > -PI
    assert trig.wrap(-outside) == pytest.approx(PI, abs=1e-15) and trig.wrap(-outside) <= PI
    assert math.isnan(trig.wrap(math.nan))


# ---------------------------------------------------------------- trigonometric polynomials


def value(coefficients: Array, t: Array | float) -> Array:
    """The trigonometric polynomial at t."""
    basis = np.array([np.ones_like(t), np.cos(t), np.sin(t), np.cos(np.multiply(2, t)), np.sin(np.multiply(2, t))])
    return np.tensordot(coefficients, basis, 1)


def roots_of(coefficients: Array) -> Array:
    """Angles (k,) that the kernel finds."""
    rows = np.full((4, 2), np.nan)
    count = polynomials.trigonometric_roots(*coefficients.tolist(), rows)
    assert np.isnan(rows[count:]).all()
    np.testing.assert_allclose(np.hypot(*rows[:count].T), 1.0, atol=1e-15)
    return np.arctan2(rows[:count, 1], rows[:count, 0])


@pytest.mark.parametrize("seed", range(60))
def test_planted_roots(seed: int) -> None:
    """All four planted roots are found, each once, in ascending order; the polynomial vanishes there to rounding."""
    rng = np.random.default_rng(seed)
    while True:
        m1, m2, d1, d2 = *rng.uniform(-PI, PI, 2), *rng.uniform(0.05, PI - 0.05, 2)
        planted = np.array([m1 - d1, m1 + d1, m2 - d2, m2 + d2])
        if min(apart(planted[i], planted[j]) for i in range(4) for j in range(i)) > 0.05:
            break
    coefficients = with_roots(m1, d1, m2, d2) * 10.0 ** rng.uniform(-6, 6)
    found = roots_of(coefficients)
    assert len(found) == 4
    assert (np.diff(found) > 0.0).all()
    assert all(apart(found, root).min() < 1e-11 for root in planted)
    assert np.abs(value(coefficients, found)).max() < 4e-15 * np.abs(coefficients).sum()


@pytest.mark.parametrize("seed", range(20))
def test_two_roots_or_none(seed: int) -> None:
    """A factor that stays away from zero has no angle to add; two such leave none at all."""
    rng = np.random.default_rng(seed)
    m1, m2, d1 = *rng.uniform(-PI, PI, 2), rng.uniform(0.1, PI - 0.1)
    lift = float(np.arccosh(rng.uniform(1.01, 3.0)))
    c1, c2 = math.cos(d1), math.cosh(lift)
    coefficients = with_roots(m1, d1, m2, 0.0)
    # Raise the second factor, 1 - cos(t - m2), by c2 - 1.
    coefficients[:3] += (c2 - 1.0) * np.array([c1, -math.cos(m1), -math.sin(m1)])
    found = roots_of(coefficients)
    assert len(found) == 2
    assert all(apart(found, root).min() < 1e-12 for root in (m1 - d1, m1 + d1))
    nowhere = with_roots(m1, 0.0, m2, 0.0)
    nowhere[:3] += (c2 - 1.0) * np.array([2.0, -math.cos(m1) - math.cos(m2), -math.sin(m1) - math.sin(m2)])
    nowhere[0] += (c2 - 1.0) ** 2
    assert (value(nowhere, np.linspace(-PI, PI, 200)) > 0.0).all()
    assert len(roots_of(nowhere)) == 0


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("touching", [0.0, PI])
def test_double_roots(seed: int, touching: float) -> None:
    """Where the polynomial touches zero both roots are given, to half the digits, though rounding may part them."""
    rng = np.random.default_rng(seed)
    m1, m2, d2 = *rng.uniform(-PI, PI, 2), rng.uniform(0.3, PI - 0.3)
    double = m1 + touching
    if min(apart(double, m2 - d2), apart(double, m2 + d2)) < 0.1:
        m2 += 0.7
    found = roots_of(with_roots(m1, touching, m2, d2))
    assert len(found) == 4
    assert (apart(found, double) < 3e-7).sum() == 2
    assert all((apart(found, root) < 1e-7).sum() == 1 for root in (m2 - d2, m2 + d2))


def test_fewer_harmonics() -> None:
    """Without a second harmonic there are two roots or none, without anything there is nothing to find."""
    found = roots_of(np.array([math.cos(0.4), -math.cos(1.0), -math.sin(1.0), 0.0, 0.0]))
    np.testing.assert_allclose(found, [0.6, 1.4], atol=1e-14)
    assert len(roots_of(np.array([2.0, 1.0, 0.0, 0.0, 0.0]))) == 0
    assert len(roots_of(np.zeros(5))) == 0
    # A second harmonic just above or below the rounding of the others makes no difference.
    for small in (1e-12, 1e-13, 1e-15, 1e-17):
        found = roots_of(np.array([math.cos(0.4), -math.cos(1.0), -math.sin(1.0), small, -small]))
        np.testing.assert_allclose(found, [0.6, 1.4], atol=1e-11)


def test_root_gap() -> None:
    """The squared chord to the nearest other root; a root alone is the diameter away."""
    at = np.array([0.3, 1.0, 1.1, -2.0])
    rows = np.column_stack([np.cos(at), np.sin(at)])
    for as_run in (polynomials.root_gap, interpreted(polynomials.root_gap)):
        given = [as_run(rows, 4, i) for i in range(4)]
        np.testing.assert_allclose(given, [4 * math.sin(g / 2) ** 2 for g in (0.7, 0.1, 0.1, 2.3)], rtol=1e-12)
        assert as_run(rows, 1, 0) == 4.0
