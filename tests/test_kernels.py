"""Kernels, compiled and interpreted, against formulas written out, NumPy's decompositions and planted answers."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from arms import KINDS, X, Z, industrial, random_arm, rotation, ur_like
from hypothesis import given
from hypothesis import strategies as st
from numba.core import config
from numpy.typing import NDArray

from urdf_ik import families, urdf
from urdf_ik._kernels import compile as compiler
from urdf_ik._kernels import layout, lines, polynomials, refine, screws, subproblems, target, trig
from urdf_ik.chain import Chain
from urdf_ik.structure import analyse
from urdf_ik.tolerances import DEFAULT

Array = NDArray[np.float64]
Kernel = Callable[..., Any]
PI = math.pi


def interpreted(kernel: Kernel) -> Kernel:
    """The Python function behind a compiled kernel; itself where Numba is switched off."""
    return getattr(kernel, "py_func", kernel)


def numbers_of(urdf_text: str) -> tuple[Array, Chain]:
    """The one array that the kernels of an arm take, and its chain."""
    chain = Chain.from_urdf(urdf.read(urdf_text), "base", "tool")
    plan = families.choose(analyse(chain), chain)
    assert plan is not None
    return plan.arm, chain


def angles(low: float = -PI, high: float = PI) -> st.SearchStrategy[float]:
    """Angles [rad] with no preference for subnormal numbers."""
    return st.floats(low, high, allow_subnormal=False)


LENGTHS = st.floats(0.05, 3.0)
SIGNS = st.sampled_from([1.0, -1.0])


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


def with_roots(m1: float, d1: float, m2: float, d2: float) -> Array:
    """Coefficients (1, cos, sin, cos 2, sin 2) of (cos d1 - cos(t - m1)) (cos d2 - cos(t - m2)), roots m +- d."""
    c1, c2 = math.cos(d1), math.cos(d2)
    return np.array(
        [
            c1 * c2 + 0.5 * math.cos(m1 - m2),
            -c1 * math.cos(m2) - c2 * math.cos(m1),
            -c1 * math.sin(m2) - c2 * math.sin(m1),
            0.5 * math.cos(m1 + m2),
            0.5 * math.sin(m1 + m2),
        ]
    )


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


def apart(a: Array | float, b: Array | float) -> Array:
    """Distance between angles, round the circle."""
    return np.abs((np.subtract(a, b) + PI) % (2.0 * PI) - PI)


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


# ---------------------------------------------------------------- subproblems


def e(angle: float) -> Array:
    """Unit vector (2,)."""
    return np.array([math.cos(angle), math.sin(angle)])


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


def wrist(first: float, alpha: float, bend: float, beta: float, last: float) -> Array:
    """Rz(first) Rx(alpha) Rz(bend) Rx(beta) Rz(last)."""
    return (
        rotation(Z, first) @ rotation(X, alpha) @ rotation(Z, bend) @ rotation(X, beta) @ rotation(Z, last)
    )


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


# ---------------------------------------------------------------- targets


@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-8, 1e-5, 1e-2])
def test_project_rotation_gives_the_nearest(size: float) -> None:
    """The rotation becomes the orthogonal factor of its singular value decomposition; the rest of the pose stays."""
    rng = np.random.default_rng(1)
    for _ in range(10):
        T = np.eye(4)
        T[:3, :3] = rotation(rng.normal(size=3), rng.uniform(0, PI)) + size * rng.normal(size=(3, 3))
        T[:3, 3] = rng.normal(size=3)
        left, _, right = np.linalg.svd(T[:3, :3])
        out = np.full((4, 4), np.nan)
        target.project_rotation(T, out)
        np.testing.assert_allclose(out[:3, :3], left @ right, atol=2e-15)
        np.testing.assert_array_equal(out[:, 3], T[:, 3])
        np.testing.assert_array_equal(out[3], T[3])


def test_targets_in_frame_1() -> None:
    """Blocks and single poses arrive alike: base and tool undone, and the defect of the rotation measured."""
    arm, chain = numbers_of(industrial().urdf)
    T = chain.fk(np.random.default_rng(2).uniform(-PI, PI, (5, 6)))
    T[3, :3, :3] *= 1.0 + 1e-7
    base_rotation, tool_rotation = arm[:9].reshape(3, 3), arm[12:21].reshape(3, 3)
    W, alone = np.full((layout.ROWS, layout.BLOCK), np.nan), np.empty(12)
    target.load(W, T, 1, 4, arm)
    for column, pose in enumerate(T[1:]):
        target.to_frame_1(pose, arm, alone)
        expected = base_rotation @ pose[:3, :3] @ tool_rotation
        np.testing.assert_allclose(alone[:9].reshape(3, 3), expected, atol=1e-14)
        point = pose[:3, :3] @ arm[21:24] + pose[:3, 3]
        np.testing.assert_allclose(alone[9:], base_rotation @ (point - arm[9:12]), atol=1e-14)
        np.testing.assert_allclose(W[:12, column], alone, atol=1e-14)
        defect = np.abs(pose[:3, :3].T @ pose[:3, :3] - np.eye(3)).max()
        assert W[12, column] == pytest.approx(defect, abs=1e-15)
        assert target.check_target(pose) == pytest.approx(defect, abs=1e-15)
    assert np.isnan(W[:13, 4:]).all()


def spoilt(place: tuple[int, int], number: float) -> Array:
    """A pose with one number replaced."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation(np.array([1.0, 2.0, 3.0]), 0.5), [0.3, 0.2, 0.1]
    T[place] = number
    return T


