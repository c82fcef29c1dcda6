"""``Region``: how far the tip may be from a target, in the target's frame."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.descent import Wanted, descended
from urdf_ik.ik.minima import spread_evenly, spread_inside
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.redundancy.interval_search import span
from urdf_ik.ik.redundancy.values import nearest_values
from urdf_ik.ik.solutions import IKSolutions, distances, limits
from urdf_ik.ik.solver import Solver
from urdf_ik.ik.task import POSE
from urdf_ik.ik.task_members import answered
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.model.poses import as_pose_array
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array, Threads

Range = tuple[float, float]


@dataclass(frozen=True, init=False)
class Region:
    """The poses allowed around a target: a box for the position, a cone for an axis, a range of rotations.

    A part that is not given is exact: ``Region()`` is the target alone.

    Attributes:
        box: three pairs (low, high) m, along the target's x, y and z.
        cone: rad, how far the axis may be tilted from the target's, in any direction.
        rotation: rad, how far the tip may be turned about the axis, in both directions; pi: any rotation.
        axis: the axis in the tip, through the point that the box bounds.

    Example:
        >>> import numpy as np
        >>> import urdf_ik
        >>> region = urdf_ik.Region(box=[0.0, 0.0, 0.005], cone=0.2, rotation=np.pi)
        >>> bool(region.contains(np.eye(4), urdf_ik.pose([0.0, 0.0, 0.004], rpy=[0.1, 0.0, 2.0])))
        True
    """

    box: tuple[Range, Range, Range]
    cone: float
    rotation: float
    axis: FreeAxis

    def __init__(
        self,
        box: ArrayLike = 0.0,
        cone: float = 0.0,
        rotation: float = 0.0,
        *,
        axis: Any = "z",
        at: ArrayLike | None = None,
    ) -> None:
        """Describe a region.

        Args:
            box: m, half the width along the target's x, y and z: one number, three, or three pairs (low, high).
            cone: rad, half the angle of the cone about the axis, below pi.
            rotation: rad about the axis, in both directions; pi or more: any.
            axis: 'x', 'y', 'z' or a direction (3,) of the tip.
            at: (3,) m, the point of the tip that the box bounds; default: the tip's origin.

        Raises:
            ArgumentError: a width, an angle or an axis is invalid.
        """
        needed = "a half width [m], three, or three pairs (low, high)"
        given = inputs.real(box, "box", needed)
        half = given if given.shape in ((), (1,), (3,)) else np.array(np.nan)
        ranges = given if given.shape == (3, 2) else np.broadcast_to(half, (3,))[:, None] * [-1.0, 1.0]
        if inputs.first_bad(ranges) is not None or (ranges[:, 0] > ranges[:, 1]).any():
            raise ArgumentError(f"box={quoted(box)} given; {needed} is needed")
        cone = inputs.number(cone, "cone", low=0.0, unit="rad")
        rotation = inputs.number(rotation, "rotation", low=0.0, unit="rad")
        if cone >= np.pi:
            raise ArgumentError(f"cone={cone:g} given; an angle below pi is needed")
        x, y, z = ((float(low) + 0.0, float(high)) for low, high in ranges)
        for name, value in (
            ("box", (x, y, z)),
            ("cone", cone),
            ("rotation", min(rotation, np.pi)),
            ("axis", axis if isinstance(axis, FreeAxis) else FreeAxis.read(axis, at)),
        ):
            object.__setattr__(self, name, value)

    def measured(self, T: Array, reached: Array) -> tuple[Array, Array, Array]:
        """Poses (..., 4, 4) relative to targets: position (..., 3) m, the axis' direction (..., 3), rotation (...) rad.

        The rotation is the one that remains after the shortest rotation that undoes the tilt.
        """
        T, reached = as_pose_array(T), as_pose_array(reached)
        off = (reached - T)[..., :3, :] @ self.axis.seen[:, 0]
        inverse = np.swapaxes(T[..., :3, :3], -1, -2)
        motion = np.zeros((*off.shape[:-1], 4, 4))
        motion[..., :3, :3] = inverse @ reached[..., :3, :3]
        direction = motion[..., :3, :3] @ np.array(self.axis.direction)
        return np.einsum("...ij,...j->...i", inverse, off), direction, self.axis.angle(motion)

    def contains(self, T: Array, reached: Array, tolerance: float = 1e-9) -> NDArray[np.bool_]:
        """Whether poses (..., 4, 4) are in the region around targets (..., 4, 4), to a tolerance [m, rad]."""
        place, direction, turn = self.measured(T, reached)
        low, high = np.array(self.box).T
        inside = ((place >= low - tolerance) & (place <= high + tolerance)).all(axis=-1)
        tilt = 2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(direction - self.axis.direction, axis=-1), 1.0))
        return np.asarray(inside & (tilt <= self.cone + tolerance) & (np.abs(turn) <= self.rotation + tolerance))

    def clipped(self, T: Array, reached: Array) -> Array:
        """The pose (4, 4) in the region around a target with a pose's place, tilt and rotation as far as allowed."""
        place, direction, turn = self.measured(T, reached)
        low, high = np.array(self.box).T
        aside, along = self.across @ direction, direction @ np.array(self.axis.direction)
        tilt = np.minimum(np.arctan2(np.linalg.norm(aside), along), self.cone)
        heading = np.arctan2(aside[1], aside[0])
        place, turn = place.clip(low, high), turn.clip(-self.rotation, self.rotation)
        return self._pose(as_pose_array(T), place, tilt, heading, turn)

    def _pose(self, T: Array, place: Array, tilt: Array, heading: Array, turn: Array) -> Array:
        """Poses (..., 4, 4) with the point at ``place`` (..., 3), the axis tilted towards ``heading``, and turned."""
        a, (e, f) = np.array(self.axis.direction), self.across
        towards = np.cos(heading)[..., None] * e + np.sin(heading)[..., None] * f
        # The tilt turns a to the direction of ``towards``: a rotation in the plane of the two.
        sine, cosine = np.sin(tilt)[..., None, None], np.cos(tilt)[..., None, None]
        both = towards[..., :, None] * a - a[:, None] * towards[..., None, :]
        plane = towards[..., :, None] * towards[..., None, :] + np.outer(a, a)
        swing = np.eye(3) + sine * both + (cosine - 1.0) * plane
        out: Array = np.zeros((*np.shape(tilt), 4, 4))
        out[..., :3, :3] = T[:3, :3] @ swing @ FreeAxis(self.axis.direction).rotation(turn)[..., :3, :3]
        at = np.array(self.axis.at)
        out[..., :3, 3] = T[:3, 3] + (at + place) @ T[:3, :3].T - out[..., :3, :3] @ at
        out[..., 3, 3] = 1.0
        return out

    @cached_property
    def across(self) -> Array:
        """(2, 3) directions at right angles to the axis and to each other."""
        a = np.array(self.axis.direction)
        e = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
        e /= np.linalg.norm(e)
        return np.stack([e, np.cross(a, e)])

    def sampled(self, T: Array, shares: Array) -> Array:
        """Poses (m, 4, 4) spread over the region around a target, from shares (m, 6) of a unit cube.

        Raises:
            PoseError: the target is no pose.
        """
        low, high = np.array(self.box).T
        tilt, turn = self.cone * np.sqrt(shares[:, 3]), self.rotation * (2.0 * shares[:, 5] - 1.0)
        return self._pose(as_pose_array(T), low + shares[:, :3] * (high - low), tilt, 2.0 * np.pi * shares[:, 4], turn)

    @property
    def widths(self) -> Array:
        """(6,) m and rad: how wide the region is in each of the directions that ``sampled`` spreads over."""
        low, high = np.array(self.box).T
        return np.array([*(high - low), self.cone, self.cone, self.rotation])


SAMPLES = 64
"""Samples along one direction; twice as many with every direction more, up to ``MOST_SAMPLES``."""
MOST_SAMPLES = 1024
STARTS = 10
"""Starts of the search, at most."""
APART = 0.2
"""rad or m: starts that differ by less in every joint are one."""
_STEP = 1e-6
"""rad or m: of central differences."""
_ANY = 3.14159
"""rad: a cone of any direction."""
_FAR = 20.0
"""Sizes of the arm, within which every place of the tip is."""
INSIDE = 1e-8
"""rad or m that the search keeps from the joint limits, so that rounding does not lead beyond them."""


def nearest_in_region(
    solver: Solver,
    T: Any,
    q_ref: ArrayLike,
    region: Region | None,
    *,
    metric: str,
    weights: ArrayLike | None,
    within: ArrayLike | None,
    within_limits: bool,
    threads: Threads,
) -> IKSolutions:
    """See :meth:`urdf_ik.Arm.ik_nearest`.

    Raises:
        ArgumentError: another metric than 'l2'.
        ArgumentError: ``q_ref`` does not fit.
    """
    part = solver.asked != POSE and region is None
    if inputs.choice(metric, "metric", distances.METRICS) != "l2":
        what = "a region" if region is not None else "several redundancy parameters"
        raise ArgumentError(f"metric={quoted(metric)} given; with {what} the distance is metric='l2'")
    measure = distances.measure(solver, metric, weights, within)
    threads = inputs.threads(threads)
    target = as_pose_array(T) if solver.asked == POSE else solver.asked.read_targets(T)
    shape = target.shape[:-2]
    reference = np.broadcast_to(distances.reference(q_ref, solver.joint_names, shape), (*shape, solver.dof))
    bounds = solver.limits if within_limits else np.tile([-np.inf, np.inf], (solver.dof, 1))
    free = solver.free_axis
    sought = region or Region()
    if free is not None:
        sought = Region(rotation=np.pi, axis=free)
    stack, near = target.reshape(-1, 4, 4).copy(), reference.reshape(-1, solver.dof)
    values = np.tile([parameter.default for parameter in solver.parameters], (len(stack), 1))
    starts = near.copy()
    for k, (pose, q) in enumerate(zip(stack, near, strict=True)):
        if part and not solver.asked.has_place:  # places that the arm reaches are near it
            pose = np.block([[pose[:3, :3], solver.chain.points[0][:, None]], [np.eye(4)[3]]])
        kept = _asked_region(solver, pose) if part else sought
        found = _nearest(solver.fixed, pose, q, sought, kept, bounds, measure.factors, threads)
        if found is not None:
            starts[k] = found
            if solver.dof < 6:  # the pose has to stay one that the joints reach
                found = _placed(solver, pose, found, bounds) if not np.ptp(kept.box, axis=1).any() else found
                stack[k] = solver.chain.fk(found)
            else:
                stack[k] = pose if region is None else sought.clipped(pose, solver.chain.fk(found))
            values[k] = nearest_values(solver, found[None], stack[k][None])[0] if solver.parameters else []
    if part and not solver.parameters:  # what a search would look for again
        wanted = Wanted(solver.chain, stack[:, :3, 3], *solver.asked.matrix(stack))
        parts = float(solver.asked.has_place), float(solver.asked.has_turn)
        q, info = answered(solver.chain, solver.asked, stack, descended(wanted, starts, bounds, *parts, 60)[:, None])
        every = IKSolutions(solver, target, q.reshape(*shape, 1, solver.dof), info.reshape(*shape, 1), ("nearest",))
        return every.nearest(reference, weights, metric="l2", within=within, within_limits=within_limits)
    count = len(solver.parameters)
    at = values.reshape(shape if count == 1 else (*shape, count)) if count else None
    solutions = solve(solver, stack.reshape(*shape, 4, 4), redundancy=at, threads=threads)
    return solutions.nearest(reference, weights, metric="l2", within=within, within_limits=within_limits)


