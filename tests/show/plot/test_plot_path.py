"""The picture of a path: what is drawn where, and how it is called; never how it looks."""

from pathlib import Path

import numpy as np
import pytest
from command import ARM, call, succeed
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from pictures import is_png
from seams import blocked_plan, seam

import urdf_ik
from urdf_ik import Arm, Plan
from urdf_ik.show import plot
from urdf_ik.show.plot.waypoints import background

TURN = 2.0 * np.pi


@pytest.fixture(name="plan")
def _plan(arm: Arm) -> Plan:
    return arm.follow(seam())


@pytest.fixture(name="blocked")
def _blocked(arm: Arm) -> Plan:
    return blocked_plan(arm)


def labels(figure: Figure) -> list[str]:
    """What the legend says."""
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_each_joint_has_a_panel_with_its_limits_and_the_plan(arm: Arm, plan: Plan) -> None:
    """Names and units, limits as lines in the range that is shown, and the plan's joint values at their waypoints."""
    for degrees, unit, scale in ((True, "deg", 180.0 / np.pi), (False, "rad", 1.0)):
        figure = plot.path(plan, degrees=degrees)
        panels = {axes.get_title(loc="left"): axes for axes in figure.axes}
        assert list(panels) and sorted(panels) == [f"{name} [{unit}]" for name in arm.joint_names]
        for k, name in enumerate(arm.joint_names):
            axes = panels[f"{name} [{unit}]"]
            lines = [np.array(line.get_data()) for line in axes.lines]
            np.testing.assert_allclose(
                [y[0] for _, y in (line for line in lines if np.array_equal(line[0], [0, 1]))], scale * arm.limits[k]
            )
            (drawn,) = [line for line, art in zip(lines, axes.lines, strict=True) if art.get_linewidth() == 1.8]
            np.testing.assert_allclose(drawn, [plan.place, scale * plan.motion[:, k]])
            low, high = axes.get_ylim()
            assert low < scale * arm.limits[k, 0] and scale * arm.limits[k, 1] < high
        assert "the plan" in labels(figure) and not figure.axes[0].patches[2:]


def test_the_thin_lines_are_solutions_of_the_waypoints(arm: Arm, plan: Plan) -> None:
    """Every end of every piece is a joint value, up to turns, of a solution of its waypoint; no branch is missing."""
    solutions = arm.ik(plan.poses)
    for k, axes in enumerate(sorted(plot.path(plan, degrees=False).axes, key=lambda each: each.get_title(loc="left"))):
        (curves,) = [each for each in axes.collections if isinstance(each, LineCollection)]
        ends = np.concatenate(curves.get_segments())
        apart = ends[:, 1, None] - solutions.q[ends[:, 0].astype(int), :, k]
        apart -= TURN * np.round(apart / TURN)
        assert np.nanmin(np.abs(apart), axis=1).max() < 1e-12
        assert len({tuple(colour[:3]) for colour in curves.get_colors()}) >= len(solutions.branches)


def test_where_there_is_no_plan_the_ends_are_marked(blocked: Plan) -> None:
    """Each start branch has a line at its last waypoint; its cause is in the legend."""
    figure = plot.path(blocked, degrees=False)
    said = labels(figure)
    assert "the plan" not in said and {"in contact", "no solution of use"} <= set(said)
    for stop in blocked.stops:
        assert f"{stop.branch}: ends before {stop.waypoint} ({stop.cause})" in said
        assert any(np.array_equal(line.get_xdata(), [stop.waypoint - 1] * 2) for line in figure.axes[0].lines)


def test_what_is_shaded_is_closed(arm: Arm, blocked: Plan) -> None:
    """At a shaded waypoint every solution inside the limits touches something; at any other one is free."""
    found = background(blocked)
    closed = found.closed
    axes = plot.path(blocked).axes[0]
    bands = [patch for patch in axes.patches if patch.get_height() == 1.0 and patch.get_alpha() is not None]
    shaded = np.zeros(len(blocked.poses), dtype=bool)
    for band in bands:
        x = band.get_x()
        shaded |= (found.at > x) & (found.at < x + band.get_width())
    assert np.array_equal(shaded, closed) and closed.any() and not closed.all()
    model = blocked.obstacles.model
    for k in (int(np.flatnonzero(closed)[0]), int(np.flatnonzero(~closed)[0])):
        kept = arm.ik(blocked.poses[k]).within_limits()
        assert bool(np.all(model.in_collision(kept.to_array()))) == closed[k]


def test_changes_of_branch_are_marked_and_the_curve_is_broken(arm: Arm) -> None:
    """One dotted line a change, and one more piece of the plan than places of change."""
    T = np.concatenate([seam(0.3, 10), urdf_ik.line(arm.fk([-2.5, 0.4, -1.2, 0.3, 0.9, 0.1]),
                                                         arm.fk([-2.6, 0.5, -1.1, 0.3, 0.9, 0.1]), 5)])  # fmt: skip
    plan = arm.follow(T, reconfigure=True)
    assert plan.changes
    figure = plot.path(plan)
    assert "change of branch" in labels(figure)
    axes = figure.axes[0]
    pieces = [line for line in axes.lines if line.get_linewidth() == 1.8]
    assert len(pieces) == 1 + len({change.waypoint for change in plan.changes})


def test_the_command_draws_it(arm: Arm, tmp_path: Path) -> None:
    """With the options of `path`; without waypoints, or of another picture, it says what is wrong."""
    np.save(tmp_path / "seam.npy", seam(0.4, 10))
    succeed("plot", ARM, "path", "-p", f"{tmp_path}/seam.npy", "-o", f"{tmp_path}/path.png")
    assert is_png((tmp_path / "path.png").read_bytes())
    for what, rest, words in (
        ("path", (), "--poses"),
        ("limits", ("-p", f"{tmp_path}/seam.npy"), "shows one pose, and 10 are given"),
    ):
        result = call("plot", ARM, what, *rest, "-o", f"{tmp_path}/path.png")
        assert result.exit_code == 2 and words in " ".join(result.output.split())