@pytest.mark.parametrize("place", list(np.ndindex(4, 4)))
@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_defect_of_what_is_not_finite(place: tuple[int, int], number: float) -> None:
    """One NaN or infinity anywhere makes the defect exceed every tolerance, in a block and alone."""
    arm, _ = numbers_of(industrial().urdf)
    W = np.empty((layout.ROWS, layout.BLOCK))
    with np.errstate(all="ignore"):  # interpreted, the kernels are NumPy's arithmetic
        target.load(W, spoilt(place, number)[None], 0, 1, arm)
        alone = target.check_target(spoilt(place, number))
    assert not W[12, 0] <= 1e300
    assert not alone <= 1e300


def test_defect_of_reflections_and_last_rows() -> None:
    """A reflection has an infinite defect though it is orthogonal; a last row counts by how far it is off."""
    arm, _ = numbers_of(industrial().urdf)
    W = np.empty((layout.ROWS, layout.BLOCK))
    turned_in = spoilt((3, 3), 1.0) @ np.diag([1.0, -1.0, 1.0, 1.0])
    for T, defect in (
        (turned_in, math.inf),
        (spoilt((3, 1), 0.25), 0.25),
        (spoilt((3, 3), 0.5), 0.5),
        (np.zeros((4, 4)), math.inf),
    ):
        target.load(W, T[None], 0, 1, arm)
        assert W[12, 0] == target.check_target(T) == defect


# ---------------------------------------------------------------- lines


def test_lines_move_linearly() -> None:
    """The numbers of a moved line are the motion's matrix times those of the line, and motions compose."""
    rng = np.random.default_rng(3)
    G = np.tile(np.eye(4), (2, 1, 1))
    U = np.empty((2, lines.LINE, lines.LINE))
    for i in range(2):
        G[i, :3, :3], G[i, :3, 3] = rotation(rng.normal(size=3), rng.uniform(0, PI)), rng.normal(size=3)
        lines.line_motion(G[i], U[i])
    both = np.empty((lines.LINE, lines.LINE))
    lines.line_motion(G[0] @ G[1], both)
    np.testing.assert_allclose(both, U[0] @ U[1], atol=1e-13)
    point, along = rng.normal(size=(2, 3))
    before, after = np.empty((2, lines.LINE))
    lines.line_vector(*point, *along, before)
    lines.line_vector(*(G[0, :3, :3] @ point + G[0, :3, 3]), *(G[0, :3, :3] @ along), after)
    np.testing.assert_allclose(U[0] @ before, after, atol=1e-13)


# ---------------------------------------------------------------- Newton's method

ARMS = {"wrist": industrial().urdf, "parallel": ur_like().urdf, "oblique": random_arm("wrist, general", 1).urdf}


