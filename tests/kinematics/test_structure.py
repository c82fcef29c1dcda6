"""Relations of axes, their measured imperfection, and the family that follows."""

import itertools
import math

import numpy as np
import pytest
from arms import KINDS, X, Y, Z, industrial, random_arm, rotation, serial_urdf, ur_like
from chains import joint, robot
from numpy.typing import NDArray
from structures import of_kind, relations, structure_of

import urdf_ik

Array = NDArray[np.float64]

FAMILY = {
    "wrist, 2||3": "6R spherical wrist, 2||3",
    "wrist, 2||3, 1x2": "6R spherical wrist, 2||3 and 1x2",
    "wrist, 1x2": "6R spherical wrist, 1x2",
    "wrist, general": "6R spherical wrist, general shoulder",
    "wrist, 1||2": "6R spherical wrist, 1||2",
    "wrist, 2x3": "6R spherical wrist, general shoulder",
    "2||3||4, 5x6": "6R 2||3||4 and 5x6",
    "2||3||4, 1x2, 5x6": "6R 2||3||4 and 5x6",
    "2||3||4": "6R 2||3||4",
}
GENERAL = "6R general"
NAMED = [
    f"shoulder {front}, elbow {up}, wrist {flip}"
    for front in ("front", "back")
    for up in ("up", "down")
    for flip in ("noflip", "flip")
]
BRANCHES = {
    "6R spherical wrist, general shoulder": [
        f"position {root}, wrist {flip}" for root in (1, 2, 3, 4) for flip in ("noflip", "flip")
    ],
    "6R 2||3||4": [
        f"position {root}, elbow {up}" for pair in ((1, 2), (3, 4)) for up in ("up", "down") for root in pair
    ],
}


# ---------------------------------------------------------------- pairs and triples


@pytest.mark.parametrize(
    ("direction", "point", "relation", "degrees", "distance"),
    [
        (Z, [0.3, 0.4, 7.0], "parallel", 0.0, 0.5),
        (-Z, [0.3, 0.4, -7.0], "parallel", 180.0, 0.5),
        (Z, [0.0, 0.0, 3.0], "coincident", 0.0, 0.0),
        (-Z, [0.0, 0.0, -3.0], "coincident", 180.0, 0.0),
        (X, [0.0, 0.0, 2.0], "intersecting", 90.0, 0.0),
        (-Y, [0.0, 5.0, 2.0], "intersecting", 90.0, 0.0),
        (np.array([0.6, 0.0, 0.8]), [3.0, 0.0, 1.0], "intersecting", math.degrees(math.acos(0.8)), 0.0),
        (np.array([0.6, 0.0, -0.8]), [-3.0, 0.0, 1.0], "intersecting", math.degrees(math.acos(-0.8)), 0.0),
        (X, [4.0, 0.25, 2.0], "skew", 90.0, 0.25),
        (np.array([0.6, 0.0, 0.8]), [3.0, -0.25, 1.0], "skew", math.degrees(math.acos(0.8)), 0.25),
    ],
)
def test_relation_of_two_axes(
    direction: Array, point: list[float], relation: str, degrees: float, distance: float
) -> None:
    """Against the z axis: the relation, the angle from 0 to 180 degrees and the distance of the lines are known."""
    (pair,) = relations([Z, direction], [np.zeros(3), point]).pairs
    assert (pair.first, pair.relation) == (1, relation)
    assert math.degrees(pair.angle) == pytest.approx(degrees, abs=1e-12)
    assert pair.distance == pytest.approx(distance, abs=1e-14)
    assert max(pair.off_angle, pair.off_distance) < 1e-15


def test_three_axes() -> None:
    """Triples that meet or are parallel are found, with the point where they meet; two that meet are not enough."""
    corner = np.array([0.3, -0.2, 0.7])
    slid = [corner + 2.0 * X, corner - 1.0 * Y, corner + 0.5 * Z]
    (triple,) = relations([X, Y, Z], slid).triples
    assert (triple.first, triple.relation) == (1, "meet")
    assert triple.imperfection == pytest.approx(0.0, abs=1e-15)
    assert triple.point == pytest.approx(corner, abs=1e-15)
    for signs in itertools.product((1.0, -1.0), repeat=3):
        (triple,) = relations(np.outer(signs, Y), [np.zeros(3), X, X + Z]).triples
        assert (triple.first, triple.relation, triple.imperfection, triple.point) == (1, "parallel", 0.0, None)
    # Neighbours meet, in different points.
    assert relations([X, Y, Z], [np.zeros(3), np.zeros(3), Y]).triples == ()
    # The outer two are parallel and lie in one line: they meet the middle one in one point.
    (triple,) = relations([X, Y, -X], [np.zeros(3), np.zeros(3), 3.0 * X]).triples
    assert triple.relation == "meet"
    # Two in one line do not make three that meet in a point.
    assert relations([X, X, Y], [np.zeros(3), np.zeros(3), np.zeros(3)]).triples == ()
    found = relations([Z, Y, Y, Y, X, Z], np.cumsum([X, X, Z, Z, Y, X], axis=0)).triples
    assert [(t.first, t.relation) for t in found] == [(2, "parallel")]


