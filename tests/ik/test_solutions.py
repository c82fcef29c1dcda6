"""The container of solutions: indexing, filters, images, the nearest, and the reason when there are none."""

import math
from typing import Any

import numpy as np
import pytest
from fake_solutions import (
    ARM,
    BATCH,
    BRANCHES,
    LIMITS,
    NONE,
    ONE,
    PI,
    Hits,
    arm_with,
    made,
)
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from urdf_ik import ArgumentError, UrdfIkError
from urdf_ik.ik.solutions import IKSolutions, Singular, Solution

Array = NDArray[np.float64]


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


def test_flags_are_read_from_the_info_bits() -> None:
    """Bit 0 is valid, bits 1 to 4 are the singular flags."""
    info = np.array([1, 0, 1 | Singular.WRIST << 1, 1 | (Singular.SHOULDER | Singular.OTHER) << 1], np.uint8)
    s = IKSolutions(ARM, np.eye(4), np.zeros((4, 3)), info, BRANCHES)
    assert s.valid.dtype == np.bool_
    assert s.valid.tolist() == [True, False, True, True]
    assert s.singular.tolist() == [0, 0, 4, 9]
    assert [one.singular for one in s] == [Singular(0), Singular.WRIST, Singular.SHOULDER | Singular.OTHER]
    assert "singular: wrist" in str(s)
    assert str(list(s)[1]).endswith("(singular: WRIST)")


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
    assert s.singular.tolist() == [0, 0, 0, 0]
    assert s.branches == BRANCHES
    assert s.filters == ("limits",)
    np.testing.assert_array_equal(s.origin, range(4))
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


@given(st.lists(st.tuples(*[st.floats(-PI, PI)] * 3), min_size=4, max_size=4), st.tuples(*[st.floats(-9, 9)] * 3))
def test_nearest_is_the_least_distance(rows: list[tuple[float, float, float]], q_ref: tuple[float, ...]) -> None:
    """No solution is nearer than the chosen one: on the circle if asked for, plain for lengths, and along turns."""
    weights = (2.0, 0.5, 1.0)

    def apart(q: Array, wound: bool) -> float:
        circle = [abs(math.remainder(a - b, 2 * PI)) for a, b in zip(q, q_ref, strict=True)]
        plain = [abs(a - b) for a, b in zip(q, q_ref, strict=True)]
        parts = (plain[0] if wound else circle[0], plain[1], circle[2])
        return math.sqrt(sum(w * d * d for w, d in zip(weights, parts, strict=True)))

    s = made(rows, arm_with([[-2 * PI, 2 * PI], [-4, 4], [-np.inf, np.inf]]))
    for wound, of in ((False, s), (True, s.turns())):
        picked = of.nearest(q_ref, weights, modulo_turns=True)
        far = sorted(apart(one.q, wound) for one in of)
        assert len(picked) == 1
        assert apart(picked[0].q, wound) == pytest.approx(far[0], abs=1e-12)
        several = of.nearest(q_ref, weights, n=3, modulo_turns=True)
        assert [apart(one.q, wound) for one in several] == pytest.approx(far[:3], abs=1e-12)
        assert picked[0].branch == several[0].branch
        np.testing.assert_array_equal(picked[0].q, of.q[list(of.names).index(picked[0].branch)])


def test_nearest_of_a_batch() -> None:
    """One reference for all poses or one for each; a pose without solutions stays empty."""
    q = BATCH.q.copy()
    q[1, 4] = np.nan
    q[0, 0, :3] = np.nan
    s = made(q)
    got = s.nearest([0.1, 0.2, 0.3])
    assert got.branches == ("nearest",)
    assert got.q.shape == (2, 5, 1, 3)
    assert not got.valid[1, 4, 0]
    assert got[0, 0][0].branch == "back, flip"
    assert got.origin[0, 0, 0] == 3
    for place in np.ndindex(2, 5):
        alone = s[place].nearest([0.1, 0.2, 0.3])
        np.testing.assert_array_equal(got.q[place], alone.q)
    # The reference is a solution itself: it is found for every pose.
    itself = BATCH.q[..., 2, :]
    np.testing.assert_array_equal(BATCH.nearest(itself).q[..., 0, :], itself)
    assert (BATCH.nearest(itself).origin == 2).all()


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


def test_explain_tells_the_image_that_is_least_far_out() -> None:
    """For a joint whose range lies beyond half a turn the image that comes nearest is named."""
    arm = arm_with([[4.0, 5.0], [-0.5, 0.5], [-np.inf, np.inf]])
    why = made([[-1.0, 0, 0]] * 4, arm).within_limits().explain()
    assert f"'turn' at {2 * PI - 1:.4f} rad, 0.2832 rad beyond its upper limit of 5.0000 rad" in why


def test_explain_of_a_batch_has_a_line_for_each_pose_without_solution() -> None:
    """A batch gives a line for each pose that has no solution, which begins with the pose's index; '' without one."""
    q = np.full((2, 2, 4, 3), np.nan)
    q[0, 1, 0] = 0.0
    lines = made(q, x=[[1, 2], [3, 4]]).explain().splitlines()
    out = "x = {} m is out of reach"
    assert lines == [f"pose {[i, j]}: {out.format(x)}" for i, j, x in ((0, 0, 1), (1, 0, 3), (1, 1, 4))]
    assert made(q[0], x=[1, 2]).explain() == f"pose [0]: {out.format(1)}"
    assert made(q[0, 1:], x=[2]).explain() == ""
