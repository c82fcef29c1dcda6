"""What a family makes of an arm: the parameters of its kernel, its branches, and how far the arm is off."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik._kernels import layout
from urdf_ik.dh_frames import any_normal, denavit_hartenberg, frame
from urdf_ik.tolerances import DEFAULT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from urdf_ik._core import Solver
    from urdf_ik.chain import Chain
    from urdf_ik.dh_frames import DHFrames
    from urdf_ik.mimic import CoupledChain
    from urdf_ik.redundancy import Redundancy
    from urdf_ik.structure import Structure

    Array = NDArray[np.float64]

# The eight branches of shoulder, elbow and wrist: the signs of their roots, and their names in the same order.
SIGNS = np.array([[front, up, flip] for front in (1, -1) for up in (1, -1) for flip in (1, -1)], dtype=np.float64)
NAMES = tuple(
    f"shoulder {front}, elbow {up}, wrist {flip}"
    for front in ("front", "back")
    for up in ("up", "down")
    for flip in ("noflip", "flip")
)

_TOLERANCES = (
    "reach", "edge", "fold", "continuum", "singular", "duplicate", "rotation", "exact_rotation", "exact_structure"
)  # fmt: skip
# Below this a cosine or sine of a twist is rounding of zero: eight units in the last place of 1.
_ROUNDING = 2e-15


@dataclass(frozen=True)
class Plan:
    """A family's answer to an arm.

    Attributes:
        family: its name.
        method: how it is solved, in words.
        branches: names of the columns.
        imperfection: (rad, m) of the relations that the family rests on.
        error: greatest difference between the poses of the ideal arm and of the arm as written, over sampled
            joint vectors [rad, share of size].
        arm: (layout.LENGTH or more,) the kernel's numbers.
        solve: kernel (T, arm, q_ref, Q, flags) -> index of the first bad pose or -1.
        explain: (target in frame 1 as rotation (3, 3) and point (3,)) -> why there is no solution.
        mirrored: whether the numbers are those of the chain from tip to base.
        by_quartic: whether its branches are the roots of a quartic.
        solver: the compiled solver; None: ``solve`` and ``arm`` are used.
    """

    family: str
    method: str
    branches: tuple[str, ...]
    imperfection: tuple[float, float]
    error: float
    arm: Array
    solve: Callable[..., int]
    explain: Callable[[Array, Array], str]
    mirrored: bool = False
    by_quartic: bool = False
    solver: Solver | None = None

    @property
    def is_exact(self) -> bool:
        """Whether the arm as written is the ideal one, to rounding."""
        return self.error <= DEFAULT.exact_structure

    def why(self, T: Array) -> str:
        """Why the pose ``T`` (4, 4) has no solution."""
        T = np.linalg.inv(T) if self.mirrored else T
        base, tool = (self.arm[at : at + 9].reshape(3, 3) for at in (layout.BASE_ROTATION, layout.TOOL_ROTATION))
        origin, point = (self.arm[at : at + 3] for at in (layout.BASE_ORIGIN, layout.TOOL_POINT))
        R, p = T[:3, :3], T[:3, 3]
        return self.explain(base @ R @ tool, base @ (R @ point + p - origin))


@dataclass(frozen=True)
class RedundantPlan:
    """What solves an arm with seven joints, for given values of its redundancy parameter.

    Attributes:
        family: see ``Plan``, as method, branches, imperfection, error and arm.
        parameter: what is given.
        solve_at: (T (m, 4, 4), values (m,), arm, q_ref, Q (m, B, 7), flags) -> index of the first bad pose or -1.
        value_of: joint vectors (m, 7) -> their values (m,).
        explain_at: (T (4, 4), value) -> why there is no solution.
    """

    family: str
    method: str
    branches: tuple[str, ...]
    imperfection: tuple[float, float]
    error: float
    arm: Array
    parameter: Redundancy
    solve_at: Callable[..., int]
    value_of: Callable[[Array], Array]
    explain_at: Callable[[Array, float], str]
    solver: Solver | None = None

    def solve(self, T: Array, arm: Array, q_ref: Array, Q: Array, flags: NDArray[np.uint8]) -> int:
        """``Plan.solve`` at the parameter's default."""
        return self.solve_at(T, np.full(len(T), self.parameter.default), arm, q_ref, Q, flags)


