"""Target poses: typed, of a joint vector, from a file, random, or the arm's example."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.arm import example as examples
from urdf_ik.cli import console
from urdf_ik.cli.console import Angles
from urdf_ik.cli.options import PartOfPose, PoseOptions
from urdf_ik.ik.solutions.limits import LIMIT_TOLERANCE
from urdf_ik.model.poses import ORIENTATIONS as NOTATIONS
from urdf_ik.model.poses import pose
from urdf_ik.support import files
from urdf_ik.support.angles import TURN, shown, unit_of
from urdf_ik.typing import Array

ORIENTATIONS = {f"--{name.replace('_', '-')}": names for name, names in NOTATIONS.items() if hasattr(PoseOptions, name)}
"""The options that are orientations, and what their numbers are called."""
EXACT = 1e-9
"""Distance from a planar arm's plane up to which a point lies in it [m]."""
SHORTEST = 4
"""Numbers with fewer decimals than this, as 0.2 or 3.14, are meant as they stand."""
POINT_TASKS = ("position", "planar position", "look at")
"""Tasks whose targets have no orientation."""


@dataclass(frozen=True)
class Target:
    """Poses (N, 4, 4) to solve, and a sentence on where they come from.

    ``redundancy``: (N,) or (N, k) rad or m, the redundancy parameters of each; None: the arm's defaults, or none.
    ``source``: the file of the poses, or the option that they were typed with. ``tolerance``: m and rad that their
    decimals leave open; None: they are exact.
    """

    poses: Array
    note: str
    redundancy: Array | None = None
    source: str = ""
    tolerance: tuple[float, float] | None = None


def target(arm: Arm, typed: PoseOptions, random: int | None, seed: int, angles: Angles, task: str = "pose") -> Target:
    """The target poses of the options; without any, the arm's example.

    ``task``: the part of the poses that counts, see :mod:`urdf_ik.ik.tasks`.
    """
    found = given(arm, typed, angles, task)
    if found is not None and random is not None:
        option = "--poses" if typed.poses is not None else found.source
        raise console.usage(f"{option} and --random exclude each other; give one kind of target")
    if random is not None:
        note = f"poses: {random} of random joint vectors inside the limits, seed {seed}"
        return _of_vectors(arm, examples.draws(arm, random, seed), note)
    if found is None:
        q = examples.example(arm, seed)
        shown = ",".join(f"{x:.6g}" for x in angles.vectors(q))
        found = _of_vectors(arm, q[None], f"target: this arm's example, the tip at q = {shown}")
    return found


def given(arm: Arm, typed: PoseOptions, angles: Angles, task: str = "pose") -> Target | None:
    """The poses that are typed, or that a file holds; None without any."""
    from urdf_ik.paths.waypoints import read_poses

    oriented = [option for option in ORIENTATIONS if _typed_as(typed, option)]
    kinds = {"--xyz": bool(typed.xyz or oriented), "--q": bool(typed.q), "--poses": typed.poses is not None}
    there = [option for option, is_there in kinds.items() if is_there]
    if len(there) > 1:
        raise console.usage(f"{' and '.join(there)} exclude each other; give one kind of target")
    if typed.q:
        q = angles.typed_vectors(console.joint_vectors(typed.q, "--q", arm.joint_names))
        return replace(_of_vectors(arm, q, "target: the tip at the joint vector that was given"), source="--q")
    if typed.poses is not None:
        poses = read_poses(console.opened(typed.poses, "--poses"), degrees=angles.degrees)
        source = files.STDIN if typed.poses == console.STDIN else typed.poses
        return Target(poses, f"poses: {len(poses)} from {source}", source=source)
    return _typed(arm, typed, oriented, angles, task) if there else None


def required(arm: Arm, typed: PoseOptions, angles: Angles, what: str) -> Target:
    """The poses that are typed or in a file, which a message calls ``what``."""
    found = given(arm, typed, angles)
    if found is None:
        raise console.usage(f"{what} are needed, such as --poses seam.csv", "--poses")
    return found


def task_of(task: PartOfPose | None, axis: str | None) -> tuple[str, Any]:
    """The task and the axis that were typed, as ``arm.for_task`` takes them."""
    if task is None and axis is not None:
        raise console.usage("it is the axis of a task: --task position, axis or look-at", "--axis")
    asked = "pose" if task is None else task.value.replace("-", " ")
    asked = "position and axis" if asked == "position" and axis is not None else asked
    named = axis is None or axis in ("x", "y", "z")
    return asked, axis if named or axis is None else console.numbers(axis, "--axis", ("x", "y", "z"))


def of_task(arm: Arm, poses: Array) -> Array:
    """The targets of an arm for a task that belong to poses (N, 4, 4)."""
    if arm.solver.targets is None:
        return poses
    plane, out = arm.solver.control.plane, arm.solver.control.target_of(poses)
    if plane is not None:
        off = np.abs((poses[:, :3, 3] - plane.origin) @ plane.normal)
        if off.max() > EXACT:
            message = f"target {int(off.argmax())} is {off.max():.4g} m off the plane in which {arm.name} moves"
            raise console.usage(message, "--xyz")
    return out


