"""The joint vector of an arm with seven joints that is nearest to a reference, over all values of its parameter.

The places with the least distance on a grid of values are closed in upon with ever finer grids. A minimum that is
narrower than the first grid's step (a 256th of the range: 0.025 rad of a full turn) may be missed. Intervals inside the
joint limits may be narrower: solutions outside them are followed inwards.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.errors import JointVectorError
from urdf_ik.poses import as_pose_array
from urdf_ik.redundancy.sweep import FINER, FINEST, GRID, span
from urdf_ik.solutions import limits

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.chain.redundancy import Redundancy
    from urdf_ik.solutions import IKSolutions
    from urdf_ik.solutions.solved_arm import SolvingArm

    Array = NDArray[np.float64]

# Places that are closed in upon at the same time.
_PLACES = 8
# What a solution outside the limits costs more than any distance inside them.
_OUTSIDE = 1e6
# Poses whose grids are solved at a time: about 10 MB of solutions.
_AT_ONCE = 32


def nearest(
    arm: SolvingArm, parameter: Redundancy, T: Any, q_ref: ArrayLike, within_limits: bool, threads: int
) -> IKSolutions:
    """See :meth:`urdf_ik.Arm.ik_nearest`.

    The distance is sqrt(sum of squared differences) to the +-2 pi images (with ``within_limits`` those inside the
    limits), for each value of the parameter the least of all branches; where no image is inside, by how much the best
    one is out. The eight lowest places of the first grid and ``q_ref``'s own value are closed in upon until values are
    1e-10 apart: a minimum may lie at a limit, where a branch ends, or anywhere between.
    """
    target = as_pose_array(T)
    reference = arm.chain.check(q_ref)
    shape = target.shape[:-2]
    try:
        reference = np.broadcast_to(reference, (*shape, arm.dof)).reshape(-1, arm.dof)
    except ValueError:
        raise JointVectorError(
            f"q_ref of shape {reference.shape} and poses of shape {shape} given: one joint vector, or one a pose"
        ) from None
    stack = target.reshape(-1, 4, 4)
    values = np.empty(len(stack))
    bounds = arm.limits if within_limits else np.tile([-np.inf, np.inf], (arm.dof, 1))
    for start in range(0, len(stack), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        values[part] = _nearest_values(arm, parameter, stack[part], reference[part], bounds, threads)
    found: IKSolutions = arm.ik(target, redundancy=values.reshape(shape), threads=threads)
    return found.nearest(reference.reshape(*shape, arm.dof), within_limits=within_limits)


def _nearest_values(
    arm: SolvingArm, parameter: Redundancy, T: Array, q_ref: Array, bounds: Array, threads: int
) -> Array:
    """(m,) values of the parameter at which poses (m, 4, 4) come nearest to joint vectors (m, n)."""
    low, high = span(arm, parameter, T)
    own = arm.redundancy_of(q_ref)
    own = own if parameter.round else np.clip(own, low, high)

    def far(values: Array) -> Array:
        solutions = arm.ik(T[:, None], redundancy=values, threads=threads)
        _, distances = _images(arm, solutions.q, q_ref[:, None, None], bounds)
        outside = np.isinf(distances).all(axis=-1)
        if outside.any():
            _, out = limits.excess(solutions.q[outside], bounds, ~arm.chain.prismatic)
            distances[outside] = np.nan_to_num(_OUTSIDE + np.abs(out).max(axis=-1), nan=np.inf)
        return np.asarray(distances.min(axis=-1))

    grid = np.linspace(low, high, GRID, endpoint=not parameter.round)
    step = grid[1] - grid[0]
    distance = far(np.broadcast_to(grid, (len(T), GRID)))
    before, after = np.roll(distance, 1, axis=1), np.roll(distance, -1, axis=1)
    if not parameter.round:
        before[:, 0], after[:, -1] = np.inf, np.inf
    lowest = np.where((distance <= before) & (distance <= after), distance, np.inf)
    places = np.argsort(lowest, axis=1, kind="stable")[:, :_PLACES]
    # The reference's own value is always one of the places.
    best = np.concatenate([own[:, None], grid[places]], axis=1)
    least = np.concatenate([far(own[:, None]), np.take_along_axis(distance, places, axis=1)], axis=1)
    around = np.linspace(-1.0, 1.0, FINER)
    while step > FINEST:
        tried = best[:, :, None] + step * around
        tried = tried if parameter.round else np.clip(tried, low, high)
        found = far(tried.reshape(len(T), -1)).reshape(tried.shape)
        column = np.argmin(found, axis=2)[:, :, None]
        better = np.take_along_axis(found, column, axis=2)[:, :, 0]
        nearer = better < least
        best = np.where(nearer, np.take_along_axis(tried, column, axis=2)[:, :, 0], best)
        least = np.where(nearer, better, least)
        step *= 2.0 / (FINER - 1)
    chosen = np.argmin(least, axis=1)[:, None]
    return parameter.wrapped(np.take_along_axis(best, chosen, axis=1)[:, 0])


def _images(arm: SolvingArm, q: Array, q_ref: Array, bounds: Array) -> tuple[Array, Array]:
    """The image of each joint vector inside the bounds that is nearest to ``q_ref``, NaN where no image is inside.

    Returns:
        Images (..., n) and their distances (...), infinite where there is no image.
    """
    image, inside = limits.image_near(q, q_ref, bounds, ~arm.chain.prismatic)
    return image, np.where(inside, np.sqrt(((image - q_ref) ** 2).sum(axis=-1)), np.inf)
