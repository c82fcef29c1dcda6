"""Steps of the core: the subproblems of the closed forms: each undoes the turns that it was made of."""

import math

import numpy as np
import pytest
from core_samples import LENGTHS, PI, SIGNS, angles, apart, e, step, wrist
from hypothesis import given
from hypothesis import strategies as st


@given(angles(), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_swing_to_offset_undoes_a_turn(turn: float, X: float, k: float) -> None:
    """A point (X, k) that was turned is turned back, with X's sign asked for; the margin is X squared."""
    x, y = e(turn) * X + np.array([-math.sin(turn), math.cos(turn)]) * k
    c, s, found, margin = step("swing_to_offset", x, y, k, math.copysign(1.0, X))
    size = X * X + k * k
    assert margin == pytest.approx(X * X, abs=1e-14 * (1.0 + size))
    assert found**2 == pytest.approx(X * X, abs=1e-14 * (1.0 + size))
    if size > 1e-6:
        np.testing.assert_allclose([c * found - s * k, s * found + c * k], [x, y], atol=3e-7)
    if abs(X) > 0.01:
        np.testing.assert_allclose([c, s], e(turn), atol=1e-11)
        np.testing.assert_allclose([c * found - s * k, s * found + c * k], [x, y], atol=1e-12)


@given(angles(), st.floats(0.1, 3.0), st.floats(0.01, 2.0), SIGNS)
def test_swing_to_offset_beyond_reach(turn: float, radius: float, beyond: float, sign: float) -> None:
    """A point closer to the axis than the offset gives a negative margin, and the angle that comes nearest."""
    x, y = radius * e(turn)
    k = sign * (radius + beyond)
    c, s, found, margin = step("swing_to_offset", x, y, k, 1.0)
    assert margin == pytest.approx(radius**2 - k**2, rel=1e-9)
    assert margin < 0.0
    assert found == 0.0
    np.testing.assert_allclose([-s, c], sign * e(turn), atol=1e-12)


@given(angles(), angles(), LENGTHS, LENGTHS, SIGNS)
def test_elbow_undoes_two_links(q2: float, bend: float, a: float, b: float, side: float) -> None:
    """The end of two links is reached again; away from a straight elbow by the very angles that made it."""
    u = a * e(q2) + b * e(q2 + side * bend)
    c2, s2, c, s, margin = step("elbow", *u, a, b, side, math.copysign(1.0, math.sin(bend)))
    assert margin > -1e-13 * max(a / b, b / a) ** 2
    again = np.array([a * c2 + b * (c2 * c - side * s2 * s), a * s2 + b * (s2 * c + side * c2 * s)])
    np.testing.assert_allclose(again, u, atol=2e-7 * (a + b) if abs(math.sin(bend)) < 0.01 else 1e-11 * (a + b))
    if abs(math.sin(bend)) > 0.01 and math.hypot(*u) > 0.01:
        np.testing.assert_allclose([c2, s2], e(q2), atol=1e-9)
        np.testing.assert_allclose([c, s], e(bend), atol=1e-9)
        assert margin == pytest.approx(math.sin(bend) ** 2, rel=1e-6)


@given(angles(), LENGTHS, LENGTHS, st.floats(0.02, 0.98), SIGNS)
def test_elbow_margin_tells_reach(turn: float, a: float, b: float, share: float, sign: float) -> None:
    """Between folded and stretched the margin is positive, shorter and longer negative, and there c is +-1."""
    near, far = abs(a - b), a + b
    inside = near + share * (far - near)
    assert step("elbow", *(inside * e(turn)), a, b, 1.0, sign)[4] > 0.0
    _, _, c, s, margin = step("elbow", *((far + share) * e(turn)), a, b, 1.0, sign)
    assert margin < 0.0 and (c, s) == (1.0, 0.0)
    if near > 0.01:
        _, _, c, s, margin = step("elbow", *(share * near * e(turn)), a, b, 1.0, sign)
        assert margin < 0.0 and (c, s) == (-1.0, 0.0)


@pytest.mark.parametrize("reach", [1e-2, 1e-4, 1e-6, 1e-8])
def test_folded_elbow_of_equal_links_keeps_its_digits(reach: float) -> None:
    """With equal links almost folded, the end is reached to a share of its small distance."""
    for turn in (0.0, 0.7, -2.0):
        u = reach * e(turn)
        c2, s2, c, s, _ = step("elbow", *u, 1.1, 1.1, 1.0, 1.0)
        bend = 2.0 * math.acos(reach / 2.2)  # isosceles triangle
        np.testing.assert_allclose([c, s], e(bend), atol=1e-15)
        np.testing.assert_allclose([c2, s2], e(turn - 0.5 * bend), atol=1e-15 / reach + 2e-15)


TWISTS = st.floats(0.4, PI - 0.4).flatmap(lambda twist: st.sampled_from([twist, -twist]))


@given(angles(), TWISTS, angles(), TWISTS, angles())
def test_wrist_steps_undo_three_turns(first: float, alpha: float, bend: float, beta: float, last: float) -> None:
    """The rotation is made again; away from aligned axes by the very angles that made it."""
    M = wrist(first, alpha, bend, beta, last)
    ca, sa, cb, sb = math.cos(alpha), math.sin(alpha), math.cos(beta), math.sin(beta)
    c, s, margin = step("wrist_bend", *M[:, 2], ca, sa, cb, sb, math.copysign(1.0, math.sin(bend)))
    assert margin == pytest.approx(math.sin(bend) ** 2, abs=1e-13 / min(abs(sa), abs(sb)) ** 2)
    asked = *M.T.ravel(), c, s, ca, sa, cb, sb
    cf, sf, cl, sl, fixed, error = step("wrist_turns", *asked, 0.0, 1.0, 0.0)
    if fixed == 0.0:  # only the sum of the turns matters: the first is the caller's to choose
        cf, sf, cl, sl, fixed, error = step("wrist_turns", *asked, 1.0, *e(0.3))
    again = wrist(math.atan2(sf, cf), alpha, math.atan2(s, c), beta, math.atan2(sl, cl))
    np.testing.assert_allclose(again, M, atol=1e-11 if abs(math.sin(bend)) > 1e-3 else 3e-6)
    assert error < 1e-11
    if abs(math.sin(bend)) > 0.05 and fixed > 0.01:
        for given_, expected in zip(((c, s), (cf, sf), (cl, sl)), (bend, first, last), strict=True):
            np.testing.assert_allclose(np.array(given_) / math.hypot(*given_), e(expected), atol=1e-10)


@given(TWISTS, TWISTS, angles(), st.floats(0.0, PI))
def test_wrist_margin_tells_reach(alpha: float, beta: float, around: float, polar: float) -> None:
    """Axis 6 reaches directions between |alpha - beta| and alpha + beta from axis 4; there the margin is positive."""
    a, b = abs(alpha), abs(beta)
    low, high = abs(a - b), min(a + b, 2.0 * PI - a - b)
    if min(abs(polar - low), abs(polar - high)) < 1e-3:
        return
    direction = [math.sin(polar) * math.cos(around), math.sin(polar) * math.sin(around), math.cos(polar)]
    parts = math.cos(alpha), math.sin(alpha), math.cos(beta), math.sin(beta)
    assert (step("wrist_bend", *direction, *parts, 1.0)[2] > 0.0) == (low < polar < high)


@given(angles(), angles(), angles())
def test_aligned_wrist_keeps_the_sum(first: float, last: float, held: float) -> None:
    """With axes 4 and 6 in one line only the sum of their turns counts: whatever the first is held at, it is kept."""
    M = wrist(first, PI / 2.0, 0.0, -PI / 2.0, last)
    parts = 0.0, 1.0, 0.0, -1.0
    c, s, _ = step("wrist_bend", *M[:, 2], *parts, 0.0)
    assert (c, s) == (1.0, 0.0)
    ch, sh = e(held)
    cf, sf, cl, sl, fixed, error = step("wrist_turns", *M.T.ravel(), c, s, *parts, 1.0, ch, sh)
    assert (cf, sf) == (ch, sh)
    assert max(fixed, error) < 1e-30
    assert apart(math.atan2(sf, cf) + math.atan2(sl, cl), first + last) < 1e-14


# ---------------------------------------------------------------- two linked angles, a free one


def test_linked_roots_have_a_common_angle() -> None:
    """At every root the two affine functions are cosine and sine of one angle, and the planted angle is among them."""
    rng = np.random.default_rng(1)
    for _ in range(200):
        u, v = rng.uniform(-math.pi, math.pi, 2)
        cc, cs, sc, ss = rng.normal(size=4)
        c0 = math.cos(u) - cc * math.cos(v) - cs * math.sin(v)
        s0 = math.sin(u) - sc * math.cos(v) - ss * math.sin(v)
        count, *rows = step("linked_roots", c0, cc, cs, s0, sc, ss)
        found, roots = int(count), np.array(rows).reshape(4, 2)
        assert found % 2 == 0
        for c, s in roots[:found]:
            assert abs(math.hypot(c0 + cc * c + cs * s, s0 + sc * c + ss * s) - 1.0) < 1e-3
        planted = np.array([math.cos(v), math.sin(v)])
        assert np.linalg.norm(roots[:found] - planted, axis=1).min() < 1e-6


@pytest.mark.parametrize("delta", [1e-5, 1e-6, 1e-7, 1e-8])
def test_sharpened_roots_keep_their_digits(delta: float) -> None:
    """Where cos u is within delta^2 of its extreme at 1, the root comes back to far better than delta."""
    rng = np.random.default_rng(2)
    for _ in range(50):
        at = rng.uniform(-math.pi, math.pi)
        x, m, gain = delta * rng.uniform(-1.0, 1.0), delta**2 * rng.uniform(0.5, 1.5), rng.uniform(0.3, 0.8)
        cosine = math.sqrt(1.0 - m)
        w = 2.0 * math.sin(0.5 * x) ** 2
        # cos u = cosine - gain w, and sin u affine with a slope that makes x a root.
        sine = math.sqrt(m + 2.0 * cosine * gain * w - gain * gain * w * w)
        g = rng.uniform(1.5, 2.5)
        b = sine - g * math.sin(x)
        roots = np.array([[math.cos(at), math.sin(at)], [math.cos(at), math.sin(at)], [0.0, 0.0], [0.0, 0.0]])
        sc, ss = -g * math.sin(at), g * math.cos(at)
        numbers = math.cos(at), math.sin(at), cosine, m, -gain, b, sc, ss, 2.0, *roots.ravel()
        sharpened = np.array(step("sharpen_roots", *numbers)[1:]).reshape(4, 2)
        found = [math.cos(at) * s - math.sin(at) * c for c, s in sharpened[:2]]
        assert min(abs(y - x) for y in found) < 1e-6 * delta + 1e-15