def test_questions_about_a_structure() -> None:
    """Axes are numbered from 1; coincident ones count as parallel, and parallel ones never as intersecting."""
    structure = relations([Z, X, -X, X, Y], np.cumsum([np.zeros(3), Z, Z, Y, Z], axis=0))
    coincident = relations([Z, -Z, X], [np.zeros(3), Z, Y])
    assert [coincident.is_parallel(i) for i in (1, 2)] == [True, False]
    assert [coincident.is_intersecting(i) for i in (1, 2)] == [False, False]
    assert [structure.is_parallel(i) for i in (1, 2, 3, 4)] == [False, True, True, False]
    assert [structure.is_intersecting(i) for i in (1, 2, 3, 4)] == [True, False, False, False]
    assert [pair.relation for pair in structure.pairs] == ["intersecting", "parallel", "parallel", "skew"]
    found = structure.triple(2, "parallel")
    assert found is not None and found.first == 2
    assert structure.triple(2, "meet") is structure.triple(1, "parallel") is None


# ---------------------------------------------------------------- imperfection

SMALL = [1e-3, 1e-4, 1e-6, 1e-9]


@pytest.mark.parametrize("small", SMALL)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_tilted_axis_is_measured(small: float, sign: float) -> None:
    """Two axes meant to be parallel, or in one line, are off by the angle that one of them was tilted by."""
    for axis in (X, np.array([0.3, -0.5, 0.0])):
        tilted = sign * rotation(axis, small) @ Z
        (pair,) = relations([Z, tilted], [np.zeros(3), X]).pairs
        assert pair.relation == "parallel"
        assert pair.off_angle == pytest.approx(small, rel=1e-6)
        (pair,) = relations([Z, tilted], [np.zeros(3), Z]).pairs
        assert pair.relation == "coincident"
        assert pair.off_angle == pytest.approx(small, rel=1e-6)


@pytest.mark.parametrize("small", [*SMALL, 1e-12])
def test_shifted_axis_is_measured(small: float) -> None:
    """Two axes meant to meet, or to lie in one line, are off by the distance that one of them was shifted by."""
    (pair,) = relations([Z, X], [np.zeros(3), np.array([2.0, small, 3.0])]).pairs
    assert (pair.relation, pair.off_angle) == ("intersecting", 0.0)
    assert pair.off_distance == pytest.approx(small, rel=1e-6)
    (pair,) = relations([Z, Z], [np.zeros(3), np.array([0.0, small, 3.0])]).pairs
    assert (pair.relation, pair.off_angle) == ("coincident", 0.0)
    assert pair.off_distance == pytest.approx(small, rel=1e-6)


@pytest.mark.parametrize("small", SMALL)
def test_imperfect_triples_are_measured(small: float) -> None:
    """Of three axes with one tilted or shifted, the worst is off the common direction or point by a known share."""
    # The common direction is the mean of the three: the tilted one is 2/3 of the angle off it.
    (triple,) = relations([Y, rotation(Z, small) @ Y, -Y], [np.zeros(3), X, X + Z]).triples
    assert triple.relation == "parallel"
    assert triple.imperfection == pytest.approx(2.0 / 3.0 * small, rel=1e-5)
    # Point with the least squares from x, y, x axes: half way where two of them see the shift, a third where all do.
    for shift, share in ((Y, 1.0 / 2.0), (Z, 2.0 / 3.0)):
        (triple,) = relations([X, Y, X], [-X, Y, X + small * shift]).triples
        assert triple.relation == "meet"
        assert triple.imperfection == pytest.approx(share * small, rel=1e-6)


