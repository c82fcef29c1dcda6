"""Waypoints at which every solution touches something: they end every way, whatever the motions."""

from __future__ import annotations

import numpy as np

from urdf_ik.ik.redundancy.interval_search import span
from urdf_ik.paths.checked_settings import CheckedSettings
from urdf_ik.paths.planned_motion import EVERY_BRANCH, Stop
from urdf_ik.paths.planner import nodes as node_sets
from urdf_ik.typing import Array

FIRST, FINEST = 64, 256
"""Values of the parameter at which a waypoint is looked at: to find one, and to say that it is closed."""
RUNS = 4
"""Of how many parts of a path that touch the middle is looked at, the longest first."""
AT_ONCE = 64
"""Joint vectors that are looked at at a time: one that is clear ends the look."""


def grid_values(settings: CheckedSettings, T: Array, count: int) -> Array:
    """Values (count,) all over the range of the redundancy parameter, for poses (m, 4, 4)."""
    parameter = settings.solver.parameter
    assert parameter is not None  # only such arms are planned for on grids
    low, high = span(settings.solver, parameter, T)
    return np.linspace(low, high, count, endpoint=not parameter.round)


def is_closed(settings: CheckedSettings, T: Array, count: int) -> bool:
    """Whether a pose (4, 4) has solutions inside the limits at so many values, and all of them touch something."""
    assert settings.obstacles is not None  # without obstacles nothing touches
    values = grid_values(settings, T[None], count)
    nodes = node_sets.solved(settings.solver, settings.joints, T[None], np.zeros(1, np.int64), values[None])
    # Neighbouring values touch alike: far ones come first.
    q = nodes.q[np.random.default_rng(0).permutation(len(nodes.q))]
    parts = (q[k : k + AT_ONCE] for k in range(0, len(q), AT_ONCE))
    return len(q) > 0 and not any(settings.obstacles.free(part).any() for part in parts)


def closed_waypoint(settings: CheckedSettings, path: Array, q: Array) -> Stop | None:
    """The end of every way at a closed waypoint, looked for where a way (m, n) touches; None where none is found.

    Of each part of the way that touches, the waypoint in the middle is looked at. From one that is closed, bisection
    leads towards the first one of that part.
    """
    assert settings.obstacles is not None  # without obstacles nothing touches
    touching = np.flatnonzero(~settings.obstacles.free(q))
    runs = [run for run in np.split(touching, np.flatnonzero(np.diff(touching) > 1) + 1) if len(run)]
    for run in sorted(runs, key=len, reverse=True)[:RUNS]:
        low, closed = int(run[0]) - 1, int(run[len(run) // 2])
        if not is_closed(settings, path[closed], FIRST):
            continue
        last = closed
        while closed - low > 1:
            middle = (low + closed) // 2
            if is_closed(settings, path[middle], FIRST):
                closed = middle
            else:
                low = middle
        for at in (closed, last):
            if is_closed(settings, path[at], FINEST):
                return _stop(settings, at, q[at])
    return None


def _stop(settings: CheckedSettings, at: int, q: Array) -> Stop:
    parameter, obstacles = settings.solver.parameter, settings.obstacles
    assert parameter is not None and obstacles is not None  # noqa: PT018 - both hold where a waypoint is closed
    pair = obstacles.pair(q)
    apart = "touch" if not obstacles.margin else f"come within {obstacles.margin:g} m of each other"
    bodies = f"{pair[0]} and {pair[1]} {apart}" if pair else f"links {apart}"
    reason = f"something touches in every solution at {FINEST} values of the {parameter.label}; in one of them {bodies}"
    return Stop(EVERY_BRANCH, at, "contact", reason)