def cheapest(plans: Iterable[Plan]) -> Plan:
    """The first exact one of plans, made as they are asked for; else the one with the least error.

    A quartic is no help to an arm that it does not fit exactly: its roots part with the root of the error.
    """
    made: list[Plan] = []
    for plan in plans:
        if plan.is_exact:
            return plan
        made.append(plan)
    return min(made, key=lambda plan: (plan.by_quartic, plan.error))


def ideal_frames(
    chain: Chain,
    directions: Array,
    points: Array,
    parallel: Sequence[bool],
    meet: Sequence[bool],
) -> tuple[DHFrames, float]:
    """DH frames of the ideal arm, and how far its poses are from those of the arm as written."""
    # Measured from the first axis: how far from its base the arm is mounted has no part in its structure.
    mount = chain.P[0]
    local = replace(chain, P=np.vstack([np.zeros(3), chain.P[1:]]))
    home = np.eye(4)
    home[:3, :3], home[:3, 3] = local.R_tip, local.P.sum(axis=0)
    frames = denavit_hartenberg(directions, points - mount, home, parallel, meet)
    Q = np.random.default_rng(0).uniform(-np.pi, np.pi, (12, chain.n))
    apart = frames.fk(Q) - local.fk(Q)
    apart[:, :3, 3] /= chain.size
    frames.base[:3, 3] += mount
    return frames, float(np.abs(apart).max())


def pack(chain: Chain, frames: DHFrames, error: float, signs: Array) -> Array:
    """The numbers that every family's kernel needs; the family adds its own."""
    arm = pack_as_written(chain)
    base, tool = frames.base, frames.tool
    arm[layout.BASE_ROTATION : layout.BASE_ROTATION + 9] = base[:3, :3].T.ravel()
    arm[layout.BASE_ORIGIN : layout.BASE_ORIGIN + 3] = base[:3, 3]
    arm[layout.TOOL_ROTATION : layout.TOOL_ROTATION + 9] = tool[:3, :3].T.ravel()
    arm[layout.TOOL_POINT : layout.TOOL_POINT + 3] = -tool[:3, :3].T @ tool[:3, 3]
    arm[layout.COS_ALPHA : layout.COS_ALPHA + 5] = snapped(np.cos(frames.alpha))
    arm[layout.SIN_ALPHA : layout.SIN_ALPHA + 5] = snapped(np.sin(frames.alpha))
    arm[layout.A : layout.A + 5] = frames.a
    arm[layout.D : layout.D + 4] = frames.d[:4]
    arm[layout.OFFSET : layout.OFFSET + 6] = frames.offset
    exact = error <= DEFAULT.exact_structure
    arm[layout.CLAMP] = 100.0 * DEFAULT.fold if exact else 100.0 * DEFAULT.fold + 50.0 * error
    arm[layout.IMPERFECTION] = error
    if not exact:
        arm[layout.EDGE] = max(DEFAULT.edge, (5.0 * error) ** 2)
        arm[layout.INNER_FRAMES : layout.INNER_FRAMES + 84] = _frames(chain, base, np.asarray(np.linalg.inv(tool)))
        arm[layout.IDEAL_FRAMES : layout.IDEAL_FRAMES + 84] = _as_numbers(frames.steps())
        arm[layout.DRIFT] = _drift(chain, frames)
    arm[layout.SIGNS : layout.SIGNS + 24] = signs.ravel()
    return arm


