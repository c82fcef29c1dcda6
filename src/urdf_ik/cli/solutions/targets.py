"""Target poses: typed, of a joint vector, from a file, random, or the arm's example."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik.cli import console
from urdf_ik.cli.solutions.redundancy import own_values

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.arm import Arm
    from urdf_ik.cli.console import Angles
    from urdf_ik.cli.options import Pose

ORIENTATIONS: Mapping[str, tuple[str, ...]] = {
    "--quat-xyzw": ("x", "y", "z", "w"),
    "--quat-wxyz": ("w", "x", "y", "z"),
    "--rpy": ("roll", "pitch", "yaw"),
    "--rotvec": ("rx", "ry", "rz"),
}
# The example is drawn from the middle of each joint's range, where its joint values are easy to picture.
EXAMPLE_DRAWS = 256
EXAMPLE_SHARE = 0.6


@dataclass(frozen=True)
class Target:
    """Poses (N, 4, 4) to solve, and a sentence on where they come from.

    ``redundancy``: (N,) or (N, k) rad or m, the redundancy parameters of each; None: the arm's defaults, or none.
    """

    poses: NDArray[np.float64]
    note: str
    redundancy: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class TargetOptions:
    """The target options as typed; None where one was not given."""

    typed: Pose
    q: Sequence[str]
    poses: str | None
    random: int | None
    seed: int


def target(arm: Arm, given: TargetOptions, angles: Angles) -> Target:
    """The target poses of the options.

    Raises:
        typer.BadParameter: options that exclude each other, or values that do not make a pose.
    """
    oriented = [option for option, text in _orientations(given.typed).items() if text is not None]
    kinds = {
        "--xyz": given.typed.xyz is not None or bool(oriented),
        "--q": bool(given.q),
        "--poses": given.poses is not None,
        "--random": given.random is not None,
    }
    chosen = [option for option, there in kinds.items() if there]
    if len(chosen) > 1:
        raise console.usage(f"{' and '.join(chosen)} exclude each other; give one kind of target")
    if not chosen:
        return _example(arm, angles, given.seed)
    if given.q:
        return _planted(arm, given.q, angles)
    if given.poses is not None:
        poses = console.read_poses(given.poses, "--poses")
        return Target(poses, f"poses: {len(poses)} from {console.place(given.poses)}")
    if given.random is not None:
        note = f"poses: {given.random} of random joint vectors inside the limits, seed {given.seed}"
        return _of_vectors(arm, _draws(arm, given.random, given.seed), note)
    return _typed(given.typed, oriented, angles)


def spread(arm: Arm, target: Target, typed: str | None, angles: Angles) -> Target:
    """``target`` with the values of the redundancy parameter: each pose at every value typed, else as it is.

    Raises:
        typer.BadParameter: values that are not numbers, or an arm without such a parameter.
    """
    if typed is None:
        return target
    count = len(arm.solver.parameters)
    if not count:
        raise console.usage(f"this arm's {arm.dof} joints leave nothing free in a pose", "--redundancy")
    values = console.numbers(typed, "--redundancy", ["value"] * len(typed.replace(",", " ").split()))
    if not len(values) or len(values) % count:
        needed = "a value is needed" if count == 1 else f"{count} values are needed, or so many times as many, one"
        raise console.usage(f"{needed} of the {'; of the '.join(map(str, arm.solver.parameters))}", "--redundancy")
    if angles.degrees:
        turns = np.tile([parameter.unit == "rad" for parameter in arm.solver.parameters], len(values) // count)
        values = np.where(turns, np.deg2rad(values), values)
    values = values if count == 1 else values.reshape(-1, count)
    poses = np.repeat(target.poses, len(values), axis=0)
    return replace(target, poses=poses, redundancy=np.concatenate([values] * len(target.poses)))


def _orientations(typed: Pose) -> dict[str, str | None]:
    """Each orientation by its option."""
    return {option: getattr(typed, option.removeprefix("--").replace("-", "_")) for option in ORIENTATIONS}


def _typed(typed: Pose, oriented: Sequence[str], angles: Angles) -> Target:
    from urdf_ik.model.poses import pose

    if typed.xyz is None:
        raise console.usage(f"{oriented[0]} needs a position with it: --xyz x,y,z", "--xyz")
    if len(oriented) != 1:
        raise console.usage(
            f"--xyz needs one orientation with it, of {', '.join(ORIENTATIONS)}; "
            f"{' and '.join(oriented) if oriented else 'none'} given",
            "--xyz",
        )
    option = oriented[0]
    position = console.numbers(typed.xyz, "--xyz", ("x", "y", "z"))
    values = console.numbers(str(_orientations(typed)[option]), option, ORIENTATIONS[option])
    if angles.degrees and not option.startswith("--quat"):
        values = np.deg2rad(values)
    T = pose(position, **{option.removeprefix("--").replace("-", "_"): values})
    return Target(T.reshape(1, 4, 4), "target: as typed")


def _planted(arm: Arm, typed: Sequence[str], angles: Angles) -> Target:
    q = angles.typed(np.array([console.numbers(text, "--q", arm.joint_names) for text in typed]))
    return _of_vectors(arm, q, "target: the tip at the joint vector that was given")


def _of_vectors(arm: Arm, q: NDArray[np.float64], note: str) -> Target:
    """The poses of joint vectors (N, n), with the redundancy parameters of these joint vectors."""
    return Target(arm.fk(q), note, own_values(arm, q))


def _example(arm: Arm, angles: Angles, seed: int) -> Target:
    """The pose with most solutions among seeded draws, of joint values that are short to write."""
    q = _draws(arm, EXAMPLE_DRAWS, seed, EXAMPLE_SHARE)
    lower, upper = arm.limits.T
    rounded = np.round(q, 1)
    q = np.where((rounded >= lower) & (rounded <= upper), rounded, q)
    solutions = arm.ik(arm.fk(q), redundancy=own_values(arm, q))
    regular = (solutions.valid & (solutions.singular == 0)).sum(axis=-1)
    inside = solutions.within_limits().valid.sum(axis=-1)
    best = int(np.lexsort((-inside, -regular))[0])
    shown = ",".join(f"{x:.6g}" for x in angles.shown(q[best]))
    return _of_vectors(arm, q[best : best + 1], f"target: this arm's example, the tip at q = {shown}")


def _draws(arm: Arm, count: int, seed: int, share: float = 1.0) -> NDArray[np.float64]:
    """Joint vectors (count, n) from the middle ``share`` of the limits, within half a turn or a metre of zero."""
    turning = np.array([kind != "prismatic" for kind in arm.chain.joint_types])
    reach = np.where(turning, np.pi, 1.0)
    lower, upper = np.clip(arm.limits.T, -reach, reach)
    # A joint whose whole range lies beyond half a turn is left as it is: clipping would leave its limits.
    outside = (arm.limits[:, 0] > reach) | (arm.limits[:, 1] < -reach)
    lower, upper = np.where(outside, arm.limits[:, 0], lower), np.where(outside, arm.limits[:, 1], upper)
    middle, half = 0.5 * (lower + upper), 0.5 * share * (upper - lower)
    return middle + half * np.random.default_rng(seed).uniform(-1.0, 1.0, size=(count, len(lower)))
