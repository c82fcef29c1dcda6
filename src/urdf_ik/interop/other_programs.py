"""Arms and solutions as the types of other programs: ROS messages, pink, viser and rerun.

Pinocchio's configurations are methods of the arm: ``arm.to_pinocchio(q)`` and ``arm.from_pinocchio(q_pin)``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError
from urdf_ik.model import link_shapes
from urdf_ik.model.poses import to_quat_wxyz
from urdf_ik.support import extras, inputs
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

__all__ = [
    "RerunArm",
    "ViserArm",
    "add_to_rerun",
    "add_to_viser",
    "from_joint_state",
    "pink_configuration",
    "to_joint_state",
]


def to_joint_state(arm: Arm, q: ArrayLike, names: Sequence[str], others: ArrayLike | None = None) -> Array:
    """Joint vectors as the positions of a ``sensor_msgs/JointState`` whose ``name`` is ``names``.

    Args:
        arm: the arm.
        q: (..., n) rad or m.
        names: joints of the message, in its order; more than the arm's, or fewer.
        others: (k,) the message's positions so far, for joints that are not the arm's; default: NaN.

    Returns:
        (..., k) rad or m.

    Raises:
        ArgumentError: q or ``others`` has another length, or ``names`` holds a name twice.

    Example:
        >>> import urdf_ik
        >>> from urdf_ik import interop
        >>> arm = urdf_ik.load("planar_2r_unit")
        >>> interop.to_joint_state(arm, [0.1, 0.2], ["gripper", "joint_2", "joint_1"], others=[0.04, 0.0, 0.0]).tolist()
        [0.04, 0.2, 0.1]
    """
    inputs.arm(arm)
    Q, place = arm.chain.check(q, padded=True), _places(names)
    given = None if others is None else inputs.real(others, "others", "a position for each name")
    kept = np.full(len(names), np.nan) if given is None else given
    if kept.shape != (len(names),):
        raise ArgumentError(f"others has the shape {kept.shape}; one position for each of {len(names)} names is needed")
    out = np.tile(kept, (*Q.shape[:-1], 1))
    for column, name in enumerate(arm.joint_names):
        if name in place:
            out[..., place[name]] = Q[..., column]
    return out


def from_joint_state(arm: Arm, names: Sequence[str], positions: ArrayLike) -> Array:
    """Joint vectors (..., n) rad or m of a ``sensor_msgs/JointState``: the inverse of :func:`to_joint_state`.

    Args:
        arm: the arm.
        names: joints of the message, in its order; all of the arm's are among them.
        positions: (..., k) rad or m.

    Raises:
        ArgumentError: a joint of the arm is missing, a name stands there twice, or the shapes do not fit.

    Example:
        >>> import urdf_ik
        >>> from urdf_ik import interop
        >>> arm = urdf_ik.load("planar_2r_unit")
        >>> interop.from_joint_state(arm, ["gripper", "joint_2", "joint_1"], [0.04, 0.2, 0.1]).tolist()
        [0.1, 0.2]
    """
    inputs.arm(arm)
    given, place = inputs.real(positions, "positions", "joint positions"), _places(names)
    if given.shape[-1:] != (len(names),):
        raise ArgumentError(f"positions of shape {given.shape} for {len(names)} names; (..., {len(names)}) is needed")
    if missing := [name for name in arm.joint_names if name not in place]:
        raise ArgumentError(f"the message lacks {', '.join(missing)}; it has {', '.join(names)}")
    out: Array = given[..., [place[name] for name in arm.joint_names]]
    return arm.chain.check(out)


def pink_configuration(arm: Arm, q: ArrayLike) -> Any:
    """A ``pink.Configuration`` of the whole URDF with the arm at ``q``, to begin pink's tasks from.

    ``arm.from_pinocchio(configuration.q)`` is the way back.

    Args:
        arm: the arm.
        q: (n,) rad or m, such as a solution of ``arm.ik``.

    Raises:
        ArgumentError: q is not (n,).
        MissingPackage: pink is not installed.

    Example:
        >>> import urdf_ik
        >>> from urdf_ik import interop
        >>> arm = urdf_ik.load("puma_560")
        >>> q = [0.3, -0.5, 0.8, 0.4, 0.7, -0.2]
        >>> configuration = interop.pink_configuration(arm, q)
        >>> arm.from_pinocchio(configuration.q).round(6).tolist() == q
        True
    """
    try:
        import pink
    except ImportError:
        raise extras.missing("pink is not installed", "interop") from None
    inputs.arm(arm)
    model = arm.cell.reference.pin_model
    return pink.Configuration(model, model.createData(), arm.to_pinocchio(_one(arm, q)))


class ViserArm:
    """An arm in a viser scene; see :func:`add_to_viser`.

    Attributes:
        arm: the arm.
        root: viser's frame that holds the links; set its ``position`` and ``wxyz`` to move the whole arm.
        missing: a sentence for each shape that could not be read.
    """

    def __init__(self, scene: Any, arm: Arm, name: str) -> None:
        inputs.arm(arm)
        inputs.kind(scene, "add_mesh_trimesh", "scene", "a scene of viser's")
        self.arm, self.root = arm, scene.add_frame(name, show_axes=False)
        shapes = link_shapes.read(arm.model)
        self.missing = shapes.missing
        self._bodies = [
            (body.link, scene.add_mesh_trimesh(f"{name}/{k}", body.mesh)) for k, body in enumerate(shapes.bodies)
        ]

    def show(self, q: ArrayLike) -> None:
        """Move the links to where they are at ``q`` (n,) rad or m.

        Raises:
            ArgumentError: q is not (n,).
        """
        poses = self.arm.link_poses(_one(self.arm, q))
        for link, handle in self._bodies:
            handle.position, handle.wxyz = poses[link][:3, 3], to_quat_wxyz(poses[link])


def add_to_viser(scene: Any, arm: Arm, name: str = "/arm") -> ViserArm:
    """Add the arm's shapes to a scene of your own, such as ``viser.ViserServer().scene``.

    Args:
        scene: viser's scene.
        arm: the arm.
        name: of the frame that holds its links.

    Returns:
        What moves it: ``add_to_viser(...).show(q)``.
    """
    shown = ViserArm(scene, arm, name)
    shown.show(np.clip(np.zeros(arm.dof), *arm.limits.T))
    return shown


class RerunArm:
    """An arm in a rerun recording; see :func:`add_to_rerun`.

    Attributes:
        arm: the arm.
        missing: a sentence for each shape that could not be read.
    """

    def __init__(self, rerun: Any, arm: Arm, path: str, recording: Any) -> None:
        inputs.arm(arm)
        if not isinstance(path, str) or not path or "\0" in path:
            raise ArgumentError(f"path={quoted(path)} given; the path of an entity, such as 'arm', is needed")
        if recording is not None:
            inputs.kind(recording, "set_time", "recording", "a rerun.RecordingStream")
        self.arm, self._rerun, self._path, self._recording = arm, rerun, path, recording
        shapes = link_shapes.read(arm.model)
        self.missing = shapes.missing
        for k, body in enumerate(shapes.bodies):
            mesh = rerun.Mesh3D(vertex_positions=body.mesh.vertices, triangle_indices=body.mesh.faces)
            rerun.log([path, body.link, f"shape_{k}"], mesh, static=True, recording=recording)

    def show(self, q: ArrayLike) -> None:
        """Log the poses of the links at ``q`` (n,) rad or m, at the recording's present time.

        Raises:
            ArgumentError: q is not (n,).

        Example:
            >>> import rerun, urdf_ik
            >>> from urdf_ik import interop
            >>> recording = rerun.RecordingStream("arms")
            >>> shown = interop.add_to_rerun(urdf_ik.load("puma_560"), recording=recording)
            >>> for step in range(2):
            ...     recording.set_time("step", sequence=step)
            ...     shown.show([0.1 * step] * 6)
        """
        poses = self.arm.link_poses(_one(self.arm, q))
        for link, pose in poses.items():
            placed = self._rerun.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3])
            self._rerun.log([self._path, link], placed, recording=self._recording)


def add_to_rerun(arm: Arm, path: str = "arm", recording: Any = None) -> RerunArm:
    """Log the arm's shapes to rerun, one entity a link.

    Args:
        arm: the arm.
        path: of the entity that holds its links.
        recording: rerun's recording; default: the present one.

    Returns:
        What logs its poses: ``add_to_rerun(...).show(q)``.

    Raises:
        MissingPackage: rerun is not installed.

    Example:
        >>> import rerun, urdf_ik
        >>> from urdf_ik import interop
        >>> interop.add_to_rerun(urdf_ik.load("puma_560"), recording=rerun.RecordingStream("arms")).missing
        ()
    """
    try:
        import rerun
    except ImportError:
        raise extras.missing("rerun is not installed", "interop") from None
    return RerunArm(rerun, arm, path, recording)


def _one(arm: Arm, q: ArrayLike) -> Array:
    """One joint vector (n,)."""
    Q = arm.chain.check(q)
    if Q.ndim != 1:
        raise ArgumentError(f"joint vectors of shape {Q.shape} given; one, ({arm.dof},), is needed")
    return Q


def _places(names: Sequence[str]) -> dict[str, int]:
    """Index of each name.

    Raises:
        ArgumentError: these are no names, or one of them stands there twice.
    """
    if not isinstance(names, list | tuple) or not all(isinstance(name, str) for name in names):
        raise ArgumentError(f"names={quoted(names)} given; a list of joints' names is needed")
    place = {name: k for k, name in enumerate(names)}
    if len(place) < len(names):
        twice = sorted({name for name in names if list(names).count(name) > 1})
        raise ArgumentError(f"the message names {', '.join(twice)} twice")
    return place