def pack_as_written(chain: Chain) -> Array:
    """The numbers of the arm as the URDF has it, and the tolerances."""
    arm = np.zeros(layout.LENGTH)
    # The target as it stands, where a family needs no frames of its own.
    arm[layout.BASE_ROTATION : layout.BASE_ROTATION + 9 : 4] = 1.0
    arm[layout.TOOL_ROTATION : layout.TOOL_ROTATION + 9 : 4] = 1.0
    arm[layout.SIZE] = chain.size
    arm[layout.REACH : layout.REACH + 9] = DEFAULT.for_kernels()
    arm[layout.H : layout.H + 18] = chain.H.ravel()
    arm[layout.P : layout.P + 21] = chain.P.ravel()
    arm[layout.R_TIP : layout.R_TIP + 9] = chain.R_tip.ravel()
    arm[layout.INVERSE_SIZE] = 1.0 / chain.size
    arm[layout.FRAMES : layout.FRAMES + 84] = _frames(chain, np.eye(4), np.eye(4))
    return arm


def written_values(chain: Chain) -> dict[str, Any]:
    """The arm as the URDF has it, as the compiled solvers take it: the steps between frames on the joint axes."""
    return {
        "steps": chain.motion.steps,
        "slides": chain.prismatic.astype(np.float64),
        "size": chain.size,
        "tolerances": dict(zip(_TOLERANCES, DEFAULT.for_kernels().tolist(), strict=True)),
    }


def driven_values(chain: CoupledChain, units: Array) -> dict[str, Any]:
    """The arm whose joints drive several axes each, as the compiled solvers take it.

    Args:
        chain: the arm.
        units: (n,) rad or m, what the solver's scaled joints count in.
    """
    written = written_values(chain.axes)
    return {
        **{name: written[name] for name in ("steps", "slides", "tolerances")},
        "size": chain.size,
        "axes": chain.axes.n,
        "gain": np.ascontiguousarray(chain.gain * units),
        "unit": units,
        "period": 2.0 * np.pi * chain.image_turns,
    }


def as_target(chain: Chain) -> Array:
    """The numbers of ``Plan.arm`` for solvers that see the target as it stands."""
    arm = np.zeros(layout.LENGTH)
    arm[layout.BASE_ROTATION : layout.BASE_ROTATION + 9 : 4] = 1.0
    arm[layout.TOOL_ROTATION : layout.TOOL_ROTATION + 9 : 4] = 1.0
    arm[layout.SIZE] = chain.size
    return arm


def by_solver(solver: Solver) -> Callable[..., int]:
    """The compiled solver in the place of a kernel."""

    def solve(T: Array, arm: Array, q_ref: Array, Q: Array, flags: NDArray[np.uint8]) -> int:
        return solver.solve(T, q_ref[:-1].copy() if q_ref[-1] else None, Q, flags)

    return solve


def ideal_values(frames: DHFrames, error: float, signs: Array, size: float) -> dict[str, Any]:
    """The ideal arm, as the compiled solvers of closed forms take it."""
    base, tool = frames.base, frames.tool
    exact = error <= DEFAULT.exact_structure
    return {
        "base_rotation": np.ascontiguousarray(base[:3, :3].T),
        "base_origin": base[:3, 3].copy(),
        "tool_rotation": np.ascontiguousarray(tool[:3, :3].T),
        "tool_point": -tool[:3, :3].T @ tool[:3, 3],
        "cos_alpha": snapped(np.cos(frames.alpha)),
        "sin_alpha": snapped(np.sin(frames.alpha)),
        "a": np.array(frames.a, dtype=np.float64),
        "d": np.array(frames.d[:4], dtype=np.float64),
        "offset": np.array(frames.offset, dtype=np.float64),
        "steps": np.ascontiguousarray(np.array(frames.steps())[:, :3]),
        "size": size,
        "clamp": 100.0 * DEFAULT.fold if exact else 100.0 * DEFAULT.fold + 50.0 * error,
        "imperfection": 0.0 if exact else error,
        "signs": signs,
    }


