"""Joint limits: images of an angle 2 pi apart inside them, and how far a value is outside.

Pure functions over joint vectors (..., B, n), NaN rows where there is no solution. The limits are closed
intervals, widened by a tolerance: half a turn and limits such as 3.1416 or 3.14 mean what they say.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik import _core
from urdf_ik.errors import ArgumentError
from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN
from urdf_ik.support.text import quoted

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

LIMIT_TOLERANCE = 1e-9
"""How far [rad or m] a value may lie beyond a limit: the error that the contract grants to a solution."""
FAR = 50.0 * TURN
"""rad or m: a limit that is further off is drawn as if there were no limit."""
MAX_ENTRIES = 2**27
"""Greatest number of joint values that :func:`turns` puts into one array: one gigabyte."""


class _Turned(NamedTuple):
    """What :func:`turns` found.

    Attributes:
        q: (..., B * M, n) all images, column b * M + m; a branch's first column is what :func:`nearest_image`
            gives. NaN rows where there is no such image.
        valid: (..., B * M) bool.
        steps: one array (..., B, m_i) a joint: turns that its images are away from the value given, nearest
            first, NaN where there are fewer.
        ranks: (M, n) which of its images each joint has in the M columns of a branch.
    """

    q: Array
    valid: Mask
    steps: tuple[Array, ...]
    ranks: NDArray[np.intp]


def bounded(limits: Array) -> Array:
    """(n, 2) rad or m, the limits; infinite where they are so far off that they only mean that there is no limit."""
    return np.where(np.abs(limits) > FAR, np.copysign(np.inf, limits), limits)


def middle(limits: Array) -> Array:
    """(n,) rad or m, the middle of each joint's range; 0 for one without a limit on a side."""
    low, high = bounded(limits).T
    ends = np.isfinite(low) & np.isfinite(high)
    return 0.5 * (np.where(ends, low, 0.0) + np.where(ends, high, 0.0))


def room(q: Array, limits: Array) -> Array:
    """How far joint vectors (..., n) are inside the limits (n, 2), negative outside: (...) of the least joint."""
    low, high = limits.T
    return np.asarray(np.minimum(q - low, high - q).min(axis=-1, initial=np.inf))


def check_inside(q: Array, limits: Array, names: Sequence[str], what: str) -> None:
    """Refuse a joint vector (n,) that is outside the limits (n, 2) [rad or m]."""
    low, high = limits.T
    outside = (q < low - LIMIT_TOLERANCE) | (q > high + LIMIT_TOLERANCE)
    if outside.any():
        k = int(np.argmax(outside))
        raise ArgumentError(
            f"joint {quoted(names[k])} is at {q[k]:.9g}, outside its limits [{low[k]:.9g}, {high[k]:.9g}]: {what}"
        )


def drawn(limits: Array, turning: Mask) -> Array:
    """(n, 2) rad or m, the limits; where a limit is missing, half a turn or a metre from zero or from the other one.

    Args:
        limits: (n, 2) lower and upper, rad or m.
        turning: (n,) whether a joint turns; others slide.
    """
    far, (lower, upper) = np.where(turning, 0.5 * TURN, 1.0), bounded(limits).T
    low = np.where(np.isfinite(lower), lower, np.minimum(-far, upper - far))
    high = np.where(np.isfinite(upper), upper, np.maximum(far, lower + far))
    return np.stack([low, high], axis=-1)


def image_range(q: Array, limits: Array, turning: Mask | Array, tol: float = LIMIT_TOLERANCE) -> tuple[Array, Array]:
    """First and last k for which ``q + 2 pi k`` is inside the limits, exactly as floating point adds them.

    A joint that does not turn (prismatic), or without a limit on a side (continuous), has at most one
    image: itself, or the nearest to it that is inside.

    Args:
        q: (..., n) rad or m.
        limits: (n, 2) lower and upper, rad or m.
        turning: (n,) whether 2 pi more is the same posture; a number: so many turns more, where joints mimic others.
        tol: rad or m by which a limit may be exceeded; negative: the margin to keep from it.

    Returns:
        Two arrays (..., n) of whole numbers; first > last where no image is inside.
    """
    return _core.image_range(np.ascontiguousarray(q), *_bounds(limits, turning, tol))


