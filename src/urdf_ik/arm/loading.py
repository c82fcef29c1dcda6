"""``load``: from a URDF to an arm; ``with_positioner``: from two, one of which carries the workpiece."""

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import IO, Any

from urdf_ik.arm import compiled
from urdf_ik.arm.arm import Arm, assemble
from urdf_ik.cell.cell import Cell
from urdf_ik.errors import ArgumentError, ChainError
from urdf_ik.kinematics.chain import from_urdf
from urdf_ik.model import catalogue, urdf
from urdf_ik.model.poses import check_poses
from urdf_ik.model.srdf import chain_groups, defects_of, disabled_pairs, groups_beside
from urdf_ik.model.urdf.checks import UrdfWarning, together
from urdf_ik.model.urdf.edits import joined
from urdf_ik.model.xml import require_name

Robot = Arm | str | os.PathLike[str] | IO[Any]
"""An arm, or the source of one."""


def loaded(robot: Robot) -> Arm:
    """The arm itself, or that of a source, by :func:`load`."""
    return robot if isinstance(robot, Arm) else load(robot)


def load(
    source: str | os.PathLike[str] | IO[Any],
    base: str | None = None,
    tip: str | None = None,
    *,
    chain: str | None = None,
    srdf: str | os.PathLike[str] | bytes | None = None,
    locked: Mapping[str, float] | None = None,
    redundancy: str | Sequence[str] = (),
    mesh_roots: Sequence[str | os.PathLike[str]] = (),
    xacro_args: Mapping[str, object] | None = None,
    strict: bool = False,
) -> Arm:
    """Read a URDF and prepare its solver.

    Args:
        source: a path, XML text, an open file, or a name such as 'zyyzyz_6r', 'ur5' or 'ur10e_description'. Names are
            those of the catalogue and of robot_descriptions, which downloads a model at its first use. A file may be a
            MuJoCo model (MJCF), or a xacro if its name ends in ``.xacro``.
        base: base link; default: the root.
        tip: tip link; default: the tool frame of the longest chain, if there is only one (see
            :meth:`urdf_ik.model.urdf.UrdfModel.chains`).
        chain: instead of a tip, the name of one arm of several: a group of the SRDF, or of one beside the file, or a
            name that ``urdf-ik info --chains`` lists, such as 'left' or 'left_arm'.
        srdf: an SRDF; its groups with a ``<chain>``, if it has any, are the chains to choose from, and the pairs of
            its ``<disable_collisions>`` may touch. Pairs with links that the URDF lacks allow nothing.
        locked: values [rad or m] of joints that do not move. An arm with more than nine joints needs locked joints
            to be solved. Joints outside the chain, such as those of a second arm, are at zero unless they are locked
            elsewhere; collision checks see their links there. See :meth:`urdf_ik.Arm.with_locked`.
        redundancy: joint or joints whose values are the redundancy parameters of an arm with more than six joints;
            default: those that are cheapest to solve. See :meth:`urdf_ik.Arm.with_redundancy`.
        mesh_roots: folders from which meshes may be read, besides the URDF's own and its ROS package. Packages are
            searched in these first, then in AMENT_PREFIX_PATH and ROS_PACKAGE_PATH.
        xacro_args: arguments of a xacro, by name. A xacro is a program: expand only what you trust.
        strict: whether every defect of the URDF and every unknown link of the SRDF is an error; default: defects in
            parts that the chain does not use are in ``arm.model.warnings``.

    Raises:
        UrdfError: the URDF is broken where the chain uses it; the error names line, element and hint.
        ChainError: base, tip, a locked joint or one of ``redundancy`` is unknown, or base or tip ambiguous; the error
            lists the candidates.
        ArgumentError: a locked joint's value is not a finite number.
        ArgumentError: the name is unknown, or its model cannot be downloaded.
        MissingPackage: the package that reads a xacro or MJCF is not installed.
        ArgumentError: ``redundancy`` names more joints than the arm has redundancy parameters.
        UnsupportedArm: the chain holds a joint of a kind that is not supported.

    Example:
        >>> load("zyyzyz_6r")
        <Arm 'zyyzyz_6r': base_link to tool0, 6R spherical wrist, 2||3 and 1x2>
    """
    model, entry = read(source, mesh_roots=mesh_roots, xacro_args=xacro_args, strict=strict)
    disabled: tuple[tuple[str, str], ...] = ()
    defects: tuple[UrdfWarning, ...] = ()
    if srdf is not None:
        if (defects := defects_of(srdf, model.links)) and strict:
            raise together([each.error for each in defects])
        model = replace(model, warnings=(*model.warnings, *defects))
        disabled = disabled_pairs(srdf, model.links)
    try:
        ends = choose_chain(model, entry, base, tip, chain=chain, srdf=srdf)
    except ChainError as error:  # the SRDF's slips may be why
        if chain is not None:
            error.args = ("; ".join(map(str, (error, *(each.error for each in defects)))),)
        raise
    joints = from_urdf(model, *ends).lock({} if locked is None else locked)
    chosen = (redundancy,) if isinstance(redundancy, str) else redundancy
    return assemble(model, joints, chosen=chosen, cell=Cell(model, joints, disabled=disabled))


