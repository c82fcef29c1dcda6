"""Arms near a family: rounded decimals, calibrations, random deviations of every size, measured by Pinocchio.

Between an exact structure and none there is no gap: whatever the imperfection, ``ik`` keeps its contract.
"""

from collections.abc import Callable
from functools import lru_cache
from itertools import product

import contract
import numpy as np
import pytest
from arms import KINDS, DescribedArm, industrial, random_arm, ur_like
from arms_general import (
    calibrated_ur,
    near_member,
    rounded_industrial,
    rounded_offset_wrist,
    rounded_over_base,
    rounded_straight_wrist,
    rounded_ur,
    six_of_a_shifted_iiwa,
    tilted,
)
from cases import Case, described, nearest, rows, thinned
from lxml import etree
from numpy.typing import NDArray
from oracle import angle_distance
from searches import folds, newton

import urdf_ik
from urdf_ik.model import catalogue

Array = NDArray[np.float64]

EPS = (1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 1e-1)  # rad, share of the arm's length
ALL_MEMBERS = tuple((kind, eps) for kind in KINDS for eps in EPS)
EVERY_OTHER = tuple((kind, eps) for i, kind in enumerate(KINDS) for eps in EPS[i % 2 :: 2])
MADE: dict[str, Callable[[], DescribedArm]] = {
    "industrial rpy 1.5708": rounded_industrial,
    "industrial rpy 1.57080": lambda: rounded_industrial(5),
    "industrial off by 1e-9": lambda: tilted(industrial(), 1e-9, 0),
    "ur rpy 1.5708": rounded_ur,
    "ur rpy 1.570796": lambda: rounded_ur(6),
    "ur rpy 1.57": lambda: rounded_ur(2),
    "ur calibrated": calibrated_ur,
    "ur off by 1e-3": lambda: tilted(ur_like(), 1e-3, 0),
}


@lru_cache
def near(kind: str, eps: float, seed: int = 0) -> Case:
    """Load a random member of a family that is off by ``eps``."""
    return described(near_member(kind, eps, seed))


@lru_cache
def made(name: str) -> Case:
    """Load one of the arms of ``MADE``."""
    return described(MADE[name]())


@pytest.mark.parametrize(("kind", "eps"), ALL_MEMBERS)
def test_contract_whatever_the_imperfection(kind: str, eps: float) -> None:
    """A family's member that is off by 1e-12 to 1e-1 rad and length: planted found, all exact, none twice."""
    contract.holds(near(kind, eps), 40, 1)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["wrist, 2||3", "wrist, 2||3, 1x2", "2||3||4, 5x6", "2||3||4, 1x2, 5x6"])
@pytest.mark.parametrize("eps", [1e-5, 1e-4, 3e-4])
def test_none_of_many_is_lost(kind: str, eps: float) -> None:
    """Of 20,000 random joint vectors every one is among its pose's solutions.

    Also where branches of the ideal arm end, a weak angle carries a small difference far, or two kinds of fold meet.
    """
    case = near(kind, eps, 1)
    q = case.oracle.draw(np.random.default_rng(8), 20_000)
    solutions = case.arm.ik(case.oracle.poses(q))
    apart = angle_distance(solutions.q, q[:, None])
    lost = ~(np.where(solutions.valid, apart, np.inf).min(axis=1) < 1e-7)
    assert not lost.any(), q[lost]


@pytest.mark.parametrize(("kind", "eps"), [(kind, eps) for kind, eps in ALL_MEMBERS if eps <= 1e-4])
def test_the_structure_reports_the_imperfection(kind: str, eps: float) -> None:
    """Up to 1e-4 the family is recognised, the reported imperfection is about eps, and the method refines."""
    structure, exact = near(kind, eps).arm.structure, described(random_arm(kind, 0)).arm.structure
    assert structure.family.split(",")[0] == exact.family.split(",")[0]
    assert "refine" in structure.method
    assert "refine" not in exact.method
    angle, distance = structure.imperfection
    assert 0.1 * eps < max(angle, distance / near(kind, eps).arm.chain.size) < 10.0 * eps
    assert max(exact.imperfection) < 1e-13
    assert f"{angle:.2g} rad and {distance:.2g} m off" in str(structure)


@pytest.mark.parametrize("kind", thinned(KINDS, 3))
@pytest.mark.parametrize("eps", [1e-10, 1e-6, 1e-3])
def test_no_solution_is_missing(kind: str, eps: float) -> None:
    """The solutions are as many as a multi-start Newton search on Pinocchio's model finds."""
    contract.is_complete(near(kind, eps), 2, 3)


