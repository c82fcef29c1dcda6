"""The steps that the families with a quartic, or a free joint, have in common."""

from __future__ import annotations

import math

import numpy as np
import pytest

from urdf_ik._kernels.linked_angles import linked_roots, sharpen_roots
from urdf_ik._kernels.subproblems import nearest_between, swing_to_tilt


def test_linked_roots_have_a_common_angle() -> None:
    """At every root the two affine functions are cosine and sine of one angle, and the planted angle is among them."""
    rng = np.random.default_rng(1)
    for _ in range(200):
        u, v = rng.uniform(-math.pi, math.pi, 2)
        cc, cs, sc, ss = rng.normal(size=4)
        c0 = math.cos(u) - cc * math.cos(v) - cs * math.sin(v)
        s0 = math.sin(u) - sc * math.cos(v) - ss * math.sin(v)
        roots = np.empty((4, 2))
        found = linked_roots(c0, cc, cs, s0, sc, ss, roots)
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
        e = rng.uniform(-math.pi, math.pi)
        x, m, gain = delta * rng.uniform(-1.0, 1.0), delta**2 * rng.uniform(0.5, 1.5), rng.uniform(0.3, 0.8)
        cosine = math.sqrt(1.0 - m)
        w = 2.0 * math.sin(0.5 * x) ** 2
        # cos u = cosine - gain w, and sin u affine with a slope that makes x a root.
        sine = math.sqrt(m + 2.0 * cosine * gain * w - gain * gain * w * w)
        g = rng.uniform(1.5, 2.5)
        b = sine - g * math.sin(x)
        roots = np.array([[math.cos(e), math.sin(e)], [math.cos(e), math.sin(e)], [0.0, 0.0], [0.0, 0.0]])
        sc, ss = -g * math.sin(e), g * math.cos(e)
        sharpen_roots(math.cos(e), math.sin(e), cosine, m, -gain, b, sc, ss, roots, 2)
        found = [math.cos(e) * s - math.sin(e) * c for c, s in roots[:2]]
        assert min(abs(y - x) for y in found) < 1e-6 * delta + 1e-15


@pytest.mark.parametrize("delta", [1.0, 1e-3, 1e-6, 1e-8])
def test_swing_to_tilt(delta: float) -> None:
    """The turned axis encloses the wanted angle, also where that is tiny and known by its sine alone."""
    rng = np.random.default_rng(3)
    for _ in range(100):
        alpha = rng.uniform(0.3, 2.8) * rng.choice([-1.0, 1.0])
        t, theta, turn = rng.uniform(-math.pi, math.pi), delta * rng.uniform(0.2, 1.0), rng.uniform(-2.0, 2.0)
        axis = np.array([math.sin(alpha) * math.sin(t), math.sin(alpha) * math.cos(t), math.cos(alpha)])
        side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
        side /= np.linalg.norm(side)
        across = math.cos(turn) * side + math.sin(turn) * np.cross(axis, side)
        given = math.cos(theta) * axis + math.sin(theta) * across
        off = []
        for sign in (1.0, -1.0):
            c, s, margin = swing_to_tilt(
                *given, math.cos(alpha), math.sin(alpha), math.cos(theta), math.sin(theta) ** 2, sign
            )
            assert margin > -1e-15
            off.append(abs(math.atan2(s * math.cos(t) - c * math.sin(t), c * math.cos(t) + s * math.sin(t))))
        # Where both solutions meet, half the digits are lost; half way between them nothing is.
        assert min(off) < 1e-7 * delta + 1e-14 / delta


def test_nearest_between() -> None:
    """The angle lies between the bounds, none of a fine grid that does is nearer, and NaN stands for none."""
    rng = np.random.default_rng(4)
    grid = np.linspace(-math.pi, math.pi, 2001)
    empty = 0
    for _ in range(200):
        wanted, (x, y) = rng.uniform(-math.pi, math.pi), rng.normal(size=2)
        low, high = np.sort(rng.normal(size=2))
        angle = nearest_between(wanted, x, y, low, high, 1e-12)
        values = x * np.cos(grid) + y * np.sin(grid)
        within = grid[(values >= low) & (values <= high)]
        if math.isnan(angle):
            assert len(within) == 0
            empty += 1
            continue
        assert low - 1e-9 <= x * math.cos(angle) + y * math.sin(angle) <= high + 1e-9
        if len(within):
            distance = np.abs((within - wanted + math.pi) % (2.0 * math.pi) - math.pi)
            assert abs((angle - wanted + math.pi) % (2.0 * math.pi) - math.pi) <= distance.min() + 1e-9
    assert 0 < empty < 100
