"""Six revolute joints without a closed form: every solution by elimination, judged by Pinocchio."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import contract
import numpy as np
import pytest
from arms import DescribedArm, rotation
from arms_general import crx_like, hc10_like, irb140_like, jaco_like, manseur_doty, unstructured
from cases import Case, assert_exact, closest_pair, described, nearest, rows
from numpy.typing import NDArray
from oracle import Oracle

from urdf_ik._kernels import general_6r as kernels
from urdf_ik._kernels import hidden_joint as hidden
from urdf_ik._kernels import layout
from urdf_ik._kernels.lines import LINE, line_motion, line_vector
from urdf_ik._kernels.polynomials import self_inversive_roots
from urdf_ik.families.general_6r import with_elimination

Array = NDArray[np.float64]

MAKERS: dict[str, Callable[[], DescribedArm]] = {
    **{f"random-{seed}": lambda seed=seed: unstructured(seed) for seed in range(8)},
    "manseur_doty": manseur_doty,
    "crx": crx_like,
    "hc10": hc10_like,
    "jaco": jaco_like,
    "irb140": irb140_like,
}
RANDOM = tuple(name for name in MAKERS if name.startswith("random"))
STRUCTURED = ("crx", "hc10", "jaco", "irb140")
ALL = tuple(MAKERS)


@lru_cache
def named(name: str) -> Case:
    """Load one of the arms."""
    return described(MAKERS[name]())


def angle_distance_of_joints(found: Array, q: Array) -> Array:
    """Differences (k, 6) [rad] of joint vectors, each by the shorter way round."""
    return (found - q + np.pi) % (2.0 * np.pi) - np.pi


def motion(h: Array, p: Array, angle: float) -> Array:
    """The rigid motion (4, 4) of a turn about the axis through p along h."""
    G = np.eye(4)
    G[:3, :3] = rotation(h, angle)
    G[:3, 3] = p - G[:3, :3] @ p
    return G


def line(point: Array, direction: Array) -> Array:
    """The 15 numbers of a line."""
    w = np.empty(LINE)
    line_vector(*point, *direction, w)
    return w


def line_matrix(G: Array) -> Array:
    """The matrix (15, 15) of a rigid motion."""
    U = np.empty((LINE, LINE))
    line_motion(G, U)
    return U


def random_motion(rng: np.random.Generator) -> Array:
    """Any rigid motion (4, 4)."""
    G = np.eye(4)
    G[:3, :3] = rotation(rng.normal(size=3), rng.uniform(-np.pi, np.pi))
    G[:3, 3] = rng.normal(size=3)
    return G


# ---------------------------------------------------------------- whole arms


@pytest.mark.parametrize("name", ALL)
def test_solved_by_elimination(name: str) -> None:
    """These arms belong to no family: they are solved by elimination, in sixteen columns with numbers for names."""
    structure = named(name).arm.structure
    assert structure.family == "6R general"
    assert structure.branches == tuple(f"solution {k}" for k in range(1, 17))
    assert structure.max_solutions == 16
    assert structure.imperfection == (0.0, 0.0)


@pytest.mark.parametrize("name", ALL)
def test_planted_solutions_are_found(name: str) -> None:
    """The drawn joint vector comes back, every solution reaches the pose, none comes twice, and their number is even.

    Solutions appear and vanish in pairs, so their number is even wherever none of them is singular.
    """
    case = named(name)
    for q in case.oracle.draw(np.random.default_rng(1), 60):
        target = case.oracle.pose(q)
        found = assert_exact(case, case.arm.ik(target), target)
        assert nearest(found, q) <= case.oracle.tolerance(q), q
        assert closest_pair(found) > 1e-7, q
        assert len(found) % 2 == 0 or min(case.oracle.sigma_min(x) for x in found) < 1e-6, q


@pytest.mark.parametrize("name", ["random-0", "random-1", "manseur_doty", *STRUCTURED])
def test_no_solution_is_missing(name: str) -> None:
    """Whatever a multi-start Newton search on Pinocchio's model finds is among the solutions."""
    case, rng = named(name), np.random.default_rng(2)
    for q in case.oracle.draw(rng, 2):
        target = case.oracle.pose(q)
        found = rows(case.arm.ik(target))
        searched = case.oracle.solutions(target, rng, starts=200)
        assert len(found) >= len(searched) > 0
        for other in searched:
            assert nearest(found, other) <= 1e-5, (q, other)


def test_sixteen_solutions() -> None:
    """The arm and pose of Manseur and Doty have sixteen real solutions: none less, and no two alike."""
    case = named("manseur_doty")
    target = np.eye(4)
    target[:3] = [
        [-0.760117, -0.641689, 0.102262, -1.140175],
        [0.133333, 0.0, 0.991071, 0.0],
        [-0.635959, 0.766965, 0.085558, 0.0],
    ]
    left, _, right = np.linalg.svd(target[:3, :3])
    target[:3, :3] = left @ right  # the published digits are a rotation to six places
    found = assert_exact(case, case.arm.ik(target), target)
    assert len(found) == 16
    assert closest_pair(found) > 1e-2