@pytest.mark.parametrize("kind", thinned(KINDS, 3))
def test_the_ideal_arms_columns(kind: str) -> None:
    """An arm off by 1e-9 has its regular solutions in the columns in which the ideal arm has them."""
    member = random_arm(kind, 0)
    exact, off = described(tilted(member, 0.0, 0)), described(tilted(member, 1e-9, 0))
    width = len(exact.arm.structure.branches)
    assert off.arm.structure.branches[:width] == exact.arm.structure.branches
    for q in exact.oracle.draw(np.random.default_rng(5), 30):
        expected, answer = (arm.ik(exact.oracle.pose(q)) for arm in (exact.arm, off.arm))
        if min(exact.oracle.sigma_min(x) for x in rows(expected)) < 1e-2:
            continue
        np.testing.assert_allclose(np.asarray(answer.q)[:width], expected.q, rtol=0.0, atol=1e-5)
        assert not np.asarray(answer.valid)[width:].any(), q


@pytest.mark.parametrize(
    "member",
    [industrial, ur_like, lambda: random_arm("wrist, 2||3, 1x2", 0)],
    ids=["with an offset", "ur", "without an offset"],
)
def test_a_calibration_renames_no_branch(member: Callable[[], DescribedArm]) -> None:
    """Off by 1e-4 to any side, each posture keeps its branch name, also where an offset was zero before."""
    exact = described(tilted(member(), 0.0, 0))
    drawn = exact.oracle.draw(np.random.default_rng(0), 60)
    regular = [q for q in drawn if exact.oracle.sigma_min(q) > 0.03]
    assert len(regular) > 20
    for seed in range(6):
        off = described(tilted(member(), 1e-4, seed))
        for q in regular:
            names = [case.arm.ik_nearest(case.oracle.pose(q), q, within_limits=False).names for case in (exact, off)]
            assert names[0] == names[1], (seed, q.tolist())


@pytest.mark.parametrize("member", thinned(EVERY_OTHER, 5))
def test_planted_near_singularities(member: tuple[str, float]) -> None:
    """At 1e-1 to 1e-7 rad from any singularity the planted ones are found, all are exact."""
    contract.holds_near_singularities(near(*member), 15, 6)


@pytest.mark.parametrize("name", MADE)
def test_rounded_and_calibrated_arms(name: str) -> None:
    """Planted vectors are found, 1e-1 to 1e-7 rad from singularities too; Newton's method finds no other solution."""
    contract.holds(made(name), 60, 2)
    contract.holds_near_singularities(made(name), 15, 7)
    contract.is_complete(made(name), 2, 4)
    contract.batch_equals_single_but_for_one(made(name), 8)


def stretched_or_over_itself(case: Case, rng: np.random.Generator, m: int) -> Array:
    """(m, 2) rad: joints 2 and 3 for which a wrist arm is singular whatever its wrist, by halving between signs."""

    def measure(second: Array, third: Array) -> Array:
        q = np.tile([0.0, 0.0, 0.0, 0.3, 0.7, 0.0], (*third.shape, 1))
        q[..., 1], q[..., 2] = second, third
        return np.asarray(np.linalg.det(case.arm.jacobian(q)))

    second = rng.uniform(-np.pi, np.pi, (m, 1))
    third = np.tile(np.linspace(-np.pi, np.pi, 61), (m, 1))
    values = measure(second, third)
    row, column = np.nonzero(values[:, :-1] * values[:, 1:] < 0.0)
    second, low, high, before = second[row, 0], third[row, column], third[row, column + 1], values[row, column]
    for _ in range(60):
        middle = 0.5 * (low + high)
        same = measure(second, middle) * before > 0.0
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.stack([second, low], axis=-1)[rng.permutation(len(low))[:m]]