def nearest_image(q: Array, limits: Array, turning: Mask | Array, tol: float = LIMIT_TOLERANCE) -> tuple[Array, Mask]:
    """The image inside the limits that is fewest turns from each value: the value itself where it is inside.

    Args:
        q: (..., B, n) rad or m.
        limits: (n, 2) rad or m.
        turning: (n,) whether 2 pi more is the same posture; a number: so many turns more, where joints mimic others.
        tol: see :func:`image_range`.

    Returns:
        q (..., B, n), NaN rows where a joint has no image inside; (..., B) bool.
    """
    return _core.nearest_image(np.ascontiguousarray(q), *_bounds(limits, turning, tol))


def has_image(q: Array, among: Mask, limits: Array, turning: Mask | Array) -> Mask:
    """Which joint vectors have an image inside the limits, of those that are asked about.

    Args:
        q: (..., n) rad or m.
        among: (...) which joint vectors are asked about; the answer is false for the others.
        limits: (n, 2) rad or m.
        turning: (n,) see :func:`image_range`.

    Returns:
        (...) bool.
    """
    bounds = _bounds(limits, turning, LIMIT_TOLERANCE)
    return np.asarray(_core.has_image(np.ascontiguousarray(q), np.ascontiguousarray(among), *bounds))


def image_near(q: Array, q_ref: Array, limits: Array, turning: Mask | Array) -> tuple[Array, Mask]:
    """The image inside the limits that is nearest to a reference, joint by joint.

    Args:
        q: (..., n) rad or m.
        q_ref: (..., n) rad or m, which broadcasts against ``q``.
        limits: (n, 2) rad or m.
        turning: (n,) see :func:`nearest_image`.

    Returns:
        q (..., n), NaN rows where a joint has no image inside; (...) bool.
    """
    reference = np.asarray(q_ref, dtype=np.float64)
    if reference.size != q.shape[-1] and reference.shape != (*q.shape[:-2], 1, q.shape[-1]):
        shape = np.broadcast_shapes(q.shape, reference.shape)
        q, reference = np.broadcast_to(q, shape), np.broadcast_to(reference, shape)
    bounds = _bounds(limits, turning, LIMIT_TOLERANCE)
    return _core.image_near(np.ascontiguousarray(q), np.ascontiguousarray(reference), *bounds)


def image_beside(q: Array, q_ref: Array, limits: Array, turning: Mask | Array) -> Array:
    """The image that is nearest to a reference, joint by joint: inside the limits where the joint has one there.

    Args:
        q: (..., n) rad or m.
        q_ref: (..., n) rad or m, which broadcasts against ``q``.
        limits: (n, 2) rad or m.
        turning: (n,) see :func:`nearest_image`.

    Returns:
        q (..., n), NaN rows where ``q`` has them.
    """
    image, inside = image_near(q, q_ref, limits, turning)
    if (lost := ~inside & ~np.isnan(q).any(axis=-1)).any():
        first, last = image_range(q[lost], limits, turning)
        on_circle, turn = _turns(turning)
        wanted = np.rint((np.broadcast_to(q_ref, q.shape)[lost] - q[lost]) / turn)
        bounded = np.isfinite(limits).all(axis=1) & (first <= last)
        k = np.where(bounded, np.clip(wanted, first, np.maximum(first, last)), wanted)
        image[lost] = q[lost] + np.where(on_circle, k * turn, 0.0)
    return image


def image_inmost(q: Array, limits: Array, turning: Mask | Array) -> tuple[Array, Mask]:
    """The image inside the limits that is farthest from them; arguments and answer as :func:`nearest_image`."""
    ranged = np.isfinite(limits).all(axis=1)
    return image_near(q, np.where(ranged, middle(limits), q), limits, turning)


def margin(q: Array, limits: Array) -> Array:
    """How far joint vectors are from the limits, each joint as a share of half its range.

    Args:
        q: (..., n) rad or m.
        limits: (n, 2) rad or m.

    Returns:
        (...) the least of the joints that have a range: 1 in the middle of all and where no joint has one, 0 at a
        limit, negative outside, NaN for NaN rows.
    """
    lower, upper = limits.T
    ranged = np.flatnonzero(np.isfinite(upper - lower) & (upper > lower))
    low, high, inside = lower[ranged], upper[ranged], q[..., ranged]
    least = (np.minimum(inside - low, high - inside) / (0.5 * (high - low))).min(axis=-1, initial=1.0)
    return np.where(np.isnan(q).any(axis=-1), np.nan, least)