@pytest.mark.parametrize("name", ALL)
def test_batch_equals_single(name: str) -> None:
    """A stack of poses gives what each pose gives, column by column, with any number of threads."""
    case = named(name)
    targets = case.oracle.poses(case.oracle.draw(np.random.default_rng(3), 80))
    targets[7, :3, 3] += 100.0
    batch = case.arm.ik(targets)
    singles = [case.arm.ik(target) for target in targets]
    np.testing.assert_array_equal(batch.q, [s.q for s in singles])
    np.testing.assert_array_equal(batch.valid, [s.valid for s in singles])
    np.testing.assert_array_equal(batch.singular, [s.singular for s in singles])
    np.testing.assert_array_equal(case.arm.ik(targets, threads=2).q, batch.q)
    assert not batch.valid[7].any()


@pytest.mark.parametrize("name", ALL)
def test_columns_are_sorted(name: str) -> None:
    """Solutions stand in the first columns, by their first joint that differs, from -pi to pi."""
    case = named(name)
    for q in case.oracle.draw(np.random.default_rng(4), 20):
        solutions = case.arm.ik(case.oracle.pose(q))
        valid = np.asarray(solutions.valid)
        found = rows(solutions)
        assert valid[: len(found)].all()
        for a, b in zip(found[:-1], found[1:], strict=True):
            different = np.flatnonzero(np.abs(a - b) > 1e-6)
            assert a[different[0]] < b[different[0]], (q, a, b)


@pytest.mark.parametrize("name", ALL)
def test_out_of_reach_is_empty(name: str) -> None:
    """A pose 1 % beyond all links has no solution, in every column NaN, and no exception; nor has one far away."""
    case = named(name)
    target = case.oracle.pose(np.zeros(6))
    for factor in (1.01, 3.0, 1e3):
        target[:3, 3] = case.arm.chain.points[0] + np.array([0.0, factor * case.arm.chain.size, 0.0])
        solutions = case.arm.ik(target)
        assert len(assert_exact(case, solutions, target)) == 0
        assert list(solutions) == []


@pytest.mark.parametrize("name", ["random-0", "random-1", "random-2", *STRUCTURED])
def test_planted_near_singularities(name: str) -> None:
    """At 1e-1 to 1e-7 rad from where Pinocchio's Jacobian is singular at least 99 % of the planted ones are found.

    All solutions are exact, and none is given twice.
    """
    contract.holds_near_most_singularities(named(name), 30, 5)


@pytest.mark.parametrize("name", ["random-0", "random-1", "random-2", *STRUCTURED])
def test_on_a_singularity(name: str) -> None:
    """Where Pinocchio's Jacobian is singular there is an exact solution at it, marked as singular."""
    case, rng = named(name), np.random.default_rng(6)
    for _ in range(10):
        q, _ = case.oracle.singular(rng)
        target = case.oracle.pose(q)
        solutions = case.arm.ik(target)
        found = assert_exact(case, solutions, target)
        assert len(found) > 0, q
        sigmas = np.array([case.oracle.sigma_min(x) for x in found])
        marks = np.asarray(solutions.singular)[solutions.valid] != 0
        assert marks.any(), (q, sigmas)
        assert (sigmas[marks] < 1e-5).all(), (q, sigmas)


# ---------------------------------------------------------------- the elimination's parts


@pytest.mark.parametrize("name", ["random-0", "random-1", "crx"])
def test_fold_width_is_where_the_other_solution_lies(name: str) -> None:
    """Close to where Pinocchio's Jacobian is singular the next solution is as far away as the fold's bend says."""
    case, rng = named(name), np.random.default_rng(21)
    compared = 0
    for _ in range(20):
        q, _ = case.oracle.singular(rng)
        q += 2e-3 * rng.normal(size=6)
        found = rows(case.arm.ik(case.oracle.pose(q)))
        others = np.sort(np.linalg.norm(angle_distance_of_joints(found, q), axis=1))[1:]
        J = case.oracle.jacobian(q)
        J[:3] /= case.arm.chain.size
        width = kernels.fold_width(J, np.linalg.svd(J)[2][-1])
        if width < 0.05:
            compared += 1
            assert others.min() == pytest.approx(width, rel=0.2), q
    assert compared > 5


def test_line_motion_moves_lines() -> None:
    """The matrix of a motion takes a line's numbers to those of the moved line, whatever line and motion."""
    rng = np.random.default_rng(10)
    for _ in range(50):
        G, p, direction = random_motion(rng), rng.normal(size=3), rng.normal(size=3)
        moved = line(G[:3, :3] @ p + G[:3, 3], G[:3, :3] @ direction)
        np.testing.assert_allclose(line_matrix(G) @ line(p, direction), moved, atol=1e-12)