def start_near(q: Array, distance: float) -> Array:
    """A joint vector at that distance [rad] from another."""
    direction = np.random.default_rng(5).normal(size=6)
    return q + distance * direction / np.linalg.norm(direction)


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("method", ["refine", "newton"])
def test_convergence_is_quadratic(name: str, method: str) -> None:
    """One step leaves an error that falls a hundredfold where the distance falls tenfold, down to rounding."""
    arm, chain = numbers_of(ARMS[name])
    q = np.array([0.4, -0.7, 1.1, 0.6, 0.9, -0.3])
    T = chain.fk(q)

    def left_after(rounds: int, distance: float) -> float:
        start = start_near(q, distance)
        steps = (rounds, 0.0, 60) if method == "refine" else (rounds,)
        return float(getattr(refine, method)(arm, T, start, *steps))

    errors = [left_after(1, distance) for distance in (1e-2, 1e-3, 1e-4, 1e-5)]
    for before, after in zip(errors, errors[1:], strict=False):
        assert 50.0 < before / after < 200.0
    assert errors[0] < 1e-3
    assert left_after(6, 0.1) < 3e-15


@pytest.mark.parametrize("name", ARMS)
def test_refine_never_ends_worse_than_it_began(name: str) -> None:
    """Whatever the start and the target, the vector returned has the error returned, and none larger than the start's.

    At singular vectors and for poses out of reach nothing becomes infinite.
    """
    arm, chain = numbers_of(ARMS[name])
    rng = np.random.default_rng(6)
    twist = np.empty(6)
    far = np.eye(4)
    far[:3, 3] = 10.0
    for start in (*rng.uniform(-PI, PI, (6, 6)), np.zeros(6), np.full(6, PI / 2.0)):
        for T in (chain.fk(rng.uniform(-PI, PI, 6)), chain.fk(start), far):
            q = start.copy()
            left = refine.refine(arm, T, q, 15, 1e-15, 60)
            assert np.isfinite(q).all()
            assert (np.abs(q) <= PI).all()
            assert left == refine.pose_error(T, chain.fk(q), 1.0 / chain.size, twist)
            assert left <= refine.pose_error(T, chain.fk(start), 1.0 / chain.size, twist)


def test_pose_error_is_the_twist() -> None:
    """For a small motion the error is Pinocchio's logarithm of the rotation, and the shift as a share of the size."""
    rng = np.random.default_rng(7)
    for angle in (1e-2, 1e-4, 1e-7):
        T, wanted = np.eye(4), np.eye(4)
        T[:3, :3], T[:3, 3] = rotation(rng.normal(size=3), 2.0), rng.normal(size=3)
        turn = rotation(rng.normal(size=3), angle)
        wanted[:3, :3], wanted[:3, 3] = turn @ T[:3, :3], T[:3, 3] + angle * rng.normal(size=3)
        twist = np.empty(6)
        worst = refine.pose_error(wanted, T, 0.5, twist)
        np.testing.assert_allclose(twist[:3], 0.5 * (wanted - T)[:3, 3], atol=1e-16)
        np.testing.assert_allclose(twist[3:], pin.log3(turn), atol=angle**3 + 1e-15)
        assert worst == np.abs(twist).max()


@pytest.mark.parametrize("angle", [1.8, 2.5, PI])
def test_pose_error_of_a_large_turn(angle: float) -> None:
    """From about a right angle on the sine falls again: such a turn counts as far off, half a turn above all."""
    T = np.eye(4)
    T[:3, :3] = rotation(np.array([1.0, -2.0, 0.5]), angle)
    assert refine.pose_error(T, np.eye(4), 1.0, np.empty(6)) == 2.0