def turns(q: Array, limits: Array, turning: Mask | Array, tol: float = LIMIT_TOLERANCE) -> _Turned:
    """Every combination of images inside the limits; arguments as :func:`nearest_image`.

    Every branch gets the same number M of columns, the product of the greatest number of images that each
    joint has in ``q``.
    """
    first, last = image_range(q, limits, turning, tol)
    inside = (first <= last).all(axis=-1, keepdims=True)
    counts = np.where(inside, last - first + 1.0, 1.0)
    per_joint = counts.reshape(-1, q.shape[-1]).max(axis=0, initial=1.0)
    with np.errstate(over="ignore"):
        entries = q.size * float(np.prod(per_joint))
    if entries > MAX_ENTRIES:
        images = " x ".join(f"{count:.4g}" for count in per_joint)
        raise ArgumentError(
            f"the joints have {images} images inside their limits: {entries:.3g} joint values, more than "
            f"{MAX_ENTRIES:.3g} in one array; nearest(q, within_limits=True) chooses among them without listing them"
        )
    steps = []
    for i, count in enumerate(per_joint):
        k = first[..., i, None] + np.arange(int(count))
        k = np.where((k <= last[..., i, None]) & inside, k, np.nan)
        # Fewest turns first; of two the one nearer to zero.
        order = np.argsort(np.abs(k) + 0.25 * (k * q[..., i, None] > 0.0), axis=-1, kind="stable")
        steps.append(np.take_along_axis(k, order, axis=-1))
    ranks = np.indices(per_joint.astype(np.intp)).reshape(q.shape[-1], int(np.prod(per_joint))).T
    out = np.empty((*q.shape[:-1], len(ranks), q.shape[-1]))
    turn = _turns(turning)[1]
    for i, k in enumerate(steps):
        out[..., i] = (q[..., i, None] + k * turn[i])[..., ranks[:, i]]
    out = out.reshape(*q.shape[:-2], q.shape[-2] * len(ranks), q.shape[-1])
    valid = np.asarray(~np.isnan(out).any(axis=-1))
    out[~valid] = np.nan
    return _Turned(out, valid, tuple(steps), ranks)


def excess(q: Array, limits: Array, turning: Mask | Array, tol: float = LIMIT_TOLERANCE) -> tuple[Array, Array]:
    """How far each joint is from its limits in the image that is least far out; arguments as :func:`nearest_image`.

    Returns:
        Image (..., B, n) and signed distance (..., B, n): positive beyond the upper limit, negative below the
        lower one, zero where an image is inside; NaN where ``q`` is.
    """
    first, last = image_range(q, limits, turning, tol)
    inside = first <= last
    # Where no image is inside, last is the image below the limits and the next one lies above them.
    turning, turn = _turns(turning)
    low = q + np.where(turning, last, 0.0) * turn
    high = low + np.where(turning, turn, 0.0)
    lower, upper = limits[:, 0] - tol, limits[:, 1] + tol
    upwards = turning & (np.maximum(lower - high, high - upper) < np.maximum(lower - low, low - upper))
    nearest = np.where(upwards, high, low)
    fewest = np.where(inside, np.clip(0.0, first, np.maximum(first, last)), 0.0)
    image = np.where(inside, q + fewest * turn, nearest)
    # Of limits that a negative tolerance has turned round, an image may be beyond both.
    signed = np.where(nearest - upper >= lower - nearest, nearest - upper, nearest - lower)
    signed = np.where(inside, 0.0, signed)
    return np.where(np.isnan(q), np.nan, image), np.where(np.isnan(q), np.nan, signed)


def _bounds(limits: Array, turning: Mask | Array, tol: float) -> tuple[Array, Array]:
    """Limits (n, 2) widened by a tolerance; how far [rad] the images of each joint are apart, 0 where it has none."""
    tol = inputs.number(tol, "tol", unit="rad or m")
    on_circle, turn = _turns(turning)
    return np.ascontiguousarray(limits + [-tol, tol]), np.where(on_circle, turn, 0.0)


def _turns(turning: Mask | Array) -> tuple[Mask, Array]:
    """Which joints have images, and how far [rad] these are apart."""
    return np.asarray(turning, dtype=np.bool_), TURN * np.where(turning, turning, 1.0)