def test_line_motions_compose() -> None:
    """Motions one after the other multiply their matrices; standing still is the identity."""
    rng = np.random.default_rng(11)
    for _ in range(20):
        G, F = random_motion(rng), random_motion(rng)
        np.testing.assert_allclose(line_matrix(G @ F), line_matrix(G) @ line_matrix(F), atol=1e-12)
        np.testing.assert_allclose(line_matrix(G) @ line_matrix(np.linalg.inv(G)), np.eye(LINE), atol=1e-11)
    np.testing.assert_array_equal(line_matrix(np.eye(4)), np.eye(LINE))


def variants(case: Case) -> list[Array]:
    """The rows of constant matrices that were chosen when the arm was loaded."""
    numbers = with_elimination(case.arm._plan.arm, case.arm.chain)
    count = int(numbers[layout.VARIANTS])
    return list(numbers[layout.FIRST_VARIANT :].reshape(count, hidden.VARIANT))


@pytest.mark.parametrize("name", ALL)
def test_null_vectors_annihilate_the_left_side(name: str) -> None:
    """Six independent vectors take the line of axis a + 2 to zero, however joints a and a + 1 turn it."""
    case, rng = named(name), np.random.default_rng(12)
    for row in variants(case):
        first = int(row[hidden.FIRST])
        H = row[hidden.AXES : hidden.AXES + 18].reshape(6, 3)
        P = row[hidden.POINTS : hidden.POINTS + 18].reshape(6, 3)
        null = row[hidden.NULL : hidden.NULL + 6 * LINE].reshape(6, LINE)
        np.testing.assert_allclose(null @ null.T, np.eye(6), atol=1e-12)
        for t, u in rng.uniform(-np.pi, np.pi, (5, 2)):
            G = motion(H[first], P[first], t) @ motion(H[first + 1], P[first + 1], u)
            w = line(G[:3, :3] @ P[first + 2] + G[:3, 3], G[:3, :3] @ H[first + 2])
            np.testing.assert_allclose(null @ w, np.zeros(6), atol=1e-11 * np.linalg.norm(w))


CIRCLE = np.array(
    [(math.cos(2 * math.pi * k / hidden.SAMPLES), math.sin(2 * math.pi * k / hidden.SAMPLES)) for k in range(24)]
)


def eliminated(case: Case, row: Array, target: Array) -> tuple[Array, NDArray[np.complex128], float]:
    """The determinants (24,) at equispaced hidden angles, their harmonics (17,), and the noise above the eighth."""
    G, A, D = np.empty((4, 4)), np.empty((3, 6, 9)), np.empty(hidden.SAMPLES)
    coefficients = np.empty(2 * hidden.DEGREE + 1, np.complex128)
    kernels.loop_motion(with_elimination(case.arm._plan.arm, case.arm.chain), target, row[hidden.REVERSED] != 0.0, G)
    hidden.equations(row, G, A)
    hidden.determinants(A, CIRCLE, D)
    return D, coefficients, float(hidden.harmonics(D, CIRCLE, coefficients))


@pytest.mark.parametrize("name", RANDOM)
def test_the_determinant_has_eight_harmonics(name: str) -> None:
    """On arms without structure the sampled determinant has no harmonic above the eighth: no extraneous factor."""
    case = named(name)
    for q in case.oracle.draw(np.random.default_rng(13), 10):
        D, coefficients, noise = eliminated(case, variants(case)[0], case.oracle.pose(q))
        assert noise < 1e-6
        # What the kernel calls noise is what NumPy's transform has above the eighth.
        spectrum = np.abs(np.fft.rfft(D))
        np.testing.assert_allclose(np.abs(coefficients[8:]), spectrum[:9], atol=1e-12 * spectrum.max())
        assert spectrum[9:].max() < 1e-6 * spectrum.max()


@pytest.mark.parametrize("name", RANDOM)
def test_the_planted_angle_is_a_root(name: str) -> None:
    """At the hidden joint's planted angle the determinant vanishes, and the root finder gives that angle back."""
    case, row = named(name), variants(named(name))[0]
    joint = (int(row[hidden.FIRST]) + 5) % 6
    joint = 5 - joint if row[hidden.REVERSED] else joint
    for q in case.oracle.draw(np.random.default_rng(14), 10):
        if case.oracle.sigma_min(q) < 1e-2:
            continue
        _, coefficients, _ = eliminated(case, row, case.oracle.pose(q))
        z = np.empty(16, np.complex128)
        self_inversive_roots(coefficients, z)
        assert np.abs(z - np.exp(1j * q[joint])).min() < 1e-5, q