def distances_of(solver: Solver, rotation: Array, point: Array) -> Array:
    """What a pose, seen from frame 1, asks of the distance of two axes [m]: one for each way that there is."""
    seen = np.eye(4)
    seen[:3, :3], seen[:3, 3] = rotation, point
    distances = np.array(solver.distances(seen))
    return distances[np.isfinite(distances)]


def _drift(chain: Chain, frames: DHFrames) -> float:
    """Greatest change of the motion between the ideal arm's pose and the real one's, seen from axis 1 [1 / rad]."""
    rng = np.random.default_rng(1)
    Q = rng.uniform(-np.pi, np.pi, (60, 6))
    shift = 1e-3
    moved = Q + shift * rng.choice([-1.0, 1.0], (60, 6))
    inward = np.linalg.inv(frames.base)

    def between(Q: Array) -> Array:
        motions: Array = inward @ frames.fk(Q) @ np.linalg.inv(chain.fk(Q)) @ frames.base
        return motions

    change = between(moved) - between(Q)
    change[:, :3, 3] /= chain.size
    return float(np.abs(change).max()) / shift


def _frames(chain: Chain, before: Array, behind: NDArray[np.floating]) -> Array:
    """(84,) steps from ``before`` (in the base) by a frame on each joint axis to ``behind`` (in the tip), at q = 0."""
    home = np.eye(4)
    home[:3, :3], home[:3, 3] = chain.R_tip, chain.P.sum(axis=0)
    on_axes = [frame(h, any_normal(h), p) for h, p in zip(chain.H, chain.points, strict=True)]
    places = [before, *on_axes, home @ behind]
    return _as_numbers([np.linalg.inv(a) @ b for a, b in itertools.pairwise(places)])


def _as_numbers(steps: Iterable[Array]) -> Array:
    """Rigid motions (4, 4) as rows of rotation and translation, in one array."""
    return np.concatenate([np.concatenate([step[:3, :3].ravel(), step[:3, 3]]) for step in steps])


def snapped(values: Array) -> Array:
    """Values with the rounding of 0 and +-1 taken away."""
    nearest = np.round(values)
    return np.where(np.abs(values - nearest) < _ROUNDING, nearest, values)


def imperfection(structure: Structure, parallel: Sequence[int], meet: Sequence[int]) -> tuple[float, float]:
    """Greatest angle [rad] and distance [m] by which these pairs, named by their first axis, are off."""
    angles = [structure.pairs[i - 1].off_angle for i in parallel]
    distances = [structure.pairs[i - 1].off_distance for i in meet]
    return max(angles, default=0.0), max(distances, default=0.0)


def mean_direction(directions: Array) -> Array:
    """Directions (k, 3) replaced by their common one, each with its own sign."""
    signs = np.where(directions @ directions[0] < 0.0, -1.0, 1.0)
    mean = (signs[:, None] * directions).sum(axis=0)
    common: Array = signs[:, None] * (mean / np.linalg.norm(mean))
    return common


def straightened(structure: Structure, directions: Array) -> tuple[Array, list[bool]]:
    """Directions (n, 3) with neighbours that are parallel, or nearly, made exactly so; and which those are."""
    parallel = [structure.is_parallel(i) for i in range(1, len(directions))]
    straight = directions.copy()
    start = 0
    for end in range(1, len(directions) + 1):
        if end == len(directions) or not parallel[end - 1]:
            straight[start:end] = mean_direction(directions[start:end])
            start = end
    return straight, parallel


def method_in_words(steps: str, error: float) -> str:
    """``steps``, with what is done about an imperfect arm."""
    if error <= DEFAULT.exact_structure:
        return f"Closed form: {steps}"
    return f"Nearest ideal arm in closed form ({steps}), refined by Newton's method on the URDF as written"
