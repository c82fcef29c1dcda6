"""URDF text of arms with one to five joints, turning or sliding: random members of the classes that are built."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from arms import X, Y, Z, rotation, serial_urdf
from cases import Case, rows, worst_error
from numpy.typing import NDArray
from oracle import Oracle

import urdf_ik

Array = NDArray[np.float64]
TRAVEL = 1.0  # m that every slide goes either way


@dataclass(frozen=True)
class Build:
    """A class of arms: its joints in letters, their axes ('x', 'y', 'z', '?' any), and what must coincide.

    Attributes:
        kinds: R or P, one a joint.
        axes: directions at q = 0.
        meet: pairs of joints, from 0, whose axes pass through one point.
        task: what such an arm controls.
        wrist: the first of three joints whose axes meet in a point.
    """

    kinds: str
    axes: str
    meet: tuple[tuple[int, int], ...] = ()
    task: str = "pose"
    wrist: int | None = None


BUILDS = {
    "1R": Build("R", "?"),
    "1P": Build("P", "?"),
    "2R planar": Build("RR", "zz", (), "planar position"),
    "2R": Build("RR", "??"),
    "RP planar": Build("RP", "zx", (), "planar position"),
    "PP": Build("PP", "xy", (), "planar position"),
    "RP cylindrical": Build("RP", "zz"),
    "3R planar": Build("RRR", "zzz", (), "planar pose"),
    "RPR planar": Build("RPR", "zxz", (), "planar pose"),
    "PPR planar": Build("PPR", "xyz", (), "planar pose"),
    "3R positioning": Build("RRR", "zyy", ((0, 1),), "position"),
    "3R with offset": Build("RRR", "zyy", (), "position"),
    "3R any": Build("RRR", "???", (), "position"),
    "RRP polar": Build("RRP", "zyx", ((0, 1),), "position"),
    "RRP Stanford": Build("RRP", "zyx", (), "position"),
    "RRP SCARA": Build("RRP", "zzz", (), "position"),
    "RPP cylindrical": Build("RPP", "zzx", (), "position"),
    "PRP any": Build("PRP", "???", (), "position"),
    "PPP gantry": Build("PPP", "xyz", (), "position"),
    "PPP oblique": Build("PPP", "???", (), "position"),
    "PPPR gantry": Build("PPPR", "xyzz"),
    "RRPR SCARA": Build("RRPR", "zzzz"),
    "RRRP SCARA": Build("RRRP", "zzzz"),
    "PRRR SCARA": Build("PRRR", "zzzz"),
    "RPRR SCARA": Build("RPRR", "zzzz"),
    "RRRP wrist": Build("RRRP", "zzyx", ((1, 2), (2, 3))),
    "4R palletizer": Build("RRRR", "zyyy", ((0, 1),)),
    "4R 1x2+2||3+3x4": Build("RRRR", "zyyx", ((0, 1), (2, 3))),
    "4R any": Build("RRRR", "????"),
    "5R 2||3||4+4x5": Build("RRRRR", "zyyyx", ((0, 1), (3, 4)), "position and axis"),
    "5R offset shoulder": Build("RRRRR", "zyyyx", ((3, 4),), "position and axis"),
    "5R 1x2+4x5": Build("RRRRR", "zyyxy", ((0, 1), (3, 4)), "position and axis"),
    "5R 2||3||4": Build("RRRRR", "zyyyx", (), "position and axis"),
    "5R 1||2||3": Build("RRRRR", "zzzyx", ((3, 4),), "position and axis"),
    "5R any": Build("RRRRR", "?????", (), "position and axis"),
    "PPPRR": Build("PPPRR", "xyzzx", ((3, 4),)),
    "RRPRR any": Build("RRPRR", "?????"),
    "PPRRR any": Build("PPRRR", "?????"),
}


def few_urdf(
    kinds: str,
    axes: Array,
    points: Array,
    tool: Array,
    rng: np.random.Generator,
    *,
    aligned: bool = False,
) -> str:
    """URDF text of axes (n, 3) through points (n, 3) m and a tip at ``tool`` (3,), all at q = 0.

    Mount, tool's turn and the joints' frames are drawn; ``aligned`` leaves every frame as the base's.
    """

    def frame() -> Array:
        return np.eye(3) if aligned else rotation(rng.normal(size=3), rng.uniform(0.3, 3.0))

    here, turn = np.zeros(3), np.eye(3)
    origins: list[tuple[Array, Array]] = []
    written: list[Array | None] = []
    mount, at = frame(), rng.uniform(-0.4, 0.4, 3)
    for axis, point in [*zip(axes, points, strict=True), (None, tool)]:
        target, place = mount @ frame(), at + mount @ point
        rpy = np.zeros(3) if aligned else _rpy(turn.T @ target)
        origins.append((turn.T @ (place - here), rpy))
        # What was written, not what was meant, is where the next frame starts from.
        here = here + turn @ origins[-1][0]
        turn = turn @ rotation(Z, rpy[2]) @ rotation(Y, rpy[1]) @ rotation(X, rpy[0])
        written.append(None if axis is None else turn.T @ (mount @ axis))
    limits = [(-TRAVEL, TRAVEL) if kind == "P" else (-math.pi, math.pi) for kind in kinds]
    text = serial_urdf("few", origins, written, limits=[*limits, None])
    for i, kind in enumerate(kinds):
        if kind == "P":
            text = text.replace(f'name="joint_{i + 1}" type="revolute"', f'name="joint_{i + 1}" type="prismatic"')
    return text


def _rpy(R: Array) -> Array:
    return np.array([math.atan2(R[2, 1], R[2, 2]), math.atan2(-R[2, 0], math.hypot(R[2, 1], R[2, 2])),
                     math.atan2(R[1, 0], R[0, 0])])  # fmt: skip


def axes_and_points(build: Build, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Directions (n, 3), points (n, 3) and tip (3,) of a random member."""
    named = {"x": X, "y": Y, "z": Z}
    axes = np.array(
        [
            rng.choice([-1.0, 1.0]) * named[letter] if letter in named else _unit(rng.normal(size=3))
            for letter in build.axes
        ]
    )
    points = np.cumsum(rng.uniform(0.2, 0.5, (len(axes) + 1, 3)) * rng.choice([-1.0, 1.0], (len(axes) + 1, 3)), axis=0)
    tool, points = points[-1], points[:-1]
    for first, second in build.meet:
        # Somewhere along the axis before, and the frame itself somewhere else along its own.
        points[second] = points[first] + rng.uniform(0.1, 0.4) * axes[first]
    if build.wrist is not None:
        centre, three = points[build.wrist + 1].copy(), slice(build.wrist, build.wrist + 3)
        # Each frame somewhere along its own axis.
        points[three] = centre + rng.uniform(-0.2, 0.2, (3, 1)) * axes[three]
    return axes, points, tool


