"""For the tests of the core's steps: arms, numbers to draw, formulas written out, a fresh interpreter."""

import math
import os
import subprocess
import sys

import core_steps
import numpy as np
from arms import X, Z, industrial, random_arm, rotation, ur_like
from hypothesis import strategies as st
from numpy.typing import NDArray

from urdf_ik.ik.families.parts.written import Numbers
from urdf_ik.ik.families.parts.written import written as written_arm
from urdf_ik.kinematics.chain import Chain, from_urdf
from urdf_ik.model import urdf

Array = NDArray[np.float64]
PI = math.pi
# Steps that take blocks of poses too, of those that are tested with one set of numbers at a time.
IN_BLOCKS = ("wrap", "swing_to_offset", "elbow")


def step(name: str, *numbers: float) -> list[float]:
    """One step of the solvers; where there is one for blocks of poses, both give the same to rounding."""
    x = np.array([numbers], dtype=np.float64)
    alone = core_steps.step(name, x)[0]
    if name in IN_BLOCKS:
        together = core_steps.step(name, np.repeat(x, 3, axis=0), side_by_side=True)
        np.testing.assert_array_equal(together[0], together[2])
        # At a double root rounding is worth half the digits; beyond it, blocks continue on another curve.
        kept = slice(None) if name == "wrap" or alone[-1] > -1e-12 else slice(-1, None)
        scale = 1.0 + np.abs(x[np.isfinite(x)]).max(initial=0.0)
        np.testing.assert_allclose(together[1][kept], alone[kept], rtol=1e-12, atol=1e-7 * scale)
    return list(alone.tolist())


def written(urdf_text: str) -> tuple[Numbers, Chain]:
    """The arm as the URDF has it, as the solvers take it, and its chain."""
    chain = from_urdf(urdf.read(urdf_text), "base", "tool")
    return written_arm(chain), chain


def angles(low: float = -PI, high: float = PI) -> st.SearchStrategy[float]:
    """Angles [rad] with no preference for subnormal numbers."""
    return st.floats(low, high, allow_subnormal=False)


LENGTHS = st.floats(0.05, 3.0)
SIGNS = st.sampled_from([1.0, -1.0])


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


def apart(a: Array | float, b: Array | float) -> Array:
    """Distance between angles, round the circle."""
    return np.abs((np.subtract(a, b) + PI) % (2.0 * PI) - PI)


def e(angle: float) -> Array:
    """Unit vector (2,)."""
    return np.array([math.cos(angle), math.sin(angle)])


def wrist(first: float, alpha: float, bend: float, beta: float, last: float) -> Array:
    """Rz(first) Rx(alpha) Rz(bend) Rx(beta) Rz(last)."""
    return rotation(Z, first) @ rotation(X, alpha) @ rotation(Z, bend) @ rotation(X, beta) @ rotation(Z, last)


ARMS = {"wrist": industrial().urdf, "parallel": ur_like().urdf, "oblique": random_arm("wrist, general", 1).urdf}


def fresh(code: str, *arguments: str, **environment: str | None) -> str:
    """Standard output of a fresh interpreter that runs the code; None takes a variable away."""
    changed = {name: value for name, value in {**os.environ, **environment}.items() if value is not None}
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], env=changed, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout
