"""The container of solutions: indexing, filters, images, the nearest, and the reason when there are none."""

from collections import namedtuple
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from urdf_ik import ArgumentError, UrdfIkError
from urdf_ik.ik.solutions import IKSolutions, Solution

Array = NDArray[np.float64]
PI = np.pi


class Chain(namedtuple("Chain", "joint_types")):
    """What solutions ask of a chain."""

    @property
    def image_turns(self):
        """(n,) turns after which a joint is in the same posture."""
        return np.array([float(kind != "prismatic") for kind in self.joint_types])


Nearest = namedtuple("Nearest", "links distance")
FakeSolver = namedtuple("FakeSolver", "name joint_names limits dof chain arm parameters", defaults=((),))


class FakeArm:
    """What solutions ask of the arm that they came from: its cell, and why a pose has none."""

    def __init__(self) -> None:
        self.cell = Hits()
        self.redundancy = None

    def explain(self, T: Array, redundancy: float | None = None) -> str:
        """The fake arm's reason for a pose without solutions."""
        return f"x = {T[0, 3]:g} m is out of reach"


class Hits:
    """A collision model in which the arm collides where its first joint is negative; remembers what it was asked."""

    def __init__(self) -> None:
        self.asked: list[Array] = []

    def in_collision(self, q: Array, margin: float = 0.0) -> NDArray[np.bool_]:
        """(k, n) to (k,): whether the first joint's value is below the margin."""
        self.asked.append(q)
        return q[..., 0] < margin

    def nearest_pair(self, q: Array) -> Nearest:
        """The two bodies that there are, as far apart as the first joint's value."""
        return Nearest(("arm", "wall"), max(float(q[0]), 0.0))

    def in_world(self, world: "Hits | None") -> "Hits":
        """What stands for the arm in a world."""
        return self if world is None else world


KINDS = ("revolute", "prismatic", "continuous")
LIMITS = np.array([[-2 * PI, 2 * PI], [-0.5, 0.5], [-np.inf, np.inf]])
BRANCHES = ("front", "front, flip", "back", "back, flip")
ARM: Any = FakeSolver("fake", ("turn", "slide", "spin"), LIMITS, 3, Chain(KINDS), FakeArm())


def arm_with(limits: object, kinds: tuple[str, ...] = KINDS) -> Any:
    """The fake arm with other limits."""
    return ARM._replace(limits=np.array(limits, dtype=np.float64), chain=Chain(kinds), arm=FakeArm())


def made(q: object, arm: Any = ARM, x: object = 0.0) -> IKSolutions:
    """Solutions (..., 4, 3) as a solver hands them over: NaN rows are invalid."""
    rows = np.array(q, dtype=np.float64)
    valid = ~np.isnan(rows).any(axis=-1)
    T = np.zeros((*rows.shape[:-2], 4, 4)) + np.eye(4)
    T[..., 0, 3] = x
    return IKSolutions(arm, T, rows, valid.astype(np.uint8), BRANCHES)


NONE = [np.nan] * 3
ONE = made([[1.0, 0.2, 3.0], NONE, [-2.0, 0.1, -3.0], [0.5, 0.9, 0.0]])
BATCH = made(np.random.default_rng(0).uniform(-3, 3, (2, 5, 4, 3)) * [1, 0.3, 1], x=np.arange(10).reshape(2, 5))


def test_a_single_pose_is_a_sequence_of_its_valid_solutions() -> None:
    """Iteration, len, indices and to_array agree, and skip the columns without a solution."""
    assert len(ONE) == ONE.count == 3
    assert [one.branch for one in ONE] == ["front", "back", "back, flip"]
    assert [one.index for one in ONE] == [0, 2, 3]
    np.testing.assert_array_equal([one.q for one in ONE], ONE.to_array())
    np.testing.assert_array_equal(ONE[-1].q, [0.5, 0.9, 0.0])
    assert isinstance(ONE[0], Solution)
    with pytest.raises(IndexError):
        ONE[3]
    with pytest.raises(ArgumentError, match="to_array"):
        ONE[:2]
    assert ONE
    assert not made([NONE] * 4)
    assert list(made([NONE] * 4)) == []
    assert made([NONE] * 4).to_array().shape == (0, 3)


@pytest.mark.parametrize(
    "index",
    [0, -1, slice(1), np.int64(1), (1, 2), (slice(None), 3), (0, slice(1, 4)), ..., (..., 2), None,
     np.array([1, 0, 1]), ([0, 1], [2, 3]), np.arange(10).reshape(2, 5) > 6,
     (1, np.array([True, False, True, True, False])), [], ()],
)  # fmt: skip
def test_a_batch_is_indexed_like_an_array_of_poses(index: Any) -> None:
    """Every NumPy index gives the solutions of the poses that it gives of the array of poses."""
    expected = np.arange(10).reshape(2, 5)[index]
    for s in (BATCH, BATCH.within_limits(), BATCH.turns(), BATCH.turns().nearest([0, 0, 0], n=2)):
        got = s[index]
        assert got.shape == got.count.shape == expected.shape
        np.testing.assert_array_equal(got.poses[..., 0, 3], expected)
        np.testing.assert_array_equal(got.q, s.q.reshape(10, *s.q.shape[2:])[expected])
        np.testing.assert_array_equal(got.valid, s.valid.reshape(10, -1)[expected])
        np.testing.assert_array_equal(got.names, s.names.reshape(10, -1)[expected])
        np.testing.assert_array_equal(got.origin, s.origin.reshape(10, -1)[expected])
        assert got.branches == s.branches
        assert got.filters == s.filters


def test_arrays_are_read_only() -> None:
    """Nothing that the container hands out can be written to; the caller's poses stay writeable."""
    T = np.eye(4)
    s = IKSolutions(ARM, T, np.zeros((4, 3)), np.ones(4, np.uint8), BRANCHES)
    for array in (s.q, s.valid, s.singular, s.poses, next(iter(s)).q, s.turns().q):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    T[0, 3] = 1.0


def test_within_limits_gives_the_image_inside() -> None:
    """An angle outside becomes its image inside, 5.28 for -1 in [0, 2 pi]; a solution without one is dropped."""
    arm = arm_with([[0.0, 2 * PI], [-0.5, 0.5], [-np.inf, np.inf]])
    s = made([[-1.0, 0.2, 3.0], [1.0, 0.7, 0.0], [2.0, 0.5, -3.0], NONE], arm).within_limits()
    np.testing.assert_allclose(s.q, [[2 * PI - 1.0, 0.2, 3.0], NONE, [2.0, 0.5, -3.0], NONE])
    assert s.valid.tolist() == [True, False, True, False]
    assert (s.branches, s.filters, s.origin.tolist()) == (BRANCHES, ("limits",), [0, 1, 2, 3])
    assert made([[1.0, 0.7, 0.0]] * 4, arm).within_limits(tol=0.3).valid.all()
    assert not made([[1.0, 0.4, 0.0]] * 4, arm).within_limits(tol=-0.2).valid.any()
    # A prismatic joint has no images, however wide its limits are.
    wide = arm_with([[-1, 1], [5.0, 9.0], [-1, 1]], ("revolute", "prismatic", "revolute"))
    assert not made([[0.0, 0.0, 0.0]] * 4, wide).within_limits().valid.any()


def test_turns_of_one_pose() -> None:
    """Every image has a column with its turns in the name, the columns of a branch together."""
    s = ONE.turns()
    assert s.q.shape == (8, 3)
    expected = {
        "front": 1.0, "front [q1-360°]": 1.0 - 2 * PI, "back": -2.0, "back [q1+360°]": -2.0 + 2 * PI
    }  # fmt: skip
    assert {one.branch: one.q[0] for one in s} == pytest.approx(expected)
    assert [s.branches[one.index] for one in s] == [one.branch for one in s]
    assert s.origin.tolist() == [0, 0, 1, 1, 2, 2, 3, 3]
    # 0.9 m is outside the slide's limits and has no images.
    assert not s.valid[s.origin == 3].any()
    assert s.turns() is s
    assert s.within_limits().valid.tolist() == s.valid.tolist()


def test_turns_of_a_batch_have_the_same_columns() -> None:
    """A column's name tells its turns if all poses share them, else the image's number; ``names`` always tells them."""
    q = np.array([[[1.0, 0, 0]] * 4, [[-1.0, 0, 0]] * 4])
    s = made(q).turns()
    assert s.branches[:2] == ("front", "front [q1 image 2]")
    assert s.names[:, 1].tolist() == ["front [q1-360°]", "front [q1+360°]"]
    assert s[0].branches == s.branches
    assert [one.branch for one in s[1]][1] == "front [q1+360°]"
    for i in range(2):
        np.testing.assert_array_equal(s[i].q, made(q[i]).turns().q)
    assert made(q[:1]).turns().branches[1] == "front [q1-360°]"
    # What within_limits has turned already counts.
    shifted = made([[-1.0, 0, 0]] * 4, arm_with([[1.0, 15.0], [-1, 1], [-1, 1]])).within_limits().turns()
    assert shifted.branches[:2] == ("front [q1+360°]", "front [q1+720°]")
    assert len(set(shifted.branches)) == len(shifted.branches)