def _unit(v: Array) -> Array:
    return v / np.linalg.norm(v)


# Six joints with slides.
SLIDES = {
    "RRPRRR Stanford": Build("RRPRRR", "zyxxyx", ((0, 1),), wrist=3),
    "RRPRRR any": Build("RRPRRR", "??????", wrist=3),
    "RPRRRR any": Build("RPRRRR", "??????", wrist=3),
    "PRRRRR any": Build("PRRRRR", "??????", wrist=3),
    "PRRRRR parallel": Build("PRRRRR", "zzyzyz", wrist=3),
    "PRPRRR any": Build("PRPRRR", "??????", wrist=3),
    "PPRRRR any": Build("PPRRRR", "??????", wrist=3),
    "RPPRRR cylindrical": Build("RPPRRR", "zzxzyx", wrist=3),
    "PPPRRR gantry": Build("PPPRRR", "xyzzyz", wrist=3),
    "PPPRRR no wrist": Build("PPPRRR", "xyzzyx"),
    "RPRPRP any": Build("RPRPRP", "??????"),
    "RRRPPP any": Build("RRRPPP", "??????"),
    "RRRRPR wrist at the base": Build("RRRRPR", "zyx?y?", wrist=0),
    "RRRPRP wrist at the base": Build("RRRPRP", "??????", wrist=0),
}
# The same without a wrist: by elimination.
WRISTLESS = {
    "PRRRRR": Build("PRRRRR", "??????"),
    "RPRRRR": Build("RPRRRR", "??????"),
    "RRPRRR": Build("RRPRRR", "??????"),
    "RRRPRR": Build("RRRPRR", "??????"),
    "RRRRRP": Build("RRRRRP", "??????"),
    "PRRRRR on a rail": Build("PRRRRR", "xzyyyz"),
    "PPRRRR": Build("PPRRRR", "??????"),
    "RPRPRR": Build("RPRPRR", "??????"),
    "PRRRRP": Build("PRRRRP", "??????"),
}
BUILDS_OF_ALL = BUILDS | SLIDES | WRISTLESS


@lru_cache
def few(name: str, seed: int = 0, aligned: bool = False) -> Case:
    """A random member of one of ``BUILDS_OF_ALL``, loaded, and its reference."""
    build = BUILDS_OF_ALL[name]
    rng = np.random.default_rng([seed, *map(ord, name)])
    return case_of(few_urdf(build.kinds, *axes_and_points(build, rng), rng, aligned=aligned), name)


def case_of(text: str, name: str = "few") -> Case:
    """An arm and its reference from URDF text."""
    arm: Any = urdf_ik.load(text, base="base", tip="tool")
    return Case(name, arm, Oracle(text))


def draw(case: Case, rng: np.random.Generator, m: int) -> Array:
    """Joint vectors (m, n) all over."""
    q = rng.uniform(-math.pi, math.pi, (m, case.arm.dof))
    return np.where(case.arm.chain.prismatic, q / math.pi * TRAVEL, q)


def apart(case: Case, a: Array, b: Array) -> Array:
    """Largest difference (...) [rad or m] of joint vectors, turning joints modulo 2 pi."""
    step = np.asarray(a - b)
    turned = (step + math.pi) % (2.0 * math.pi) - math.pi
    return np.abs(np.where(case.arm.chain.prismatic, step, turned)).max(axis=-1)


def assert_answers(case: Case, q: Array, T: Array, *, tol: float | None = None) -> Array:
    """The planted q is found, every solution is exact and different. Returns them."""
    solutions = case.arm.ik(T)
    found = rows(solutions)
    assert np.isnan(solutions.q[~solutions.valid]).all()
    turning = ~case.arm.chain.prismatic
    assert (found[:, turning] > -math.pi).all()
    assert (found[:, turning] <= math.pi).all()
    assert len(found), f"nothing found at {q}"
    assert worst_error(case, found, T) <= 1e-9
    assert apart(case, found, q).min() <= (case.oracle.tolerance(q) if tol is None else tol), (q, found)
    for i, one in enumerate(found[:-1]):
        assert (apart(case, found[i + 1 :], one) > 1e-8).all()
    return found


def assert_complete(case: Case) -> int:
    """No solution that Newton's method finds from many random starts is missing. Returns how many starts arrived."""
    rng, arrived = np.random.default_rng(7), 0
    for q in draw(case, rng, 4):
        T = case.oracle.pose(q)
        found = rows(case.arm.ik(T))
        for start in draw(case, rng, 40):
            other = case.oracle.newton(start, T)
            if other is not None and case.oracle.error(other, T) < 1e-10:
                arrived += 1
                assert apart(case, found, other).min() < 1e-5
    return arrived
