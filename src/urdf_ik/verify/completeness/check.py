"""compare(): the solutions of an arm's solver and of a second, independent method, pose by pose."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from urdf_ik.arm import Arm
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import UnsupportedArm
from urdf_ik.support import inputs
from urdf_ik.support.watch import Progress, Watch
from urdf_ik.typing import Array
from urdf_ik.verify.completeness.report import BOTH, SECOND, SOLVER, Completeness, Difference, Group
from urdf_ik.verify.completeness.sameness import Sameness, Unmatched, distance_to_singularity, plant
from urdf_ik.verify.completeness.second_way import SecondWay

_CHUNK = 16  # poses at a time


def compare(
    arm: Arm, n: int = 200, seed: int = 0, *, time_limit: float | None = None, progress: Progress | None = None
) -> Completeness:
    """Hold an arm's solver against a second way to all solutions.

    Joint vectors are drawn over the whole torus, whatever the limits: n at random, and n more 1e-1 to 1e-8 rad from a
    singularity, in turn, and n more at right angles, exactly and nearly. Pinocchio makes the poses.

    Args:
        arm: what :func:`urdf_ik.load` returned; six turning joints.
        n: number of random poses, of those near singularities, and of those at right angles.
        seed: the same seed gives the same report; :func:`replay` gives pose i of it again.
        time_limit: s after which no more poses are compared; what was left out did not pass.
        progress: called with (poses done, poses).

    Returns:
        The report; ``report.passed`` says whether nothing speaks against the solver.

    Raises:
        UnsupportedArm: the arm has no solver, or is not one of six turning joints.
        ArgumentError: n is below 1, the seed is negative, or ``time_limit`` is no number of seconds.

    Example:
        >>> import urdf_ik
        >>> report = compare(urdf_ik.load("puma_560"), n=1)
        >>> report.passed, [group.solver == group.second for group in report.groups]
        (True, [True, True, True])
    """
    inputs.arm(arm)
    n, seed = inputs.poses(n), inputs.whole(seed, "seed", high=2**64)
    watch, unlooked = Watch(time_limit, progress), ""
    vectors = planted(arm, n, seed)
    sameness = Sameness(arm.chain, Reference(arm.model, arm.base, arm.tip))
    second = SecondWay.of(arm)
    groups: dict[float | None, Group] = {}
    differences: list[Difference] = []
    for start in range(0, 3 * n, _CHUNK):
        if watch.is_over:
            unlooked = watch.ended(f"with {start} of {3 * n} poses: the others were")
            break
        indices = range(start, min(start + _CHUNK, 3 * n))
        T = sameness.reference.pose(vectors[start : indices.stop])
        mine = arm.ik(T)
        q, valid = np.asarray(mine.q), np.asarray(mine.valid)
        for i, index in enumerate(indices):
            near = distance_to_singularity(n, index)
            group = groups.setdefault(near, Group(near))
            theirs = second.solve(T[i], np.random.default_rng([seed, index, 1]))
            answer = sameness.unmatched(T[i], vectors[index], q[i, valid[i]], theirs)
            names = np.asarray(mine.branches, dtype=object)[valid[i]]
            group.add(int(valid[i].sum()), len(theirs), answer)
            differences += _records(sameness, answer, T[i], vectors[index], index, near, list(names), second)
        watch.step(indices.stop, 3 * n)
    return Completeness(
        robot=arm.name,
        base=arm.base,
        tip=arm.tip,
        joint_names=arm.joint_names,
        n=n,
        seed=seed,
        reference=f"Pinocchio {pin.__version__}",
        solver=arm.structure.family,
        second=second.name,
        groups=tuple(groups[key] for key in sorted(groups, key=lambda near: -np.inf if near is None else -near)),
        differences=tuple(differences),
        unlooked=unlooked,
    )


def planted(arm: Arm, n: int, seed: int) -> Array:
    """The joint vectors of a comparison, (3 n, 6) [rad]: n at random, n next to singularities, n at right angles.

    Example:
        >>> import urdf_ik
        >>> planted(urdf_ik.load("puma_560"), n=2, seed=0).shape
        (6, 6)
    """
    if arm.dof != 6 or not arm.structure.is_6r:
        kinds = ", ".join(arm.chain.joint_types)
        raise UnsupportedArm(f"{arm.name}: this is checked for six turning joints, and this arm has {kinds}")
    return np.array([plant(arm.chain, n, seed, index) for index in range(3 * n)])


def replay(arm: Arm, n: int, seed: int, index: int) -> tuple[Array, Array]:
    """Pose ``index`` of a comparison once more.

    Args:
        arm: the arm that was compared.
        n: the report's n; poses n to 2 n are those near singularities, those above are at right angles.
        seed: the report's seed.
        index: the difference's index.

    Returns:
        The planted joint vector (6,) [rad] and Pinocchio's pose for it, (4, 4) [m].

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("puma_560")
        >>> q, T = replay(arm, n=10, seed=0, index=3)
        >>> bool(abs(arm.fk(q) - T).max() < 1e-9)
        True
    """
    inputs.arm(arm)
    n, seed = inputs.poses(n), inputs.whole(seed, "seed", high=2**64)
    q = plant(arm.chain, n, seed, inputs.whole(index, "index", high=3 * n - 1))
    return q, Reference(arm.model, arm.base, arm.tip).pose(q)


def _records(
    sameness: Sameness,
    answer: Unmatched,
    T: Array,
    planted: Array,
    index: int,
    near: float | None,
    names: list[str],
    second: SecondWay,
) -> Iterator[Difference]:
    found = [(names[i], SECOND, q) for i, q in answer.only_first]
    found += [(second.name_of(i), SOLVER, q) for i, q in answer.only_second]
    found += [("planted", BOTH, planted)] * answer.planted_lost
    for branch, missed_by, q in found:
        position, rotation = sameness.reference.error(q, T)
        yield Difference(
            index=index,
            near=near,
            planted=tuple(map(float, planted)),
            q=tuple(map(float, q)),
            missed_by=missed_by,
            branch=branch,
            nearest=sameness.to_nearest(q, answer.everything),
            sigma_min=sameness.sigma_min(q),
            position_error=position,
            rotation_error=rotation,
        )