def _asked_region(solver: Solver, T: Array) -> Region:
    """The poses that do what the arm's task asks of a target (4, 4)."""
    asked, anywhere = solver.asked, 0.0 if solver.asked.has_place else _FAR * solver.chain.size
    if asked.axis is None:
        return Region(anywhere, *((0.0, 0.0) if asked.has_turn else (_ANY, np.pi)))
    axis = np.array(asked.axis)
    return Region(anywhere, rotation=np.pi, axis=axis if asked.frame == "tip" else T[:3, :3].T @ axis)


def _placed(solver: Solver, T: Array, q: Array, bounds: Array) -> Array:
    """A joint vector (n,) whose tip is nearly at the position of a pose, moved to be there to rounding."""
    wanted = Wanted(solver.chain, T[None, :3, 3], T[None, :3, :3], 3.0)
    return np.asarray(descended(wanted, q[None], bounds, 1.0, 0.0, 8)[0])


def _nearest(
    solver: Solver, T: Array, q_ref: Array, region: Region, kept: Region, bounds: Array, factors: Array, threads: int
) -> Array | None:
    """The joint vector (n,) in a region around a pose (4, 4) that is nearest to ``q_ref``; None where none is found.

    Starts are the solutions of poses of ``region``; the tip has to be in ``kept``.
    """
    from scipy.optimize import minimize

    low, high = bounds[:, 0] + INSIDE, bounds[:, 1] - INSIDE
    tight = low > high
    low, high = np.where(tight, bounds[:, 0], low), np.where(tight, bounds[:, 1], high)
    scale = np.sqrt(np.maximum(factors, 1e-6))
    conditions = _conditions(solver, T, kept)
    best: Array | None = None
    least = np.inf
    for start in _starts(solver, T, q_ref, region, bounds, scale, threads):
        answer = minimize(
            lambda q: 0.5 * float(((q - q_ref) * scale) @ ((q - q_ref) * scale)),
            start.clip(low, high),
            jac=lambda q: (q - q_ref) * scale**2,
            method="SLSQP",
            bounds=list(zip(low, high, strict=True)),
            constraints=conditions,
            options={"maxiter": 100, "ftol": 1e-11},
        )
        q = answer.x
        if answer.fun < least * (1.0 - 1e-9) and kept.contains(T, solver.chain.fk(q), 1e-7):
            best, least = q, float(answer.fun)
    return best