@pytest.mark.parametrize("n", [5, 6, 7])
@pytest.mark.parametrize("damping", [1e-12, 1e-6, 1e-2, 1.0])
def test_damped_step_is_the_least_squares_solution(n: int, damping: float) -> None:
    """Householder's step is NumPy's least-squares solution of the matrix with the damping below it."""
    rng = np.random.default_rng(n)
    for _ in range(5):
        J, twist = rng.normal(size=(6, n)), rng.normal(size=6)
        if n == 7 and damping < 1e-2:
            continue  # nearly undetermined: the two solutions may differ along the free direction
        stacked = np.vstack([J, damping * np.eye(n)])
        expected = np.linalg.lstsq(stacked, np.concatenate([twist, np.zeros(n)]), rcond=None)[0]
        step = np.empty(n)
        refine.damped_step(J, twist, damping, step)
        np.testing.assert_allclose(step, expected, atol=1e-10 * max(1.0, np.abs(expected).max()))


@pytest.mark.parametrize("damping", [1e-3, 1e-6])
def test_damped_step_at_a_singularity_is_bounded(damping: float) -> None:
    """On a Jacobian that lost rank the step solves what can be solved and keeps still along the lost direction."""
    rng = np.random.default_rng(8)
    left, _, right = np.linalg.svd(rng.normal(size=(6, 6)))
    J = left @ np.diag([2.0, 1.5, 1.0, 0.7, 0.5, 0.0]) @ right
    step = np.empty(6)
    refine.damped_step(J, J @ rng.normal(size=6), damping, step)
    assert abs(right[-1] @ step) < 1e-9
    refine.damped_step(J, left[:, -1], damping, step)
    assert np.abs(step).max() < 1e-15 / damping**2 + 1e-12


@pytest.mark.parametrize("sigma", [1e-2, 1e-4, 1e-8, 1e-12])
def test_least_stretch_near_singular(sigma: float) -> None:
    """Near a singularity it is the smallest singular value, and its direction the one that belongs to it."""
    rng = np.random.default_rng(9)
    for _ in range(10):
        left, _, right = np.linalg.svd(rng.normal(size=(6, 6)))
        J = left @ np.diag([*rng.uniform(0.3, 2.0, 5), sigma]) @ right
        x = np.empty(6)
        expected = np.linalg.svd(J, compute_uv=False)[-1]
        assert refine.least_stretch(J, x) == pytest.approx(expected, rel=1e-4, abs=1e-15)
        assert abs(abs(x @ right[-1]) - 1.0) < 1e-6


def test_least_stretch_is_no_less_than_the_least() -> None:
    """Of any matrix it is between the smallest singular value and thrice that; of a singular one, zero to rounding."""
    rng = np.random.default_rng(10)
    x = np.empty(6)
    for _ in range(200):
        J = rng.normal(size=(6, 6))
        least = np.linalg.svd(J, compute_uv=False)[-1]
        assert least * (1.0 - 1e-9) <= refine.least_stretch(J, x) <= 3.0 * least
    for J in (np.zeros((6, 6)), np.diag([1.0, 2.0, 0.0, 1.0, 1.0, 1.0]), np.ones((6, 6))):
        assert refine.least_stretch(J, x) < 1e-14


@pytest.mark.parametrize("sigma", [1e-4, 1e-8, 1e-12])
def test_least_stretch_across_its_first_guess(sigma: float) -> None:
    """A lost direction at right angles to the vector of ones, where the iteration begins, is found all the same."""
    J = np.eye(6)
    J[:2, :2] = [[1.0, 1.0], [1.0, 1.0 + 2.0 * sigma]]
    expected = np.linalg.svd(J, compute_uv=False)[-1]
    assert refine.least_stretch(J, np.empty(6)) == pytest.approx(expected, rel=1e-3)


# ---------------------------------------------------------------- columns of solutions


def test_new_solutions_are_told_from_old_ones() -> None:
    """A joint vector that stands in the table, whole turns aside, is not new; one at a distance is."""
    arm, chain = numbers_of(ARMS["wrist"])
    q = np.array([0.4, -0.7, 3.1415, 0.6, 0.9, -0.3])
    T = chain.fk(q)
    Q, flags = np.full((8, 6), np.nan), np.zeros(8, np.uint8)
    assert refine.is_new(arm, T, Q, flags, q)
    refine.keep(Q, flags, 3, q, layout.WRIST)
    assert flags.tolist() == [0, 0, 0, layout.VALID | layout.WRIST, 0, 0, 0, 0]
    for shift in (0.0, 0.5 * DEFAULT.duplicate, -0.5 * DEFAULT.duplicate):
        assert not refine.is_new(arm, T, Q, flags, q + shift)
    other = q.copy()
    other[2] -= 2.0 * PI
    assert not refine.is_new(arm, T, Q, flags, other)
    for shift in (1e-6, 1e-4, 0.1):
        assert refine.is_new(arm, T, Q, flags, q + shift)