@pytest.mark.parametrize(
    ("name", "certain_of_40"),
    [("industrial rpy 1.5708", 30), ("industrial rpy 1.57080", 30), ("ur calibrated", 10), ("ur off by 1e-3", 10)],
)
def test_what_is_proven_lacks_nothing(name: str, certain_of_40: int) -> None:
    """1e-3 rad off an aligned wrist, a UR's elbow stretched too: where it is certain, Newton's method finds no more."""
    case, rng = made(name), np.random.default_rng(4)
    q = rng.uniform(-np.pi, np.pi, (240, 6))
    if name.startswith("ur"):
        assert (case.arm.ik(case.arm.fk(q)).status == "complete").mean() > 0.93
        q[20:40, 2] = 1e-3 * rng.choice([-1.0, 1.0], 20)
    wrists = 20 if name.startswith("ur") else 40
    q[:wrists, 4] = rng.choice([0.0, np.pi], wrists) + 1e-3 * rng.choice([-1.0, 1.0], wrists)
    T = np.asarray(case.arm.fk(q[:40]))
    found = case.arm.ik(T)
    certain = np.flatnonzero(np.asarray(found.certain))
    assert len(certain) >= certain_of_40
    for k in certain if name.startswith("ur") else certain[:12]:
        have = rows(found[int(k)])
        starts = np.concatenate([q[k] + 0.01 * rng.normal(size=(8, 6)), rng.uniform(-np.pi, np.pi, (40, 6))])
        for root in newton(case.arm.fk, case.arm.jacobian, case.arm.chain.size, T[k], starts, 1e-5):
            assert nearest(have, root) < 1e-6, (q[k].tolist(), root.tolist())


@pytest.mark.parametrize("name", ["ur calibrated", "ur off by 1e-3"])
@pytest.mark.parametrize(("off", "share"), [(1e-3, 0.95), (1e-4, 0.95), (1e-6, 0.6)])
def test_a_calibrated_arm_is_proven_beside_its_singularities(name: str, off: float, share: float) -> None:
    """Beside joint vectors where det J changes its sign most poses are proven, and no planted one is missing."""
    case, rng = made(name), np.random.default_rng(5)
    d = rng.normal(size=(100, 6))
    q = folds(case.arm, 100, rng) + off * d / np.linalg.norm(d, axis=1, keepdims=True)
    found = case.arm.ik(np.stack([case.oracle.pose(each) for each in q]))
    assert np.asarray(found.certain).mean() >= share
    for k, each in enumerate(q):
        assert nearest(rows(found[k]), each) <= case.oracle.tolerance(each), (k, each.tolist())


@pytest.mark.parametrize("eps", thinned([1e-6, 1e-5, 1e-4], 3))
def test_industrial_arm_near_two_singularities_at_once_finds_the_planted_vector(eps: float) -> None:
    """Wrist axes aligned, the elbow straight or the wrist over axis 1: more solutions than branches, none lost."""
    case, rng = described(tilted(industrial(), eps, 0)), np.random.default_rng(1)
    places = stretched_or_over_itself(case, rng, 120)
    q = rng.uniform(-np.pi, np.pi, (len(places), 6))
    off = rng.choice([1e-4, 1e-5, 1e-6], len(q))
    q[:, 1:3] = places + off[:, None] * rng.normal(size=(len(q), 2))
    q[:, 4] = off * rng.choice([-1.0, 1.0], len(q))
    found = case.arm.ik(np.stack([case.oracle.pose(each) for each in q]))
    for k, each in enumerate(q):
        assert nearest(rows(found[k]), each) <= case.oracle.tolerance(each), (k, each.tolist())


@pytest.mark.parametrize(
    ("kind", "seed", "q"),
    [
        ("wrist, 2||3, 1x2", 2, (2.67908409, -0.32190228193, 1.18483474, 2.71093991, -1.32658159, 0.69322025)),
        ("wrist, 2||3", 5, (0.32867664, -2.12130531128, 0.81131019, 1.76529714, -0.41645764, -3.69337602)),
    ],
)
def test_wrist_arms_1e_5_off_keep_the_straight_elbow_over_the_base(kind: str, seed: int, q: tuple[float, ...]) -> None:
    """Straight elbow, wrist over axis 1: the planted vector is found although both margins are next to zero."""
    case = near(kind, 1e-5, seed)
    assert angle_distance(rows(case.arm.ik(case.oracle.pose(np.array(q)))), np.array(q)).min() < 1e-5


def test_rounded_wrist_arm_straight_wrist_and_elbow_keeps_the_crossing_branch() -> None:
    """With wrist and elbow straight a continuum fills all columns; the branch that crosses it is found nevertheless."""
    case, rng = described(rounded_straight_wrist()), np.random.default_rng(0)
    q = np.tile([0.0, -2.88681243699, 1.32895199023, 0.0, 0.0, 0.0], (100, 1))
    q[:, [0, 5]] = rng.uniform(-np.pi, np.pi, (100, 2))
    q[:, 3] = rng.uniform(-1.0, 1.0, 100) * 10.0 ** rng.uniform(-6.0, -2.0, 100)
    q[:, 4] = rng.uniform(-1.0, 1.0, 100) * 10.0 ** rng.uniform(-8.0, -3.0, 100)
    found = case.arm.ik(np.stack([case.oracle.pose(each) for each in q]))
    for k, each in enumerate(q):
        assert nearest(rows(found[k]), each) <= case.oracle.tolerance(each), (k, each.tolist())