def _starts(solver: Solver, T: Array, q_ref: Array, region: Region, bounds: Array, scale: Array, threads: int) -> Array:
    """(k, n) joint vectors from which to search, nearest first, no two alike.

    Of all branches of samples of the region; nearest postures of a part of a pose, and of fewer than six joints, which
    reach few poses.
    """
    few = solver.dof < 6 or solver.asked != POSE
    q = _nearest_postures(solver, T, q_ref, bounds) if few else _sampled(solver, T, region, threads)
    turning = solver.chain.image_turns
    image, inside = limits.image_near(q, q_ref, bounds, turning)
    if inside.any():
        order = np.argsort((((image[inside] - q_ref) * scale) ** 2).sum(axis=-1), kind="stable")
        candidates = image[inside][order]
    else:
        _, out = limits.excess(q, bounds, turning)
        order = np.argsort(np.abs(out).max(axis=-1), kind="stable")[: 16 * STARTS]
        candidates = q[order].clip(*bounds.T)
    chosen: list[Array] = []
    for each in candidates:
        if len(chosen) < STARTS and all(np.abs(each - other).max() > APART for other in chosen):
            chosen.append(each)
    return np.array(chosen).reshape(-1, solver.dof)


def _sampled(solver: Solver, T: Array, region: Region, threads: int) -> Array:
    """(k, n) all solutions of poses spread over a region, at values spread over the redundancy parameters."""
    parameters = solver.parameters
    spread = np.append(region.widths > 0.0, np.ones(len(parameters), np.bool_))
    wide = int(spread.sum())
    count = 1 if not wide else min(SAMPLES << (wide - 1), MOST_SAMPLES)
    shares = np.full((count, len(spread)), 0.5)
    shares[:, spread] = spread_evenly(count, wide)
    shares[:, 3] = np.where(spread[3], shares[:, 3], 0.0)
    poses = region.sampled(T, shares[:, :6])
    poses[0] = T
    values: Any = None
    if parameters:
        low, high = np.array([span(solver, parameter, poses) for parameter in parameters]).T
        grid = low + shares[:, 6:] * (high - low)
        values = grid if len(parameters) > 1 else grid[:, 0]
    solutions = solve(solver, poses, redundancy=values, threads=threads)
    return solutions.q[solutions.valid]


def _nearest_postures(solver: Solver, T: Array, q_ref: Array, bounds: Array) -> Array:
    """(k, n) the reference, and postures near a pose that the joints need not reach."""
    asked, count = solver.asked, SAMPLES + 1
    wanted = Wanted(solver.chain, np.tile(T[:3, 3], (count, 1)), *asked.matrix(np.tile(T, (count, 1, 1))))
    q = np.vstack([q_ref.clip(*bounds.T), spread_inside(bounds, wanted.unit, SAMPLES)])
    turn = 0.01 if asked == POSE else float(asked.has_turn)
    return np.vstack([q[:1], descended(wanted, q, bounds, float(asked.has_place), turn, 30)])


def _conditions(solver: Solver, T: Array, region: Region) -> list[dict[str, Any]]:
    """What keeps the tip in a region: equations and inequalities for SciPy, central differences as derivatives."""
    low, high = np.array(region.box).T
    exact, a, most = low == high, np.array(region.axis.direction), np.cos(region.cone)
    steps = _STEP * np.eye(solver.dof)

    def equal(q: Array) -> Array:
        place, direction, turn = region.measured(T, solver.chain.fk(q))
        tilt = direction @ region.across.T if region.cone == 0.0 else place[..., :0]
        turned = turn[..., None] if region.rotation == 0.0 else place[..., :0]
        return np.concatenate([(place - low)[..., exact], tilt, turned], axis=-1)

    def less(q: Array) -> Array:
        place, direction, turn = region.measured(T, solver.chain.fk(q))
        tilt = ((direction @ a - most) / (1.0 - most))[..., None] if region.cone > 0.0 else place[..., :0]
        room = region.rotation - turn[..., None] * [1.0, -1.0]
        room = room if 0.0 < region.rotation < np.pi else place[..., :0]
        return np.concatenate([(place - low)[..., ~exact], (high - place)[..., ~exact], tilt, room], axis=-1)

    def slope(f: Callable[[Array], Array]) -> Callable[[Array], Array]:
        return lambda q: (f(q + steps) - f(q - steps)).T / (2.0 * _STEP)

    parts = (("eq", equal), ("ineq", less))
    return [{"type": kind, "fun": f, "jac": slope(f)} for kind, f in parts if f(np.zeros(solver.dof)).size]
