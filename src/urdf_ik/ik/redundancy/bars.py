"""Intervals as bars for drawings: one row a branch, with margins to the joint limits and the causes of the ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from urdf_ik.ik.redundancy.intervals import Interval, Intervals
from urdf_ik.ik.solutions import limits
from urdf_ik.support.angles import TURN
from urdf_ik.typing import Array

ENDS = {
    "limit": ("#0072b2", "a joint's limit"),
    "fold": ("#d55e00", "fold: two branches become one"),
    "reach": ("#000000", "edge of reach"),
    "contact": ("#cc79a7", "contact"),
    "singularity": ("#e69f00", "singularity"),
    "range": ("#009e73", "end of the parameter's range"),
    "none": ("#999999", "the whole circle"),
}
"""Colours of what ends an interval, and words for it: those of Okabe and Ito, which the colour-blind tell apart."""


@dataclass(frozen=True)
class Bar:
    """One interval, or the part of it that goes on from the other side of half a turn.

    Attributes:
        row: of its branch.
        interval: which it is.
        value: (k,) rad or m, ascending.
        margin: (k - 1,) between them, how far the nearest joint is from its limits: 0 at a limit, 1 in the middle.
        ends: places [rad or m] and causes of the ends, without those of a whole circle.
    """

    row: int
    interval: Interval
    value: Array
    margin: Array
    ends: tuple[tuple[float, str], ...]


def bars(found: Intervals) -> tuple[list[str], list[Bar]]:
    """Names of the branches that have intervals, in the arm's order, and the bars of a single pose.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("srs_7r")
        >>> names, drawn = bars(arm.intervals(arm.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1])))
        >>> len(names), len(drawn) >= 26
        (8, True)
    """
    solver, every = found.solver, list(found)
    names = [name for name in solver.structure.branches if any(each.branch == name for each in every)]
    turning = ~solver.chain.prismatic
    drawn = []
    for k, each in enumerate(every):
        value, q = found.samples(k)
        inmost, _ = limits.image_inmost(q, solver.limits, turning)
        margin = np.clip(np.nan_to_num(limits.margin(inmost, solver.limits)), 0.0, 1.0)
        # What passes half a turn goes on from the other side.
        for turn in (0.0, TURN) if found.parameter.unit == "rad" and each.high > np.pi else (0.0,):
            ends = tuple(
                (at - turn, end.cause)
                for end, at in zip(each.ends, (each.low, each.high), strict=True)
                if end.cause != "none"
            )
            drawn.append(Bar(names.index(each.branch), each, value - turn, 0.5 * (margin[:-1] + margin[1:]), ends))
    return names, drawn
