"""Axes of the families with three parallel axes at one end, or a spherical triple in the middle, for tests.

Each kind comes from both ends: the reversed axes make the same structure as seen from the tip.
"""

from collections.abc import Callable

import numpy as np
from arms import Maker, Screws, apart, leaning, length, sign, start
from numpy.typing import NDArray

Array = NDArray[np.float64]
Relation = Callable[[Array, Array, np.random.Generator, bool], tuple[Array, Array]]


def _skew(h: Array, p: Array, rng: np.random.Generator, orthogonal: bool) -> tuple[Array, Array]:
    """An axis that passes the axis (h, p) at a distance."""
    return leaning(h, rng, orthogonal=orthogonal), p + apart(rng)


def _meeting(h: Array, p: Array, rng: np.random.Generator, orthogonal: bool) -> tuple[Array, Array]:
    """An axis that meets the axis (h, p), but not in p."""
    return leaning(h, rng, orthogonal=orthogonal), p + length(rng) * h


def _crossing(h: Array, p: Array, rng: np.random.Generator, orthogonal: bool) -> tuple[Array, Array]:
    """An axis that meets the axis (h, p) in p."""
    return leaning(h, rng, orthogonal=orthogonal), p


def _in_line(h: Array, p: Array, rng: np.random.Generator, orthogonal: bool) -> tuple[Array, Array]:
    """An axis in one line with the axis (h, p)."""
    return sign(rng) * h, p + length(rng) * h


def _parallel(h: Array, p: Array, rng: np.random.Generator, orthogonal: bool) -> tuple[Array, Array]:
    """An axis parallel to the axis (h, p), of either sign."""
    return sign(rng) * h, p + apart(rng)


def _chain(*relations: Relation) -> Maker:
    """Axes, each with the given relation to the one before."""

    def screws(rng: np.random.Generator, orthogonal: bool) -> Screws:
        axes, points = [start(rng, orthogonal=orthogonal)], [np.zeros(3)]
        for relation in relations:
            h, p = relation(axes[-1], points[-1], rng, orthogonal)
            axes.append(h)
            points.append(p)
        return np.array(axes), np.array(points)

    return screws


def _middle(one: Relation, four: Relation, five: Relation) -> Maker:
    """Axes 2, 3 and 4 through one point; axis 1 by its relation to axis 2, axes 5 and 6 by theirs to the one before."""

    def screws(rng: np.random.Generator, orthogonal: bool) -> Screws:
        h2 = start(rng, orthogonal=orthogonal)
        h3 = leaning(h2, rng, orthogonal=orthogonal)
        h4 = leaning(h3, rng, orthogonal=orthogonal)
        centre = np.zeros(3)
        h1, p1 = one(h2, centre, rng, orthogonal)
        h5, p5 = four(h4, centre, rng, orthogonal)
        h6, p6 = five(h5, p5, rng, orthogonal)
        return np.array([h1, h2, h3, h4, h5, h6]), np.array([p1, centre, centre, centre, p5, p6])

    return screws


def _reversed(maker: Maker) -> Maker:
    """The same structure from the tip."""

    def screws(rng: np.random.Generator, orthogonal: bool) -> Screws:
        axes, points = maker(rng, orthogonal)
        return axes[::-1].copy(), points[::-1] - points[-1]

    return screws


PARALLEL_SHOULDER: dict[str, Maker] = {
    "1||2||3, 5x6": _chain(_parallel, _parallel, _skew, _skew, _meeting),
    "1||2||3, 3x4, 5x6": _chain(_parallel, _parallel, _meeting, _skew, _meeting),
    "1||2||3, 5||6": _chain(_parallel, _parallel, _skew, _skew, _parallel),
    "1||2||3, 4x5": _chain(_parallel, _parallel, _skew, _meeting, _skew),
    "1||2||3, 4x5, 5x6": _chain(_parallel, _parallel, _skew, _meeting, _meeting),
    "1||2||3, 4x5, 5||6": _chain(_parallel, _parallel, _skew, _meeting, _parallel),
    "1||2||3, 4||5": _chain(_parallel, _parallel, _skew, _parallel, _skew),
    "1||2||3, 4||5, 5x6": _chain(_parallel, _parallel, _skew, _parallel, _meeting),
    "1||2||3": _chain(_parallel, _parallel, _skew, _skew, _skew),
    "1||2||3, 3x4": _chain(_parallel, _parallel, _meeting, _skew, _skew),
}
SPHERICAL_MIDDLE: dict[str, Maker] = {
    "2x3x4, 5x6": _middle(_skew, _skew, _meeting),
    "2x3x4, 1x2, 4x5, 5x6": _middle(_meeting, _meeting, _meeting),
    "2x3x4, 1||2, 5x6": _middle(_parallel, _skew, _meeting),
    "2x3x4, 5||6": _middle(_skew, _skew, _parallel),
    "2x3x4, 1||2, 4x5, 5||6": _middle(_parallel, _meeting, _parallel),
    "2x3x4, 4||5||6": _middle(_skew, _parallel, _parallel),
    "2x3x4": _middle(_skew, _skew, _skew),
    "2x3x4, 1x2, 4x5": _middle(_meeting, _meeting, _skew),
    "2x3x4, 1||2, 4||5": _middle(_parallel, _parallel, _skew),
}
KINDS: dict[str, Maker] = {
    name + end: _reversed(maker) if end else maker
    for kinds in (PARALLEL_SHOULDER, SPHERICAL_MIDDLE)
    for name, maker in kinds.items()
    for end in ("", ", reversed")
}
"""Every family's conditions in words, with what makes axes and points that fulfil them and no further ones."""

TWICE: dict[str, Maker] = {"2x3x4, 4x5x6": _middle(_skew, _meeting, _crossing)}
"""Arms that two families take: here a spherical wrist, but with a quartic, and a spherical middle without one."""

DEGENERATE: dict[str, Maker] = {
    "1||2||3||4": _chain(_parallel, _parallel, _parallel, _skew, _skew),
    "1||2||3, 4||5||6": _chain(_parallel, _parallel, _skew, _parallel, _parallel),
    "1||2||3, 4x5x6": _chain(_parallel, _parallel, _skew, _crossing, _crossing),
    "1||2||3, 4 = 5": _chain(_parallel, _parallel, _skew, _in_line, _skew),
    "2x3x4x5": _middle(_skew, _crossing, _skew),
    "1x2x3x4": _middle(_crossing, _skew, _skew),
    "2x3x4, 5 = 6": _middle(_skew, _skew, _in_line),
}
"""Arms that have the families' axes and are singular in every pose."""