def test_a_taken_column_is_kept() -> None:
    """A second solution of one branch goes to the first free column, and is dropped where none is left."""
    Q, flags = np.full((3, 6), np.nan), np.zeros(3, np.uint8)
    for number, column in ((1.0, 1), (2.0, 1), (3.0, 1), (4.0, 1)):
        refine.keep(Q, flags, column, np.full(6, number), 0)
    np.testing.assert_array_equal(Q[:, 0], [2.0, 1.0, 3.0])
    assert flags.tolist() == [1, 1, 1]


# ---------------------------------------------------------------- compiled and interpreted

CHAIN = Chain.from_urdf(urdf.read(ARMS["oblique"]), "base", "tool")
Q_SAMPLE = np.array([0.4, -0.7, 1.1, 0.6, 0.9, -0.3])
POSE = np.array(CHAIN.fk(Q_SAMPLE))
SCREWS = (np.array(CHAIN.H), np.array(CHAIN.P), np.array(CHAIN.R_tip), CHAIN.prismatic)
M_SAMPLE = wrist(0.3, 1.2, -0.8, -1.4, 2.0)
TWIST_PARTS = (math.cos(1.2), math.sin(1.2), math.cos(-1.4), math.sin(-1.4))
CALLS: list[tuple[Kernel, tuple[Any, ...]]] = [
    (trig.atan2, (0.3, -1.2)),
    (subproblems.unit, (3.0, -4.0)),
    (subproblems.unturn, (0.3, 0.4, 0.6, 0.8)),
    (subproblems.is_double, (1e-16, 0.5, 7e-15)),
    (subproblems.swing_to_offset, (0.4, -0.9, 0.2, -1.0)),
    (subproblems.elbow, (0.7, 0.5, 0.6, 0.8, -1.0, 1.0)),
    (subproblems.wrist_bend, (*M_SAMPLE[:, 2], *TWIST_PARTS, -1.0)),
    (subproblems.wrist_turns, (*M_SAMPLE.T.ravel(), math.cos(-0.8), math.sin(-0.8), *TWIST_PARTS, False, 1.0, 0.0)),
    (polynomials.trigonometric_roots, (*with_roots(0.3, 0.8, 1.9, 1.2), np.zeros((4, 2)))),
    (screws.turn, (np.eye(3), np.array([0.6, 0.0, 0.8]), math.cos(0.4), math.sin(0.4))),
    (screws.place_axes, (*SCREWS, Q_SAMPLE, np.zeros((4, 4)), np.zeros((6, 3)), np.zeros((6, 3)))),
    (screws.forward_batch, (*SCREWS, np.array([Q_SAMPLE, -Q_SAMPLE]), np.zeros((2, 4, 4)))),
    (screws.jacobian_batch, (*SCREWS, np.array([Q_SAMPLE, -Q_SAMPLE]), np.zeros((2, 6, 6)))),
    (target.project_rotation, (POSE * (1.0 + 1e-4), np.zeros((4, 4)))),
    (target.to_frame_1, (POSE, numbers_of(ARMS["oblique"])[0], np.zeros(12))),
    (target.check_target, (POSE * 1.001,)),
    (refine.pose_error, (POSE, CHAIN.fk(Q_SAMPLE + 0.1), 0.5, np.zeros(6))),
    (refine.damped_step, (CHAIN.jacobian(Q_SAMPLE), np.arange(6.0), 1e-3, np.zeros(6))),
    (refine.least_stretch, (CHAIN.jacobian(Q_SAMPLE), np.zeros(6))),
    (refine.refine, (numbers_of(ARMS["oblique"])[0], POSE, Q_SAMPLE + 0.05, 2, 0.0, 60)),
    (refine.newton, (numbers_of(ARMS["oblique"])[0], POSE, Q_SAMPLE + 0.05, 2)),
    (lines.line_vector, (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, np.zeros(lines.LINE))),
    (lines.line_motion, (POSE, np.zeros((lines.LINE, lines.LINE)))),
]


