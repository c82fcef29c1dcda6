"""Measures for the choice of a solution: distance from a reference, and quality."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.solutions.limits import LIMIT_TOLERANCE
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics.chain import Chain
from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN
from urdf_ik.support.text import quoted
from urdf_ik.support.tolerances import LARGEST

Array = NDArray[np.float64]
Metric = Literal["l2", "max", "time"]

METRICS: tuple[Metric, ...] = ("l2", "max", "time")
"""Distances of joint vectors: sqrt(sum of weight * difference^2), the greatest weight * |difference|, and the greatest
weight * |difference| / speed [s] at the URDF's velocity limits."""

Quality = Literal["limits", "manipulability", "clearance"]

QUALITIES: tuple[Quality, ...] = ("limits", "manipulability", "clearance")
"""Measures of a solution by itself, of which more is better."""


@dataclass(frozen=True)
class Wish:
    """Where a link in the middle of an arm should be: a measure of solutions, see :meth:`IKSolutions.best`.

    Attributes:
        link: its name.
        place: (3,) m in the base, the point that its origin should be near to; None: it should be high, along z.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("srs_7r")
        >>> s = arm.ik(arm.fk([0.3, -0.5, 0.8, 1.4, 0.7, -0.2, 0.1]))
        >>> high = s.best(urdf_ik.Wish(arm.chain.links[4]))
        >>> len(high)
        1
    """

    link: str
    place: tuple[float, float, float] | None = None

    def scores(self, chain: Chain, q: Array) -> Array:
        """(k,) m for joint vectors (k, n): the height, or the negated distance from the place."""
        at = chain.link_poses(q)[self.link][..., :3, 3]
        return at[..., 2] if self.place is None else -np.linalg.norm(at - np.array(self.place), axis=-1)


def check_quality(by: Quality | Wish, chain: Chain) -> None:
    """Refuse an unknown measure of solutions, and a link that the arm does not have."""
    if not isinstance(by, Wish):
        inputs.choice(by, "by", QUALITIES)
        return
    if by.link not in chain.links:
        raise ArgumentError(f"no link is called {quoted(by.link)}; links: {', '.join(chain.links)}")
    if by.place is not None:
        inputs.array(by.place, "place", (3,))


@dataclass(frozen=True, eq=False)
class Measure:
    """A distance of joint vectors, and how far each joint may be away at all.

    Attributes:
        metric: one of ``METRICS``.
        factors: (n,) of squared differences for 'l2', of differences for the others.
        within: (n,) rad or m, greatest difference of each joint that counts; None: all do.
    """

    metric: Metric
    factors: Array
    within: Array | None = None

    def distance(self, difference: Array) -> Array:
        """(...) of differences (..., n), infinite for NaN rows."""
        if self.metric == "l2":
            total = np.sqrt((self.factors * difference * difference).sum(axis=-1))
        else:
            total = (self.factors * np.abs(difference)).max(axis=-1, initial=0.0)
        return np.where(np.isnan(total), np.inf, total)

    def beyond(self, difference: Array) -> Array:
        """(...) rad or m by which the farthest joint of differences (..., n) is beyond ``within``, 0 inside it.

        The rounding that the contract grants to a solution is not counted.
        """
        if self.within is None:
            return np.zeros(difference.shape[:-1])
        out = (np.abs(difference) - self.within - LIMIT_TOLERANCE).max(axis=-1, initial=0.0)
        return np.asarray(out)


def measure(solver: Solver, metric: str, weights: ArrayLike | None, within: ArrayLike | None) -> Measure:
    """A distance for the joint vectors of an arm."""
    names = solver.joint_names
    each = np.ones(len(names)) if weights is None else per_joint("weights", weights, names, (0.0,))
    inputs.choice(metric, "metric", METRICS)
    if metric == "time":
        speeds = solver.velocity_limits
        if unknown := [repr(name) for name, speed in zip(names, speeds, strict=True) if np.isinf(speed)]:
            raise ArgumentError(
                f"metric='time' needs the greatest speed of every joint, and the URDF gives none for "
                f"{', '.join(unknown)}; write velocity=... into <limit>, or take metric='max' with weights of 1 / speed"
            )
        each = each / speeds
    return Measure(metric, each, None if within is None else per_joint("within", within, names, (0.0, np.inf)))  # type: ignore[arg-type]


def difference(q: Array, q_ref: Array, round_joints: NDArray[np.bool_] | Array) -> Array:
    """How far joint vectors are from a reference.

    Args:
        q: (..., n) rad or m.
        q_ref: (..., n) rad or m, which broadcasts against ``q``.
        round_joints: (n,) joints whose difference is taken on the circle, at most pi; a number: so many turns round.

    Returns:
        (..., n) rad or m.
    """
    apart: Array = np.asarray(q - q_ref)
    once_round = TURN * np.asarray(round_joints, dtype=np.float64)
    return apart - once_round * np.rint(apart / np.where(once_round, once_round, 1.0))


def least_columns(values: Array, n: int) -> NDArray[np.intp]:
    """(..., n) columns of the n least of values (..., B), the least first, ties by column."""
    if n == 1:
        return np.asarray(np.argmin(values, axis=-1, keepdims=True))
    return np.argsort(values, axis=-1, kind="stable")[..., :n]


def reference(q_ref: ArrayLike, names: Sequence[str], batch: tuple[int, ...]) -> Array:
    """``q_ref`` as (n,) or (..., n) finite float64, for poses of the shape ``batch``."""
    array = inputs.real(q_ref, "q_ref", f"an array of numbers (..., {len(names)})")
    if array.shape[-1:] != (len(names),):
        raise ArgumentError(f"q_ref has the shape {array.shape}; the arm has {len(names)} joints: {', '.join(names)}")
    array = inputs.array(array, "q_ref", (..., len(names)))
    try:
        np.broadcast_to(array, (*batch, array.shape[-1]))
    except ValueError:
        raise ArgumentError(
            f"q_ref has the shape {array.shape} and the poses {batch}: one joint vector, or one a pose"
        ) from None
    return array


def per_joint(name: str, value: ArrayLike, names: Sequence[str], also: tuple[float, ...] = (np.inf,)) -> Array:
    """Numbers (n,), one for each joint, from one number or from n.

    They lie between 1e-15 and 1e15, so that their squares and inverses neither overflow nor vanish, or are among
    ``also``.
    """
    numbers = inputs.real(value, name, f"a number, or one for each of {', '.join(names)}")
    fits = numbers.shape in ((), (1,), (len(names),))
    numbers = np.broadcast_to(numbers if fits else np.nan, (len(names),)).copy()
    if not ((numbers >= 1.0 / LARGEST) & (numbers <= LARGEST) | np.isin(numbers, also)).all():
        sign = "zero or positive" if 0.0 in also else "positive"
        raise ArgumentError(
            f"{name} is {np.asarray(value).tolist()}; a {sign} number between {1.0 / LARGEST:g} and {LARGEST:g} is "
            f"needed, or one for each of {', '.join(names)}"
        )
    return numbers