@pytest.mark.parametrize("small", SMALL)
def test_imperfection_of_the_family(small: float) -> None:
    """The arm stays in its family, off it by the angle and the distance of the relations that the family rests on."""
    for described, kind, row, share in ((industrial(), "wrist, 2||3", 2, 1.0), (ur_like(), "2||3||4, 5x6", 3, 2 / 3)):
        axes = described.axes.copy()
        axes[row] = rotation(X, small) @ axes[row]
        structure = structure_of(axes, described.points)
        assert structure.family == FAMILY[kind]
        assert structure.imperfection == pytest.approx((share * small, 0.0), rel=1e-5, abs=1e-15)
        # The columns keep their names, in an order that geometry gives, whatever more may be found beside them.
        assert sorted(structure.branches[:8]) == sorted(NAMED)
        assert len(set(structure.branches)) == structure.max_solutions
    for described, kind, shift, share in ((industrial(), "wrist, 2||3", Z, 2 / 3), (ur_like(), "2||3||4, 5x6", X, 1.0)):
        points = described.points.copy()
        points[5] += small * shift
        structure = structure_of(described.axes, points)
        assert structure.family == FAMILY[kind]
        assert structure.imperfection == pytest.approx((0.0, share * small), rel=1e-6, abs=1e-15)


def test_what_the_family_does_not_need_is_no_imperfection() -> None:
    """A shoulder offset, or a first axis that is tilted, leaves the family and its exactness."""
    wrist = industrial()
    axes, points = wrist.axes.copy(), wrist.points.copy()
    axes[0] = rotation(X, 1e-3) @ axes[0]
    points[1] += [1e-4, 0.0, 0.0]
    structure = structure_of(axes, points)
    assert structure.family == FAMILY["wrist, 2||3"]
    assert max(structure.imperfection) < 1e-13


def test_far_off_is_no_relation() -> None:
    """Axes that are degrees or centimetres off are not taken for what they nearly are."""
    wrist, parallel = industrial(), ur_like()
    points = wrist.points.copy()
    points[5] += 0.02 * Z
    structure = structure_of(wrist.axes, points)
    assert structure.triples == ()
    assert (structure.pairs[4].relation, structure.family) == ("skew", GENERAL)
    axes = parallel.axes.copy()
    axes[3] = rotation(X, 0.05) @ axes[3]
    structure = structure_of(axes, parallel.points)
    assert structure.triples == ()
    assert not structure.is_parallel(3)
    assert structure.family == GENERAL


@pytest.mark.parametrize("digits", [4, 5, 7])
def test_rounded_decimals(digits: int) -> None:
    """Frames turned by 1.5708 matter where the structure rests on them, and are then off by what the rounding is."""
    half = round(math.pi / 2.0, digits)
    turns = [0.0, -half, 0.0, -half, half, -half, 0.0]
    places = [(0, 0, 0.4), (0.05, 0, 0), (0.5, 0, 0), (0.03, 0.2, 0), (0, 0, 0.3), (0, 0, 0), (0, 0, 0.1)]
    origins = [(place, (turn, 0.0, 0.0)) for place, turn in zip(places, turns, strict=True)]
    structure = urdf_ik.load(serial_urdf("rounded", origins, [*[Z] * 6, None])).structure
    assert structure.family == FAMILY["wrist, 2||3"]
    assert max(structure.imperfection) < 1e-13
    # Now the elbow's own frame is turned there and back, by two numbers that do not agree.
    origins[2:3] = [(places[2], (half, 0.0, 0.0)), ((0, 0, 0), (-math.pi / 2.0, 0.0, 0.0))]
    structure = urdf_ik.load(serial_urdf("rounded", origins, [Z, Z, None, *[Z] * 4, None])).structure
    assert structure.is_parallel(2)
    assert structure.pairs[1].off_angle == pytest.approx(abs(math.pi / 2.0 - half), rel=1e-6)
    assert max(structure.pairs[i].off_distance for i in (3, 4)) < 1e-13


# ---------------------------------------------------------------- families


