"""The picture of intervals: bars and ends where they are; never how it looks."""

import numpy as np
import pytest
from matplotlib.collections import LineCollection

import urdf_ik
from urdf_ik.show import plot

Q = [0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]


def test_bars_and_ends_are_where_the_intervals_are() -> None:
    """Each interval is a bar from end to end in the row of its branch, in degrees or rad."""
    arm = urdf_ik.load("srs_7r")
    found = arm.intervals(arm.fk(Q))
    for degrees, scale in ((True, 180.0 / np.pi), (False, 1.0)):
        (axes,) = plot.intervals(found, degrees=degrees).axes
        names = [label.get_text() for label in axes.get_yticklabels()]
        bars = [each for each in axes.collections if isinstance(each, LineCollection)]
        drawn = set()
        for bar in bars:
            points = np.concatenate(bar.get_segments())
            drawn.add((names[int(points[0, 1])], *np.round([points[:, 0].min(), points[:, 0].max()], 6)))
        for each in found:
            assert (each.branch, *np.round([scale * each.low, scale * each.high], 6)) in drawn


def test_a_bar_covers_the_values_with_solutions() -> None:
    """Those of the parameter at which its branch has a solution inside the limits, and no others."""
    arm = urdf_ik.load("srs_7r")
    T = arm.fk(Q)
    (axes,) = plot.intervals(arm.intervals(T), degrees=False).axes
    names = [label.get_text() for label in axes.get_yticklabels()]
    drawn = [np.concatenate(each.get_segments()) for each in axes.collections if isinstance(each, LineCollection)]
    values = np.linspace(-np.pi, np.pi, 200)
    kept = arm.ik(T, redundancy=values).within_limits().valid
    for row, name in enumerate(names):
        covered = np.zeros(len(values), dtype=bool)
        for bar in drawn:
            covered |= (bar[0, 1] == row) & (values >= bar[0, 0]) & (values <= bar[-1, 0])
        np.testing.assert_array_equal(covered, kept[:, arm.structure.branches.index(name)])


def test_a_batch_and_a_pose_out_of_reach() -> None:
    """A batch is refused in words; without intervals the picture is empty."""
    arm = urdf_ik.load("srs_7r")
    with pytest.raises(urdf_ik.ArgumentError, match="single pose"):
        plot.intervals(arm.intervals(arm.fk([Q, Q])))
    (axes,) = plot.intervals(arm.intervals(urdf_ik.pose([50.0, 0.0, 0.0]))).axes
    assert not axes.collections
