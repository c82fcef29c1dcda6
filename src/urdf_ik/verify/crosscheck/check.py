"""check(): compares an arm with Pinocchio over random poses and every branch."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from urdf_ik.arm import Arm
from urdf_ik.cell import CollisionModel
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import UrdfError
from urdf_ik.support import inputs
from urdf_ik.support.watch import Progress, Watch
from urdf_ik.typing import Array
from urdf_ik.verify.crosscheck.properties import Collision, Inverse, Kinematics, limits
from urdf_ik.verify.crosscheck.report import Report

PROPERTIES = (
    "joints and limits",
    "forward kinematics, position",
    "forward kinematics, rotation",
    "Jacobian",
    "links, position",
    "links, rotation",
    "batch = single, kinematics",
    "solutions, position",
    "solutions, rotation",
    "planted joint vector",
    "batch = single, solutions",
    "duplicates",
    "collision, verdict",
    "collision, distance",
)
"""The rows of a report, in order; it omits a row that cannot be checked, and ``Report.skipped`` gives the reason."""

COLLISION_POSES = 2000
"""Joint vectors whose collision is compared: a distance between meshes takes a millisecond."""

_CHUNK = 256  # poses at a time: the link poses and solutions of all need not be in memory together


def check(
    arm: Arm,
    n: int = 200,
    seed: int = 0,
    collision: bool | None = None,
    *,
    collision_poses: int | None = COLLISION_POSES,
    time_limit: float | None = None,
    progress: Progress | None = None,
) -> Report:
    """Hold an arm against Pinocchio's own model of the same URDF.

    Joint vectors are drawn within the limits, Pinocchio makes the poses, the arm solves them. Compared are: joints and
    limits, forward kinematics, Jacobian, the pose of every link, batch and single answers, the error of every
    solution, whether the planted joint vector is among the solutions, duplicates, and collision: coal's shapes placed
    with the arm's link poses, against the same shapes placed by Pinocchio, for planted joint vectors and solutions.

    Args:
        arm: what :func:`urdf_ik.load` returned.
        n: number of poses.
        seed: the same seed gives the same report; :func:`replay` gives pose i of it again.
        collision: compare collision, too; None: where the URDF has collision shapes and all of them can be read.
        collision_poses: most joint vectors whose collision is compared; None: all.
        time_limit: s after which no more poses are checked; what was left out did not pass.
        progress: called with (poses done, n).

    Returns:
        The report; ``report.passed`` says whether all is well.

    Raises:
        UrdfError: ``collision`` is true, and there are no collision shapes or not all of them can be read.
        ArgumentError: n is below 1, the seed is negative, or ``time_limit`` is no number of seconds.

    Example:
        >>> import urdf_ik
        >>> check(urdf_ik.load("planar_2r"), n=5).passed
        True
    """
    inputs.arm(arm)
    n = inputs.poses(n)
    seed = _seed(seed)
    watch = Watch(time_limit, progress)
    reference = Reference(arm.model, arm.base, arm.tip, locked=dict(arm.chain.locked))
    names = limits(arm, reference)
    tallies, skipped, unlooked = [names], [], ""
    if tuple(arm.joint_names) != reference.joint_names:
        skipped.append(("all else", "the arm's joints are not Pinocchio's"))
    else:
        kinematics, inverse = Kinematics(arm, reference), Inverse(arm, reference)
        touching, reason = _collision(arm, collision, collision_poses)
        for start in range(0, n, _CHUNK):
            if watch.is_over:
                unlooked = watch.ended(f"with {start} of {n} poses: the others were")
                break
            indices = range(start, min(start + _CHUNK, n))
            Q = np.array([_draw(reference, seed, index) for index in indices])
            T = reference.pose(Q)
            kinematics.take(indices, Q, T)
            solutions = inverse.take(indices, Q, T)
            if touching is not None:
                touching.take(indices, Q, solutions)
            watch.step(indices.stop, n)
        tallies += kinematics.tallies + inverse.tallies
        tallies += [] if touching is None else touching.tallies
        skipped += inverse.skipped + ([("collision", reason)] if reason else [])
    return Report(
        robot=arm.name,
        base=reference.base,
        tip=reference.tip,
        joint_names=reference.joint_names,
        n=n,
        seed=seed,
        reference=f"Pinocchio {pin.__version__}",
        # What time left nothing to compare of is no failure.
        rows=tuple(tally.row() for tally in tallies if tally.checked or not unlooked),
        skipped=tuple(skipped),
        unlooked=unlooked,
    )


def replay(arm: Arm, seed: int, index: int) -> tuple[Array, Array]:
    """Pose ``index`` of a check once more: it depends on the arm, the seed and the index alone.

    Args:
        arm: the arm that was checked.
        seed: the report's seed.
        index: the row's index.

    Returns:
        The planted joint vector (n,) [rad or m] and Pinocchio's pose for it, (4, 4) [m].

    Raises:
        ArgumentError: the seed or the index is negative.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("scara_rrpr")
        >>> q, T = replay(arm, seed=0, index=3)
        >>> bool(abs(arm.fk(q) - T).max() < 1e-9)
        True
    """
    inputs.arm(arm)
    seed = _seed(seed)
    index = inputs.whole(index, "index")
    reference = Reference(arm.model, arm.base, arm.tip, locked=dict(arm.chain.locked))
    q = _draw(reference, seed, index)
    return q, reference.pose(q)


def _draw(reference: Reference, seed: int, index: int) -> Array:
    """Joint vector (n,) of pose ``index``, within the limits or one turn."""
    lower, upper = reference.ranges.T
    q: Array = np.random.default_rng([seed, index]).uniform(lower, upper)
    return q


def _seed(seed: int) -> int:
    return inputs.whole(seed, "seed", high=2**64)


def _collision(arm: Arm, wanted: bool | None, most: int | None) -> tuple[Collision | None, str]:
    """The comparison of collisions, or None and the reason why it is skipped."""
    if wanted is False:
        return None, "not asked for"
    shapes = CollisionModel(arm.model, arm.base, arm.tip, locked=dict(arm.chain.locked))
    if not shapes.has_geometry:
        if wanted:
            raise UrdfError(shapes.missing, source=arm.model.source)
        return None, shapes.missing
    if not shapes.checked_pairs:
        return None, "no pair of links is left that must not touch"
    return Collision(arm, shapes, most), ""