@pytest.mark.parametrize("orthogonal", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_family_of_every_kind(kind: str, orthogonal: bool) -> None:
    """Each kind of arm is put into its family, with the family's branches, exactly, whatever its proportions."""
    seeds = 0
    for seed in range(6):
        arm = urdf_ik.load(random_arm(kind, seed, orthogonal=orthogonal, aligned=bool(seed % 2)).urdf, "base", "tool")
        structure = arm.structure
        if max(pair.off_distance for pair in structure.pairs) > 1e-9:
            continue  # two random axes that all but meet
        seeds += 1
        assert structure.family == FAMILY[kind]
        # Geometry gives the names of shoulder and elbow to columns: see tests/ik/test_branch_names.py.
        assert sorted(structure.branches) == sorted(BRANCHES.get(structure.family, NAMED))
        assert structure.max_solutions == len(set(structure.branches)) == 8
        assert max(structure.imperfection) < 1e-13
        assert structure.method.startswith("Closed form")
    assert seeds >= 4


@pytest.mark.parametrize("kind", KINDS)
def test_base_signs_and_slides_do_not_matter(kind: str) -> None:
    """The same lines elsewhere, with axes turned round and frames slid along them, have the same structure."""
    described = of_kind(kind)
    expected = structure_of(described.axes, described.points)
    rng = np.random.default_rng([3, *kind.encode()])
    for _ in range(6):
        turn = rotation(rng.normal(size=3), rng.uniform(0.3, 3.0))
        signs = rng.choice([-1.0, 1.0], (6, 1))
        slid = described.points + rng.uniform(-2.0, 2.0, (6, 1)) * described.axes
        found = structure_of(signs * described.axes, slid, mount=(turn, rng.uniform(-3.0, 3.0, 3)))
        assert (found.family, sorted(found.branches)) == (expected.family, sorted(expected.branches))
        assert [p.relation for p in found.pairs] == [p.relation for p in expected.pairs]
        assert [(t.first, t.relation) for t in found.triples] == [(t.first, t.relation) for t in expected.triples]
        for pair, other in zip(found.pairs, expected.pairs, strict=True):
            assert math.sin(pair.angle) == pytest.approx(math.sin(other.angle), abs=1e-12)
            assert pair.distance == pytest.approx(other.distance, abs=1e-12)
        assert max(found.imperfection) < 1e-12


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("scale", [1e-3, 100.0])
def test_size_does_not_matter(kind: str, scale: float) -> None:
    """An arm of millimetres and one of a hundred metres belong to the family of the arm that they are copies of."""
    for seed in range(3):
        described = of_kind(kind, seed)
        expected = structure_of(described.axes, described.points)
        found = structure_of(described.axes, scale * described.points)
        assert (found.family, found.method) == (expected.family, expected.method)
        assert [p.relation for p in found.pairs] == [p.relation for p in expected.pairs]
        for pair, other in zip(found.pairs, expected.pairs, strict=True):
            assert pair.distance == pytest.approx(scale * other.distance, abs=1e-12 * scale)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 100.0])
def test_imperfection_counts_relative_to_the_size(scale: float) -> None:
    """A wrist that is off by 1e-4 of the arm's length nearly is one, in millimetres as in hundreds of metres."""
    wrist = industrial()
    points = wrist.points.copy()
    points[5] += 1e-4 * Z
    found = relations(wrist.axes, scale * points).triple(4, "meet")
    assert found is not None
    assert found.imperfection == pytest.approx(2.0 / 3.0 * 1e-4 * scale, rel=1e-6)


def test_far_from_its_base() -> None:
    """An arm that is mounted thirty metres from its base link has the family that it has at home."""
    for described, kind in ((industrial(), "wrist, 2||3"), (ur_like(), "2||3||4, 5x6")):
        mount = rotation(np.array([1.0, 2.0, 3.0]), 0.7), np.array([20.0, -20.0, 10.0])
        structure = structure_of(described.axes, described.points, mount=mount)
        assert structure.family == FAMILY[kind]
        assert max(structure.imperfection) < 1e-13


def test_no_closed_form() -> None:
    """Six axes without relations are a general arm with sixteen columns; with more than nine there is no family."""
    rng = np.random.default_rng(8)
    axes = rng.normal(size=(11, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    points = np.cumsum(rng.uniform(0.2, 0.6, (11, 3)), axis=0)
    for n in (10, 11):
        structure = structure_of(axes[:n], points[:n])
        assert structure.family == structure.method == ""
        assert (structure.branches, structure.max_solutions) == ((), 0)
        assert len(structure.pairs) == n - 1
        assert str(structure).startswith(f"{n} joints ({'R' * n}), of no family that is solved here.")
    structure = structure_of(axes[:6], points[:6])
    assert structure.family == GENERAL
    assert structure.max_solutions == len(set(structure.branches)) == 16
    assert {pair.relation for pair in structure.pairs} == {"skew"}


def test_sliding_joints() -> None:
    """A sliding joint has a direction, not a line: it may be parallel to a neighbour and is never in line with it."""
    kinds = ("revolute", "prismatic", "revolute")
    joints = [joint(f"j{i}", kind, f"l{i}", f"l{i + 1}", axis="0 0 1") for i, kind in enumerate(kinds)]
    structure = urdf_ik.load(robot(*joints)).structure
    assert [pair.relation for pair in structure.pairs] == ["parallel", "parallel"]
    assert structure.triples == ()
    assert str(structure).startswith("3 joints (RPR), of no family that is solved here. Axes 1 and 2 are parallel")
