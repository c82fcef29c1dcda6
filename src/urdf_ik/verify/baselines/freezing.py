"""Freezing an arm: its answers of today as a baseline."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.errors import UnsupportedArm
from urdf_ik.model.poses import as_pose_array, check_poses
from urdf_ik.support import inputs
from urdf_ik.support.watch import Progress, Watch
from urdf_ik.verify import arms
from urdf_ik.verify.baselines.baseline import Baseline
from urdf_ik.verify.baselines.pose_sampling import AT_ONCE, COUNTS, DRAWN, made_by, planted_vectors, solved
from urdf_ik.verify.baselines.records import Pose
from urdf_ik.verify.description import described

SIZE = 200_000
"""Bytes that a lock file has at most, unless the poses of its user need more."""

_SEED = 20_260_101


def freeze(
    arm: Arm,
    poses: Any = None,
    *,
    seed: int = _SEED,
    collisions: str | bool = True,
    time_limit: float | None = None,
    progress: Progress | None = None,
) -> Baseline:
    """An arm's answers of today, to be compared with those of tomorrow.

    Kept are joints, axes, limits, shapes, Pinocchio's pose at 20 joint vectors, and every solution of 50 poses: random
    ones, joints at round angles, near limits and near singularities.

    Args:
        arm: the arm.
        poses: (..., 4, 4) m, poses of your own, which are kept as well.
        seed: of the random poses.
        collisions: whether to keep which solutions touch something: True where the shapes can be read, with a warning
            where they cannot; 'require' to fail there; False: no.
        time_limit: s after which no more poses are solved, yours first; ``unlooked`` says how many were left out.
        progress: called with (poses done, poses).

    Returns:
        The baseline; ``save`` writes it to a lock file.

    Raises:
        PoseError: one of ``poses`` is no pose.
        UrdfError: ``collisions="require"``, and not all shapes can be read.
        ArgumentError: ``collisions``, ``seed``, ``time_limit`` or ``progress`` is none of these.

    Example:
        >>> import urdf_ik
        >>> lock = freeze(urdf_ik.load("planar_2r"))
        >>> len(lock.planted), sorted({pose.kind for pose in lock.poses})
        (20, ['near limits', 'near singularity', 'random', 'round'])
    """
    inputs.arm(arm)
    watch = Watch(time_limit, progress)
    seed = inputs.whole(seed, "seed", high=2**64)
    own = np.zeros((0, 4, 4)) if poses is None else check_poses(as_pose_array(poses)).reshape(-1, 4, 4)
    reference = arms.reference_of(arm)
    shapes, unchecked = arm.cell.to_check(collisions)
    rng = np.random.default_rng(seed)
    planted = planted_vectors(reference, rng)
    q = {kind: DRAWN[kind](arm, reference, rng, count) for kind, count in COUNTS.items()}
    baseline = Baseline(described(arm), planted, (), unchecked and f"not checked: {unchecked}", made_by())
    asked = [("own", own, None), *((kind, reference.pose(Q), Q) for kind, Q in q.items())]
    total = sum(len(T) for _, T, _ in asked)
    found: list[Pose] = []
    try:
        for kind, T, Q in asked:
            for start in range(0, len(T), AT_ONCE):
                if watch.is_over:
                    break
                some = slice(start, start + AT_ONCE)
                found += solved(arm, kind, T[some], None if Q is None else Q[some], shapes)
                watch.step(len(found), total)
    except UnsupportedArm:
        if len(own):
            raise
        return baseline
    if len(found) < total:
        baseline = replace(baseline, unlooked=watch.ended(f"with {len(found)} of {total} poses: the others were"))
    mine, kept = found[: len(own)], found[len(own) :]
    baseline = replace(baseline, poses=tuple(kept))
    while (size := len(baseline.to_text())) > SIZE and len(kept) > len(COUNTS):
        # Every kind keeps its share.
        kept = kept[:: max(2, size // SIZE)]
        baseline = replace(baseline, poses=tuple(kept))
    return replace(baseline, poses=(*baseline.poses, *mine))