def spread(arm: Arm, target: Target, typed: str | None, angles: Angles) -> Target:
    """``target`` with the values of the redundancy parameter: each pose at every value typed, else as it is."""
    if typed is None:
        return target
    count = len(arm.solver.parameters)
    if not count:
        raise console.usage(f"this arm's {arm.dof} joints leave nothing free in a pose", "--redundancy")
    values = console.numbers(typed, "--redundancy", ["value"] * len(console.split(typed)))
    if not len(values) or len(values) % count:
        needed = "a value is needed" if count == 1 else f"{count} values are needed, or so many times as many, one"
        raise console.usage(f"{needed} of the {'; of the '.join(map(str, arm.solver.parameters))}", "--redundancy")
    if angles.degrees:
        turns = np.tile([parameter.unit == "rad" for parameter in arm.solver.parameters], len(values) // count)
        values = np.where(turns, np.deg2rad(values), values)
    for parameter, column in zip(arm.solver.parameters, values.reshape(-1, count).T, strict=True):
        room, past = np.diff(parameter.range) + 2.0 * LIMIT_TOLERANCE, column - parameter.range[0] + LIMIT_TOLERANCE
        past = past % TURN if parameter.unit == "rad" else past
        if len(beyond := shown(column[(past < 0.0) | (past > room)], parameter.unit)):
            outside = f"{', '.join(f'{x:g}' for x in beyond)} {unit_of(parameter.unit)} is outside the {parameter}"
            console.say(f"warning: --redundancy: {outside}")
    values = values if count == 1 else values.reshape(-1, count)
    poses = np.repeat(target.poses, len(values), axis=0)
    return replace(target, poses=poses, redundancy=np.concatenate([values] * len(target.poses)))


def _typed_as(typed: PoseOptions, option: str) -> Sequence[str]:
    """What was typed for an option of a pose."""
    return getattr(typed, option.removeprefix("--").replace("-", "_")) or ()


def _typed(arm: Arm, typed: PoseOptions, oriented: Sequence[str], angles: Angles, task: str) -> Target:
    count = len(typed.xyz or ())
    if not typed.xyz:
        raise console.usage(f"{oriented[0]} needs a position with it: --xyz x,y,z", "--xyz")
    positions = np.array([console.numbers(text, "--xyz", ("x", "y", "z")) for text in typed.xyz])
    if not oriented and task in POINT_TASKS:
        return Target(pose(positions), "target: as typed", source="--xyz")
    if len(oriented) != 1:
        raise console.usage(
            f"--xyz needs one orientation with it, of {', '.join(ORIENTATIONS)}; "
            f"{' and '.join(oriented) if oriented else 'none'} given{_of_less(arm)}",
            "--xyz",
        )
    option = oriented[0]
    values = np.array([console.numbers(text, option, ORIENTATIONS[option]) for text in _typed_as(typed, option)])
    if len(values) not in (1, count):
        raise console.usage(f"{len(values)} orientations for {count} positions; give one for all, or one each", option)
    in_degrees = angles.degrees and len(ORIENTATIONS[option]) == 3
    if in_degrees:
        values = np.deg2rad(values)
    values = np.broadcast_to(values, (count, values.shape[1]))
    orientation: dict[str, Any] = {option.removeprefix("--").replace("-", "_"): values}
    poses = pose(positions, **orientation)
    place = _rounding(typed.xyz)
    # Half a unit of each number's last digit: three numbers, or the four of a quaternion of twice the angle.
    turn = _rounding(_typed_as(typed, option)) * (4.0 if option.startswith("--quat") else 3.0)
    tolerance = (place * 3.0**0.5, np.deg2rad(turn) if in_degrees else turn)
    note = f"target: as typed{_unit(option, values, in_degrees)}"
    return Target(poses, note, source="--xyz", tolerance=tolerance)


def _rounding(texts: Sequence[str]) -> float:
    """Half a unit of the last decimal of typed numbers, of the longest one; of short numbers that of six decimals."""
    decimals = max(
        (len(part.partition(".")[2]) for text in texts for part in console.split(text) if "e" not in part.lower()),
        default=0,
    )
    return 0.5 * 10.0 ** -(decimals if decimals >= SHORTEST else 6)


def _unit(option: str, values: Array, in_degrees: bool) -> str:
    """The unit of typed angles, where it is not what is expected: rad, and rarely more than a turn of them."""
    if in_degrees:
        return f", {option} in degrees"
    most = float(np.abs(values).max())
    if len(ORIENTATIONS[option]) == 4 or most <= 2.0 * np.pi:
        return ""
    return f", {option} in rad, of which {most:g} are {most / (2.0 * np.pi):.1f} turns; --degrees reads degrees"


def _of_less(arm: Arm) -> str:
    """How to ask an arm that controls less than a pose."""
    own = "" if arm.task == "pose" else f"; {arm.name} controls its {arm.task}: --task {arm.task.replace(' ', '-')}"
    return own if arm.dof < 3 or arm.task.startswith("planar") else f"{own}; any orientation: --task position"


def _of_vectors(arm: Arm, q: Array, note: str) -> Target:
    """The poses of joint vectors (N, n), with the redundancy parameters of these joint vectors."""
    return Target(arm.fk(q), note, None if arm.redundancy is None else arm.redundancy_of(q))
