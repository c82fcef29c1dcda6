"""Kernels of the subproblems of the closed forms: each undoes the turns that it was made of."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from kernel_samples import LENGTHS, PI, SIGNS, angles, apart, e, wrist

from urdf_ik._kernels import subproblems


@given(angles(), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_swing_to_offset_undoes_a_turn(turn: float, X: float, k: float) -> None:
    """A point (X, k) that was turned is turned back, with X's sign asked for; the margin is X squared."""
    x, y = e(turn) * X + np.array([-math.sin(turn), math.cos(turn)]) * k
    c, s, found, margin = subproblems.swing_to_offset(x, y, k, math.copysign(1.0, X))
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
    c, s, found, margin = subproblems.swing_to_offset(x, y, k, 1.0)
    assert margin == pytest.approx(radius**2 - k**2, rel=1e-9)
    assert margin < 0.0
    assert found == 0.0
    np.testing.assert_allclose([-s, c], sign * e(turn), atol=1e-12)


@given(angles(), angles(), LENGTHS, LENGTHS, SIGNS)
def test_elbow_undoes_two_links(q2: float, bend: float, a: float, b: float, side: float) -> None:
    """The end of two links is reached again; away from a straight elbow by the very angles that made it."""
    u = a * e(q2) + b * e(q2 + side * bend)
    c2, s2, c, s, margin = subproblems.elbow(*u, a, b, side, math.copysign(1.0, math.sin(bend)))
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
    assert subproblems.elbow(*(inside * e(turn)), a, b, 1.0, sign)[4] > 0.0
    _, _, c, s, margin = subproblems.elbow(*((far + share) * e(turn)), a, b, 1.0, sign)
    assert margin < 0.0 and (c, s) == (1.0, 0.0)
    if near > 0.01:
        _, _, c, s, margin = subproblems.elbow(*(share * near * e(turn)), a, b, 1.0, sign)
        assert margin < 0.0 and (c, s) == (-1.0, 0.0)


@pytest.mark.parametrize("reach", [1e-2, 1e-4, 1e-6, 1e-8])
def test_folded_elbow_of_equal_links_keeps_its_digits(reach: float) -> None:
    """With equal links almost folded, the end is reached to a share of its small distance."""
    for turn in (0.0, 0.7, -2.0):
        u = reach * e(turn)
        c2, s2, c, s, _ = subproblems.elbow(*u, 1.1, 1.1, 1.0, 1.0)
        bend = 2.0 * math.acos(reach / 2.2)  # isosceles triangle
        np.testing.assert_allclose([c, s], e(bend), atol=1e-15)
        np.testing.assert_allclose([c2, s2], e(turn - 0.5 * bend), atol=1e-15 / reach + 2e-15)


TWISTS = st.floats(0.4, PI - 0.4).flatmap(lambda twist: st.sampled_from([twist, -twist]))


@given(angles(), TWISTS, angles(), TWISTS, angles())
def test_wrist_steps_undo_three_turns(first: float, alpha: float, bend: float, beta: float, last: float) -> None:
    """The rotation is made again; away from aligned axes by the very angles that made it."""
    M = wrist(first, alpha, bend, beta, last)
    ca, sa, cb, sb = math.cos(alpha), math.sin(alpha), math.cos(beta), math.sin(beta)
    c, s, margin = subproblems.wrist_bend(*M[:, 2], ca, sa, cb, sb, math.copysign(1.0, math.sin(bend)))
    assert margin == pytest.approx(math.sin(bend) ** 2, abs=1e-13 / min(abs(sa), abs(sb)) ** 2)
    cf, sf, cl, sl, fixed, error = subproblems.wrist_turns(*M.T.ravel(), c, s, ca, sa, cb, sb, False, 1.0, 0.0)
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
    assert (subproblems.wrist_bend(*direction, *parts, 1.0)[2] > 0.0) == (low < polar < high)


@given(angles(), angles(), angles())
def test_aligned_wrist_keeps_the_sum(first: float, last: float, held: float) -> None:
    """With axes 4 and 6 in one line only the sum of their turns counts: whatever the first is held at, it is kept."""
    M = wrist(first, PI / 2.0, 0.0, -PI / 2.0, last)
    parts = 0.0, 1.0, 0.0, -1.0
    c, s, _ = subproblems.wrist_bend(*M[:, 2], *parts, 0.0)
    assert (c, s) == (1.0, 0.0)
    ch, sh = e(held)
    cf, sf, cl, sl, fixed, error = subproblems.wrist_turns(*M.T.ravel(), c, s, *parts, True, ch, sh)
    assert (cf, sf) == (ch, sh)
    assert max(fixed, error) < 1e-30
    assert apart(math.atan2(sf, cf) + math.atan2(sl, cl), first + last) < 1e-14