def test_two_solutions_in_one_valley_are_both_found() -> None:
    """The wrist over axis 1, where the ideal arm turns joint 1 freely: pairs on both sides of a fold are found.

    Along this valley the pose changes by a millionth; det J changes its sign at a fold.
    """
    case, rng = described(rounded_over_base()), np.random.default_rng(5)
    start = np.array([1.3690476491434347, 0.9083598844092563, 1.9598531810732611, -0.8769082886104133,
                      -1.44568862589186, -0.3373413786749051])  # fmt: skip
    T = np.asarray(case.arm.fk(start))
    for _ in range(30):
        rounded = T.copy()
        rounded[:3, 3] += 1e-14 * rng.normal(size=3)
        found = rows(case.arm.ik(rounded))
        assert nearest(found, start) < 1e-5
        signs = np.sign(np.linalg.det(case.arm.jacobian(found)))
        assert signs.sum() == 0.0, signs


def test_a_divided_box_is_not_emptied_by_an_uncertain_sine() -> None:
    """Next to a straight elbow its cosine is certain and its sine is not: an arc about it is as wide as both say."""
    case, rng = described(six_of_a_shifted_iiwa()), np.random.default_rng(3)
    square = rng.choice([0.0, np.pi / 2, -np.pi / 2, np.pi], (400, 6))
    q = square + rng.normal(size=square.shape) * 10.0 ** rng.uniform(-5, -3, (400, 1))
    q[0] = [1.5704661619474554, 1.5707352213300498, 3.7039135951693326e-05, 3.1416191747903177,
            -0.00023089806219265418, 3.1412928254887174]  # fmt: skip
    answers = case.arm.ik(case.arm.fk(q))
    smallest = np.linalg.svd(case.arm.jacobian(q), compute_uv=False)[:, -1]
    for k in np.flatnonzero(answers.certain & (smallest > 1e-6)):
        assert nearest(rows(answers[k]), q[k]) < 1e-5, (q[k].tolist(), answers[k].status)


def test_where_singularities_meet_a_certain_answer_has_the_planted_vector() -> None:
    """It keeps the pose, though the four solutions beside it are not real by 4e-3 rad."""
    case = described(rounded_offset_wrist())
    for quarters in product((-1, 0, 1, 2), (0, 2), (-1, 0, 1, 2), (0, 2), (-1, 0, 1, 2)):
        q = np.array([0, *quarters]) * (np.pi / 2)
        target = case.oracle.pose(q)
        s = case.arm.ik(target)
        between = [q + 0.5 * np.angle(np.exp(1j * (found - q))) for found in rows(s)]
        assert not s.certain or min(case.oracle.error(each, target) for each in between) < 1e-8, quarters


def off_by_microns() -> urdf_ik.Arm:
    """The bundled S-R-S arm with origins some 30 um and 20 urad off, as rounded numbers of a URDF leave them."""
    robot = etree.fromstring(catalogue.resolve("srs_7r").path.read_bytes())
    for k, origin in enumerate(robot.iterfind("joint/origin")):
        xyz, rpy = ([float(each) for each in origin.get(name, "0 0 0").split()] for name in ("xyz", "rpy"))
        xyz[0] += 3e-5 * (-1) ** k
        xyz[1] += 2e-5
        rpy[0] += 2e-5 * (-1) ** (k // 2)
        origin.set("xyz", " ".join(map(repr, xyz)))
        origin.set("rpy", " ".join(map(repr, rpy)))
    return urdf_ik.load(etree.tostring(robot).decode())


def test_srs_off_by_microns_with_its_elbow_stretched_is_found_to_rounding() -> None:
    """At 1.3e-4 rad from the stretched elbow an error of 5e-11 is a joint 1e-6 rad off: solutions are converged."""
    arm = off_by_microns()
    q = np.array(
        [0.008108485723217207, 2.6359487799176167, -2.864916163393957, 0.00013238129142860607, 0.5637046004657775,
         2.152053680999405, 1.8425788317198197]
    )  # fmt: skip
    found = arm.ik(arm.fk(q), redundancy=arm.redundancy_of(q)).to_array()
    assert np.abs(np.angle(np.exp(1j * (found - q)))).max(axis=1).min() < 2e-7
