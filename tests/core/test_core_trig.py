"""Steps of the core: angles and of trigonometric polynomials, against formulas written out and planted roots."""

import math
import re

import core_steps
import numpy as np
import pytest
from core_samples import PI, angles, apart, step, with_roots
from hypothesis import given
from numpy.typing import NDArray

from urdf_ik.cmake import core

Array = NDArray[np.float64]


# ---------------------------------------------------------------- angles

# On both sides of tan(pi / 8), where the step changes its formula, and far from one.
MAGNITUDES = [0.0, 1e-150, 1e-20, 1e-9, 1e-3, 0.3, 0.4142135623730950, 0.4142135623730951, 1.0, 3.0, 1e150]


@pytest.mark.parametrize("side_by_side", [False, True], ids=["one", "block"])
def test_atan2(side_by_side: bool) -> None:
    """In all quadrants, on the axes and for any ratio it is math.atan2 to 2 units in the last place."""
    rng = np.random.default_rng(0)
    x, y = rng.normal(size=(2, 20_000)) * 10.0 ** rng.uniform(-8, 8, (2, 20_000))
    round_and_round = np.linspace(-PI, PI, 5001)
    points = [
        *zip(y.tolist(), x.tolist(), strict=True),
        *zip(np.sin(round_and_round).tolist(), np.cos(round_and_round).tolist(), strict=True),
        *((s * a, t * b) for a in MAGNITUDES for b in MAGNITUDES if a or b for s in (1, -1) for t in (1, -1)),
    ]
    answers = core_steps.step("atan2", np.array(points), side_by_side=side_by_side)[:, 0]
    for (y, x), answer in zip(points, answers.tolist(), strict=True):
        expected = math.atan2(y, x)
        assert abs(answer - expected) <= 2.0 * math.ulp(expected), (y, x)
        assert math.copysign(1.0, answer) == math.copysign(1.0, y)
        assert abs(answer) <= PI


def test_no_digit_depends_on_the_c_library() -> None:
    """The functions whose last digits differ between C libraries are called in one file, for angles beyond FAR."""
    called = re.compile(
        r"(?:__builtin_|std::)(?:a?(?:sin|cos|tan)h?|atan2|sincos|exp2?|expm1|log|log2|log10|log1p|pow|cbrt|hypot)\("
    )
    once = ("self_motion", "library", "solvers", "bindings")
    units = [path for path in core().rglob("*.?pp") if path.parent.name not in once]
    assert len(units) > 80
    calls = {str(path.relative_to(core())): called.findall(path.read_text()) for path in units}
    assert {name: sorted(set(found)) for name, found in calls.items() if found} == {
        "numbers/trig.hpp": ["__builtin_cos(", "__builtin_sin("]
    }


def wrap(a: float) -> float:
    """The step for one angle."""
    return step("wrap", a)[0]


@given(angles(-3.0 * PI + 1e-9, 3.0 * PI - 1e-9))
def test_wrap_is_the_same_angle_in_range(a: float) -> None:
    """Up to a turn outside, the angle moves by whole turns into (-pi, pi], and stays there when wrapped again."""
    wrapped = wrap(a)
    assert -PI < wrapped <= PI
    turns = (a - wrapped) / (2.0 * PI)
    assert abs(turns - round(turns)) < 1e-15
    assert wrap(wrapped) == wrapped


def test_wrap_at_half_turns() -> None:
    """Both half turns are +pi; their neighbours inside stay, those outside come round to the other side."""
    inside, outside = math.nextafter(PI, 0.0), math.nextafter(PI, 4.0)
    assert [wrap(a) for a in (PI, -PI, inside, -inside)] == [PI, PI, inside, -inside]
    assert wrap(outside) == pytest.approx(-PI, abs=1e-15) and wrap(outside) > -PI
    assert wrap(-outside) == pytest.approx(PI, abs=1e-15) and wrap(-outside) <= PI
    assert math.isnan(wrap(math.nan))


# ---------------------------------------------------------------- trigonometric polynomials


def value(coefficients: Array, t: Array | float) -> Array:
    """The trigonometric polynomial at t."""
    basis = np.array([np.ones_like(t), np.cos(t), np.sin(t), np.cos(np.multiply(2, t)), np.sin(np.multiply(2, t))])
    return np.tensordot(coefficients, basis, 1)


def roots_of(coefficients: Array) -> Array:
    """Angles (k,) that the step finds."""
    found = step("trigonometric_roots", *coefficients.tolist())
    count, rows = int(found[0]), np.array(found[1:]).reshape(4, 2)
    np.testing.assert_allclose(np.hypot(*rows[:count].T), 1.0, atol=1e-15)
    return np.arctan2(rows[:count, 1], rows[:count, 0])


def test_planted_roots() -> None:
    """All four planted roots are found, each once, in ascending order; the polynomial vanishes there to rounding."""
    for seed in range(60):
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


def test_two_roots_or_none() -> None:
    """A factor that stays away from zero has no angle to add; two such leave none at all."""
    for seed in range(20):
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


@pytest.mark.parametrize("touching", [0.0, PI])
def test_double_roots(touching: float) -> None:
    """Where the polynomial touches zero both roots are given, to half the digits, though rounding may part them."""
    for seed in range(20):
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


# ---------------------------------------------------------------- cosine and sine, roots and quotients


def test_cosine_and_sine() -> None:
    """On the range that solvers use, both are NumPy's to one unit in the last place of 1, alone and in blocks."""
    a = np.concatenate([np.linspace(-1.1 * PI, 1.1 * PI, 20_001), np.arange(-4, 5) * PI / 4.0])
    for side_by_side in (False, True):
        found = core_steps.step("cos_sin", a[:, None], side_by_side=side_by_side)
        np.testing.assert_allclose(found, np.column_stack([np.cos(a), np.sin(a)]), rtol=0.0, atol=2.3e-16)


def test_inverses_and_roots() -> None:
    """1 / x, 1 / sqrt(x) and sqrt(x) hold to two units in the last place over many magnitudes; sqrt(0) is 0."""
    x = 10.0 ** np.random.default_rng(3).uniform(-30, 30, 5001)
    for side_by_side in (False, True):
        found = core_steps.step("inverse", x[:, None], side_by_side=side_by_side)
        np.testing.assert_allclose(found, np.column_stack([1.0 / x, 1.0 / np.sqrt(x), np.sqrt(x)]), rtol=4.5e-16)
        assert core_steps.step("inverse", np.zeros((1, 1)), side_by_side=side_by_side)[0, 2] == 0.0
