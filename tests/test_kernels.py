"""Kernels, compiled and interpreted; targets, lines and columns of solutions."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from arms import KINDS, industrial, random_arm, rotation
from kernel_samples import ARMS, PI, fresh, interpreted, numbers_of, with_roots, wrist
from numpy.typing import NDArray

from urdf_ik import families, urdf
from urdf_ik._kernels import layout, lines, polynomials, refine, screws, subproblems, target, trig
from urdf_ik.chain import Chain
from urdf_ik.structure import analyse
from urdf_ik.tolerances import DEFAULT

Array = NDArray[np.float64]
Kernel = Callable[..., Any]


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
