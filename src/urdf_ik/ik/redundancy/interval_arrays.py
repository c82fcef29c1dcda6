"""Intervals of the redundancy parameter as arrays, with the causes of their ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

CAUSES = ("none", "fold", "reach", "singularity", "limit", "contact", "range")
"""Why an interval ends: 'none': it does not, it is the whole circle, or a part of a curve that passes some values more
than once; 'fold': two branches become one and end there; 'reach': the same, and beyond it no branch has a solution;
'singularity': the joints could not be followed further; 'limit': of a joint; 'contact': two bodies touch; 'range': the
parameter's values end there."""


@dataclass(frozen=True)
class End:
    """Why an interval ends.

    Attributes:
        cause: one of ``CAUSES``.
        joint: whose limit it is, for 'limit'.
        upper: whether it is the upper limit, for 'limit'.
        pair: the two that touch, for 'contact': links or obstacles.

    Example:
        >>> str(End("limit", "elbow", upper=True))
        "upper limit of joint 'elbow'"
    """

    cause: str
    joint: str | None = None
    upper: bool | None = None
    pair: tuple[str, str] | None = None

    def __str__(self) -> str:
        if self.cause == "limit":
            return f"{'upper' if self.upper else 'lower'} limit of joint {quoted(self.joint)}"
        if self.cause == "contact" and self.pair is not None:
            return f"contact of {quoted(self.pair[0])} and {quoted(self.pair[1])}"
        return {
            "none": "no end",
            "fold": "fold",
            "reach": "edge of reach",
            "singularity": "singularity",
            "contact": "contact",
            "range": "end of the parameter's range",
        }[self.cause]


@dataclass(frozen=True, eq=False)
class Found:
    """Intervals as arrays, of k intervals.

    Attributes:
        pose: (k,) number of the pose.
        low: (k,) rad or m.
        high: (k,) rad or m.
        column: (k,) of the solver, in the middle.
        ends: (k, 2) both ends of each, End.
        first: (k,) its first sample.
        count: (k,) its samples, of growing value.
        value: (s,) rad or m, of samples on the curves, the ends of every interval among them.
        q: (s, n) rad or m.
        core: (s, 17) the samples as the compiled core has them.
    """

    pose: NDArray[np.intp]
    low: Array
    high: Array
    column: NDArray[np.intp]
    ends: NDArray[np.object_]
    first: NDArray[np.intp]
    count: NDArray[np.intp]
    value: Array
    q: Array
    core: Array

    def of(self, which: NDArray[np.intp]) -> Found:
        """Some of the intervals; the samples stay as they are."""
        return Found(
            self.pose[which], self.low[which], self.high[which], self.column[which], self.ends[which],
            self.first[which], self.count[which], self.value, self.q, self.core,
        )  # fmt: skip


def joined(parts: list[Found]) -> Found:
    """Several sets of intervals as one."""
    if len(parts) == 1:
        return parts[0]
    samples = np.cumsum([0, *(len(part.value) for part in parts)])

    def together(name: str) -> Any:
        return np.concatenate([getattr(part, name) for part in parts])

    first = np.concatenate([part.first + start for part, start in zip(parts, samples, strict=False)])
    return Found(
        together("pose"), together("low"), together("high"), together("column"), together("ends"), first,
        together("count"), together("value"), together("q"), together("core"),
    )  # fmt: skip