@pytest.mark.parametrize("degree", [4, 16])
def test_self_inversive_roots_are_the_planted_ones(degree: int) -> None:
    """Planted roots, on the unit circle or in pairs mirrored at it, come back from their polynomial's coefficients."""
    rng = np.random.default_rng(15)
    for on_circle in range(0, degree + 1, 2):
        pairs = (degree - on_circle) // 2
        # Well apart in angle: clustered roots are ill-conditioned, whatever the method.
        angles = 2.0 * np.pi * (np.arange(on_circle + pairs) + rng.uniform(-0.2, 0.2)) / (on_circle + pairs)
        angles = rng.permutation(angles)
        inside = np.exp(-rng.uniform(0.1, 0.5, pairs)) * np.exp(1j * angles[on_circle:])
        planted = np.concatenate([np.exp(1j * angles[:on_circle]), inside, 1.0 / np.conj(inside)])
        coefficients = np.poly(planted)[::-1]
        coefficients *= np.exp(0.5j * np.angle(np.conj(coefficients[0]) / coefficients[-1]))
        np.testing.assert_allclose(coefficients, np.conj(coefficients[::-1]), atol=1e-10 * abs(coefficients).max())
        z = np.empty(degree, np.complex128)
        self_inversive_roots(np.ascontiguousarray(coefficients), z)
        distance = np.abs(planted[:, None] - z[None, :])
        assert sorted(distance.argmin(axis=1)) == list(range(degree))
        assert distance.min(axis=1).max() < 1e-9


def test_self_inversive_roots_are_numpys() -> None:
    """For random harmonics, of very different sizes too, the roots are those of NumPy's eigenvalues."""
    rng = np.random.default_rng(16)
    for scale in (1.0, 1e-3, 1e-6):
        half = rng.normal(size=9) + 1j * rng.normal(size=9)
        half[:3] *= scale  # some roots near zero, and as many far out
        half[8] = half[8].real
        coefficients = np.concatenate([half, np.conj(half[7::-1])])
        z = np.empty(16, np.complex128)
        self_inversive_roots(coefficients, z)
        expected = np.roots(coefficients[::-1])
        distance = np.abs(expected[:, None] - z[None, :]) / np.abs(expected)[:, None]
        assert sorted(distance.argmin(axis=1)) == list(range(16))
        assert distance.min(axis=1).max() < 1e-7


def test_null_vectors_hold_the_planted_angles() -> None:
    """At the planted hidden angle the null vector is the product of the other two angles' terms."""
    case = named("random-0")
    row = variants(case)[0]
    joints = [(int(row[hidden.FIRST]) + k) % 6 for k in (3, 4, 5)]
    kept, kept_too, last = (5 - j for j in joints) if row[hidden.REVERSED] else joints
    for q in case.oracle.draw(np.random.default_rng(17), 10):
        if case.oracle.sigma_min(q) < 1e-2:
            continue
        G, A, X = np.empty((4, 4)), np.empty((3, 6, 9)), np.empty((12, 16))
        kernels.loop_motion(with_elimination(case.arm._plan.arm, case.arm.chain), case.oracle.pose(q), row[hidden.REVERSED] != 0.0, G)
        hidden.equations(row, G, A)
        hidden.null_vectors(A, np.tile([math.cos(q[last]), math.sin(q[last])], (16, 1)), X)
        t, half = q[kept], 0.5 * q[kept_too]
        halves = [math.cos(half), math.sin(half), math.cos(3.0 * half), math.sin(3.0 * half)]
        expected = np.outer([1.0, math.cos(t), math.sin(t)], halves).ravel()
        expected /= np.linalg.norm(expected)
        for x in X.T:
            assert abs(np.linalg.norm(x) - 1.0) < 1e-12
            assert min(np.linalg.norm(x - expected), np.linalg.norm(x + expected)) < 1e-6


def test_pinocchio_agrees_on_the_standard_table() -> None:
    """The arm made from a standard Denavit-Hartenberg table has that table's forward kinematics."""
    oracle = Oracle(manseur_doty().urdf)
    quarter, one = math.radians(90.0), math.radians(1.0)
    table = zip([quarter, one] * 3, (0.3, 1, 0, 1.5, 0, 0), (0, 0, 0.2, 0, 0, 0), strict=True)
    q = np.array([0.3, -1.2, 2.1, 0.7, -0.4, 1.9])
    pose = np.eye(4)
    for (alpha, a, d), angle in zip(table, q, strict=True):
        (ca, sa), (ct, st) = ((math.cos(x), math.sin(x)) for x in (alpha, angle))
        pose = pose @ [
            [ct, -st * ca, st * sa, a * ct],
            [st, ct * ca, -ct * sa, a * st],
            [0, sa, ca, d],
            [0, 0, 0, 1],
        ]
    np.testing.assert_allclose(oracle.pose(q), pose, atol=1e-12)