def test_nearest_goes_round_angles_and_never_along_a_slide() -> None:
    """Where turns do not count a whole turn is no distance, and a slide's 6.28 m is as far as it is."""
    s = made([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], NONE, NONE])
    assert s.nearest([2 * PI, 2 * PI, -2 * PI], modulo_turns=True)[0].branch == "front, flip"


def test_collision_free_asks_about_the_solutions_only() -> None:
    """Colliding solutions are dropped; NaN rows are not checked; a world is checked in place of the bare arm."""
    arm = arm_with(LIMITS)
    s = made(ONE.q, arm).collision_free()
    assert s.valid.tolist() == [True, False, False, True]
    assert np.isnan(s.q[2]).all()
    assert s.filters == ("collision",)
    assert np.isfinite(np.concatenate(arm.arm.cell.asked)).all()
    assert made(ONE.q, arm).collision_free(margin=0.7).valid.tolist() == [True, False, False, False]
    other: Any = Hits()
    made(np.stack([ONE.q, -ONE.q]), arm).collision_free(other)
    assert len(other.asked) == 1
    for margin in (-0.1, np.nan, np.inf):
        with pytest.raises(UrdfIkError, match="margin"):
            ONE.collision_free(margin=margin)


def test_filters_compose_in_any_order() -> None:
    """Limits, collisions and turns commute where their meanings do, and the record keeps their order."""
    arm = arm_with([[-2 * PI, 2.0], [-0.5, 0.5], [-np.inf, np.inf]])
    s = made(ONE.q, arm)
    a, b = s.within_limits().collision_free(), s.collision_free().within_limits()
    np.testing.assert_array_equal(a.q, b.q)
    assert a.filters == ("limits", "collision")
    assert b.filters == ("collision", "limits")
    turned = s.turns().nearest([-5.0, 0.0, 0.0])
    assert turned.filters == ("turns", "nearest")
    assert turned[0].branch == "front [q1-360°]"
    assert turned.nearest([0, 0, 0])[0].branch == "front [q1-360°]"
    assert turned.origin.tolist() == [0]


def test_explain_says_who_dropped_the_solutions() -> None:
    """The reason is the arm's where there never was a solution, else the filter that dropped the last one."""
    arm = arm_with([[-0.5, 0.5], [-0.5, 0.5], [-np.inf, np.inf]])
    none = made([NONE] * 4, arm, x=7.0)
    assert none.explain() == "x = 7 m is out of reach"
    assert none.within_limits().turns().nearest([0, 0, 0]).explain() == "x = 7 m is out of reach"
    assert ONE.explain() == ""
    s = made([[0.8, 0.2, 0.0], [-0.6, 0.53, 0.0], NONE, [2.0, 0.0, 0.0]], arm)
    why = s.within_limits().collision_free().nearest([0, 0, 0]).explain()
    assert why.startswith("3 solutions reach the pose, none inside the joint limits; the closest, front, flip, has ")
    assert "'turn' at -0.6000 rad, 0.1 rad beyond its lower limit of -0.5000 rad" in why
    assert "'slide' at 0.5300 m, 0.03 m beyond its upper limit of 0.5000 m" in why
    assert "spin" not in why
    assert s.turns().explain() == s.within_limits().explain()
    assert "with a margin of 0.1 rad" in made([[0.45, 0, 0]] * 4, arm).within_limits(tol=-0.1).explain()
    colliding = made([[-0.2, 0.0, 0.0], [-0.7, 0, 0], NONE, NONE], arm)
    hits = "2 solutions reach the pose, and every one is in collision; in the first, front, these are "
    assert colliding.collision_free().explain() == f"{hits}'arm' and 'wall'"
    inside = colliding.within_limits().collision_free().explain()
    assert inside.startswith("1 solution reaches the pose inside the joint limits, and every one is in collision; ")
    assert "0.01 m" in colliding.collision_free(margin=0.01).explain()


def test_explain_of_a_batch_has_a_line_for_each_pose_without_solution() -> None:
    """A batch gives a line for each pose that has no solution, which begins with the pose's index; '' without one."""
    q = np.full((2, 2, 4, 3), np.nan)
    q[0, 1, 0] = 0.0
    lines = made(q, x=[[1, 2], [3, 4]]).explain().splitlines()
    out = "x = {} m is out of reach"
    assert lines == [f"pose {[i, j]}: {out.format(x)}" for i, j, x in ((0, 0, 1), (1, 0, 3), (1, 1, 4))]
    assert made(q[0], x=[1, 2]).explain() == f"pose [0]: {out.format(1)}"
    assert made(q[0, 1:], x=[2]).explain() == ""