@pytest.mark.parametrize(("kernel", "arguments"), CALLS, ids=[kernel.__name__ for kernel, _ in CALLS])
def test_compiled_is_interpreted(kernel: Kernel, arguments: tuple[Any, ...]) -> None:
    """The compiled kernel returns, and writes to its arrays, what the Python text of it says."""
    answers = []
    for as_run in (kernel, interpreted(kernel)):
        own = [a.copy() if isinstance(a, np.ndarray) else a for a in arguments]
        returned = as_run(*own)
        answers.append([returned, *(a for a in own if isinstance(a, np.ndarray))])
    for compiled, plain in zip(*answers, strict=True):
        if compiled is None:
            assert plain is None
        else:
            np.testing.assert_allclose(np.array(compiled, float), np.array(plain, float), rtol=1e-11, atol=1e-13)


SOLVE = """
import sys, numpy as np, urdf_ik
given = dict(np.load(sys.argv[1]))
np.savez(sys.argv[2], **{name: urdf_ik.load(str(given[name]), "base", "tool").ik(given["poses " + name]).q
                         for name in given if not name.startswith("poses ")})
"""


def fresh(code: str, *arguments: str, **environment: str | None) -> str:
    """Standard output of a fresh interpreter that runs the code; None takes a variable away."""
    changed = {name: value for name, value in {**os.environ, **environment}.items() if value is not None}
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], env=changed, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_compiled_solvers_are_interpreted_ones(tmp_path: Path) -> None:
    """Without Numba each closed-form family finds the same solutions in the same columns, near a singularity too."""
    rng = np.random.default_rng(11)
    given, compiled = {}, {}
    for kind in KINDS:
        text = random_arm(kind, 1, aligned=True).urdf
        chain = Chain.from_urdf(urdf.read(text), "base", "tool")
        plan = families.choose(analyse(chain), chain)
        assert plan is not None
        q = rng.uniform(-PI, PI, (4, 6))
        poses = chain.fk(q)
        Q, flags = np.empty((4, len(plan.branches), 6)), np.empty((4, len(plan.branches)), np.uint8)
        assert plan.solve(poses, plan.arm, np.zeros(7), Q, flags) == -1
        given[kind], given[f"poses {kind}"], compiled[kind] = np.array(text), poses, Q
    np.savez(tmp_path / "given.npz", **given)
    fresh(SOLVE, str(tmp_path / "given.npz"), str(tmp_path / "out.npz"), NUMBA_DISABLE_JIT="1")
    answers = np.load(tmp_path / "out.npz")
    for kind, expected in compiled.items():
        assert np.isfinite(expected).any()
        np.testing.assert_allclose(answers[kind], expected, rtol=0.0, atol=1e-9, equal_nan=True, err_msg=kind)


# ---------------------------------------------------------------- cache of the machine code