def read(
    source: str | os.PathLike[str] | IO[Any],
    *,
    mesh_roots: Sequence[str | os.PathLike[str]] = (),
    xacro_args: Mapping[str, object] | None = None,
    strict: bool = False,
) -> tuple[urdf.UrdfModel, catalogue.Entry | None]:
    """The URDF behind a path, XML text, an open file or a name, with what the catalogue says of the name.

    Raises:
        UrdfError: the URDF is broken.
        ArgumentError: the name is unknown, or its model cannot be downloaded.
        MissingPackage: the package that reads a xacro or MJCF is not installed.
    """
    if compiled.is_compiled(source):
        raise ArgumentError(f"{source!r} is a compiled arm; urdf_ik.load_compiled reads it")
    entry = None
    if isinstance(source, str) and _is_name(source):
        entry = catalogue.resolve(source)
        roots = [mesh_roots] if isinstance(mesh_roots, str | os.PathLike) else mesh_roots
        source, mesh_roots = entry.path, (*roots, *entry.package_dirs)
        if entry.xacro_args is not None:
            xacro_args = {**entry.xacro_args, **(xacro_args or {})}
    return urdf.read(source, mesh_roots=mesh_roots, xacro_args=xacro_args, strict=strict), entry


def choose_chain(
    model: urdf.UrdfModel,
    entry: catalogue.Entry | None,
    base: str | None,
    tip: str | None,
    *,
    chain: str | None = None,
    srdf: str | os.PathLike[str] | bytes | None = None,
) -> tuple[str | None, str | None]:
    """Base and tip of the chain that the arguments of :func:`load` mean; a base of None is the root.

    In this order: base and tip themselves, a group of the SRDF, the catalogue's base and tip, a group of an SRDF beside
    the URDF, the chains of the URDF.

    Raises:
        ChainError: there is no such chain, or there are several and none is named.
        ArgumentError: both a chain and a tip are given.
    """
    if tip is not None:
        if chain is not None:
            raise ArgumentError(f"chain={chain!r} and tip={tip!r} say the same; give one of them")
        return entry.base if entry is not None and base is None else base, tip
    if groups := {} if srdf is None else dict(chain_groups(srdf, model.links, strict=False)):
        name = next(iter(groups)) if chain is None and len(groups) == 1 else chain
        if name not in groups:
            if chain is not None and srdf is not None:
                chain_groups(srdf, model.links)  # a group that names a link which is not there says so
            what = "several chains; name one" if name is None else f"no chain {name!r}"
            raise ChainError(f"{model.source}: the SRDF has {what}", groups)
        return groups[name][0] if base is None else base, groups[name][1]
    if entry is not None and chain is None:
        base, tip = entry.base if base is None else base, entry.tip
    if tip is not None:
        return base, tip
    beside = groups_beside(model.path, model.name, model.links) if chain is not None and model.path else {}
    if chain in beside:
        return base or beside[chain][0], beside[chain][1]
    return model.resolve_chain(base, None, chain)


def _is_name(source: str) -> bool:
    """Whether ``source`` can only be meant as a catalogue name: no markup, no folder, no ending, no such file."""
    if not re.fullmatch(r"[\w+-]+", source):
        return False
    try:
        return not Path(source).exists()
    except OSError:  # too long to be the name of a file
        return True


def with_positioner(arm: Robot, positioner: Robot, pose: Any, name: str = "positioner") -> Arm:
    """An arm with a positioner from another URDF that carries the workpiece; poses are in the positioner's tip frame.

    The new arm is the chain from the positioner's tip, back to its base, and up the arm: its base is the link
    ``f"{name}_{positioner.tip}"``, its first joints are the positioner's, from its tip to its base. The
    joints beyond six give redundancy parameters. For a positioner in the same URDF, ``load(..., base=workpiece)`` is
    enough.

    Args:
        arm: the arm, or the source of one.
        positioner: the chain from its base to the link that carries the workpiece, likewise.
        pose: (4, 4) m of the positioner's root link in the arm's base, or a ``pinocchio.SE3``.
        name: prefix of the names of the positioner's links and joints.

    Raises:
        PoseError: an invalid pose.
        ArgumentError: a name is taken, or ``name`` is not valid in a URDF.
        UnsupportedArm: no solver takes the joints.

    Example:
        >>> import urdf_ik
        >>> from urdf_ik.arm import with_positioner
        >>> table = urdf_ik.load("planar_2r", tip="link_1")
        >>> cell = with_positioner(urdf_ik.load("puma_560"), table, urdf_ik.pose([0.6, 0.0, 0.2]), name="table")
        >>> cell.base, cell.dof, cell.redundancy.joint
        ('table_link_1', 7, 'table_joint_1')
    """
    arm, positioner, at = loaded(arm), loaded(positioner), check_poses(pose)
    if at.ndim != 2:
        raise ArgumentError(f"a pose of shape {at.shape} given; one pose (4, 4) is needed")
    require_name(name, "the positioner")
    model = joined(arm.model, positioner.model, arm.base, at, f"{name}_")
    held = {**dict(arm.chain.locked), **{f"{name}_{joint}": value for joint, value in positioner.chain.locked}}
    chain = from_urdf(model, f"{name}_{positioner.tip}", arm.tip).lock(held)
    own = arm.solver
    return assemble(model, chain, own.settings["task"], own.free_axis, own.chosen, arm.cell.moved_to(model, chain))