def test_digest_follows_the_kernels_text(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Any edit of any kernel's file, and any new file, changes the cache directory's name; copying them does not."""
    for file in Path(compiler.__file__).parent.glob("*.py"):
        shutil.copy(file, tmp_path)
    expected = compiler._digest()
    monkeypatch.setattr(compiler, "__file__", str(tmp_path / "compile.py"))
    assert compiler._digest() == expected
    seen = {expected}
    for name in ("trig.py", "layout.py", "refine.py"):
        with (tmp_path / name).open("a") as file:
            file.write("# more\n")
        seen.add(compiler._digest())
    (tmp_path / "new.py").write_text("x = 1\n")
    seen.add(compiler._digest())
    assert len(seen) == 5
    monkeypatch.setattr(compiler.numba, "__version__", "0.0.0")
    assert compiler._digest() not in seen


def test_directory_carries_the_digest() -> None:
    """The machine code lies in a directory of its own for this version of the kernels, and exists."""
    assert compiler.CACHE_DIRECTORY.name == f"kernels-{compiler._digest()}" or not os.access(compiler._root(), os.W_OK)
    assert compiler.CACHE_DIRECTORY.is_dir()


def test_numbas_own_cache_setting_is_untouched() -> None:
    """Other packages' Numba functions keep their cache: the global setting is what the environment says."""
    assert os.environ.get("NUMBA_CACHE_DIR", "") == config.CACHE_DIR


@pytest.mark.parametrize(
    ("platform", "environment", "expected"),
    [
        ("linux", {"URDF_IK_CACHE_DIR": "/a", "NUMBA_CACHE_DIR": "/b", "XDG_CACHE_HOME": "/c"}, "/a"),
        ("linux", {"NUMBA_CACHE_DIR": "/b", "XDG_CACHE_HOME": "/c"}, "/b"),
        ("linux", {"XDG_CACHE_HOME": "/c"}, "/c/urdf-ik"),
        ("linux", {"XDG_CACHE_HOME": "", "HOME": "/h"}, "/h/.cache/urdf-ik"),
        ("linux", {"HOME": "/h"}, "/h/.cache/urdf-ik"),
        ("darwin", {"HOME": "/h", "XDG_CACHE_HOME": "/c"}, "/h/Library/Caches/urdf-ik"),
        ("win32", {"LOCALAPPDATA": "/l"}, "/l/urdf-ik"),
    ],
)
def test_cache_folder(
    platform: str, environment: dict[str, str], expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Our own variable comes before Numba's, then the platform's folder for caches."""
    with monkeypatch.context() as patch:
        for name in ("URDF_IK_CACHE_DIR", "NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA"):
            patch.delenv(name, raising=False)
        for name, setting in environment.items():
            patch.setenv(name, setting)
        patch.setattr(sys, "platform", platform)
        found = compiler._root()
    assert found == Path(expected)


def test_directory_falls_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the cache cannot be made, a folder among the temporary ones serves, and in need a new one of its own."""
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    monkeypatch.setenv("URDF_IK_CACHE_DIR", str(blocked))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    shared = compiler._directory()
    assert shared.parent.parent == tmp_path
    assert shared.name == f"kernels-{compiler._digest()}"
    assert compiler._directory() == shared
    shutil.rmtree(shared.parent)
    shared.parent.write_text("in the way, too")
    alone = compiler._directory()
    assert alone.parent == tmp_path
    assert alone.is_dir()


USE = """
import json, numpy as np
from numba.core import config
from urdf_ik._kernels import compile, polynomials
gap = polynomials.root_gap(np.array([[1.0, 0.0], [0.0, 1.0]]), 2, 0)
files = [str(file) for file in compile.CACHE_DIRECTORY.rglob("*.nbi")]
print(json.dumps([gap, str(compile.CACHE_DIRECTORY), files, config.CACHE_DIR]))
"""


def test_cache_directory_is_used(tmp_path: Path) -> None:
    """A kernel's machine code lands below URDF_IK_CACHE_DIR, in this version's directory, and nowhere else."""
    given = json.loads(
        fresh(USE, URDF_IK_CACHE_DIR=str(tmp_path), NUMBA_DISABLE_JIT=None, NUMBA_CACHE_DIR=str(tmp_path / "other"))
    )
    gap, directory, files, numbas = given
    assert gap == 2.0
    assert directory == str(tmp_path / f"kernels-{compiler._digest()}")
    assert [Path(file).name.split("-")[0] for file in files] == ["polynomials.root_gap"]
    assert numbas == str(tmp_path / "other")
    assert not (tmp_path / "other").exists()


def test_unwritable_cache_does_no_harm(tmp_path: Path) -> None:
    """With a file where the cache folder should be, kernels work, and are kept among the temporary files."""
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    gap, directory, files, _ = json.loads(
        fresh(USE, URDF_IK_CACHE_DIR=str(blocked), NUMBA_DISABLE_JIT=None, TMPDIR=str(tmp_path))
    )
    assert gap == 2.0
    assert Path(directory).is_relative_to(tmp_path)
    assert len(files) == 1
