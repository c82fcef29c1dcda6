"""Universal Robots' calibration files: the kinematics YAML that the driver extracts from a robot's controller.

It holds the origin of each of the six joints, x, y, z [m] and roll, pitch, yaw [rad], which the manufacturer's
description package writes into the URDF as they stand.
"""

import math
import os
from collections.abc import Mapping
from typing import IO, Any

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError, UrdfError
from urdf_ik.model.poses import pose, to_rotvec
from urdf_ik.model.urdf import Joint
from urdf_ik.model.urdf.edits import text_of, with_numbers
from urdf_ik.support import files

JOINTS = {
    "shoulder": "shoulder_pan_joint",
    "upper_arm": "shoulder_lift_joint",
    "forearm": "elbow_joint",
    "wrist_1": "wrist_1_joint",
    "wrist_2": "wrist_2_joint",
    "wrist_3": "wrist_3_joint",
}
"""The file's names of the links, and the joint whose origin each holds; a URDF may put a prefix before it."""
NUMBERS = ("x", "y", "z", "roll", "pitch", "yaw")
_MAX_BYTES = 2**16
_LARGEST_CHANGE = 0.05  # m: no calibration moves a joint so far; other frames do
_TURNED = 0.1  # rad: the same of an axis


def read_ur_kinematics(source: str | os.PathLike[str] | IO[bytes]) -> dict[str, tuple[float, ...]]:
    """A kinematics YAML's origins: link ('shoulder', 'upper_arm', ...) -> (x, y, z [m], roll, pitch, yaw [rad]).

    Raises:
        ArgumentError: the file cannot be read, or lacks a link or a number; the message names it.
    """
    import yaml

    name = files.name_of(source)
    data = files.read(source)
    wanted = f"a kinematics YAML holds kinematics: {{{', '.join(JOINTS)}}}, each with {', '.join(NUMBERS)}"
    try:
        # Numbers are read as text: YAML 1.1 takes 1e-05 for a text, too.
        held = yaml.load(data, Loader=yaml.BaseLoader)
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        where = getattr(error, "problem_mark", None)
        line = "" if where is None else f", line {where.line + 1}"
        raise ArgumentError(f"{name}{line}: no YAML: {getattr(error, 'problem', None) or error}; {wanted}") from None
    kinematics = held.get("kinematics") if isinstance(held, dict) else None
    if not isinstance(kinematics, dict):
        raise ArgumentError(f"{name}: no 'kinematics' in it; {wanted}")
    return {link: _origin(name, link, kinematics.get(link), wanted) for link in JOINTS}


def _origin(name: str, link: str, numbers: Any, wanted: str) -> tuple[float, ...]:
    if not isinstance(numbers, dict):
        raise ArgumentError(f"{name}: no {link} in it; {wanted}")
    out = []
    for each in NUMBERS:
        try:
            value = float(numbers[each])
        except (KeyError, TypeError, ValueError):
            value = math.nan
        if not math.isfinite(value):
            raise ArgumentError(f"{name}: {link}: {each} is {numbers.get(each)!r}; a finite number is needed")
        out.append(value)
    if max(map(abs, out[:3])) > 10.0:
        raise ArgumentError(f"{name}: {link}: {out[:3]} is no place in m; is it in mm?")
    return tuple(out)


def with_ur_kinematics(arm: Arm, kinematics: Mapping[str, tuple[float, ...]]) -> bytes:
    """The URDF of a Universal Robots arm with the origins of a calibration, all else as it was written.

    Raises:
        UrdfError: the URDF lacks one of the joints, or its frames are others than those of the manufacturer's
            description package, as in packages older than 2019.
    """
    joints = _joints(arm)
    changes = {}
    for link, joint in joints.items():
        numbers = kinematics[link]
        moved = float(np.linalg.norm(np.array(numbers[:3]) - joint.origin[:3, 3]))
        turned = float(
            np.linalg.norm(to_rotvec(np.linalg.inv(joint.origin) @ pose(joint.origin[:3, 3], rpy=numbers[3:])))
        )
        if moved > _LARGEST_CHANGE or turned > _TURNED:
            raise UrdfError(
                f"the calibration puts it {moved * 1e3:.0f} mm and {np.rad2deg(turned):.0f} degrees from where it is",
                source=arm.model.source,
                element=f'<joint name="{joint.name}">',
                hint="take the URDF of the same model (UR5 or UR5e) from the present ur_description, whose frames are "
                "those of the YAML",
            )
        changes[joint.name] = {"origin": {"xyz": numbers[:3], "rpy": numbers[3:]}}
    return with_numbers(text_of(arm.model), changes)


def _joints(arm: Arm) -> dict[str, Joint]:
    """The six joints by the file's names."""
    found = {}
    for link, suffix in JOINTS.items():
        ending = [joint for joint in arm.model.joints if joint.name.endswith(suffix)]
        own = [joint for joint in ending if joint.name in arm.joint_names] or ending
        if len(own) != 1:
            raise UrdfError(
                f"no joint {suffix!r}, with a prefix or without" if not own else f"{len(own)} joints {suffix!r}",
                source=arm.model.source,
                hint="a kinematics YAML belongs to one arm of Universal Robots; choose it by base and tip",
            )
        if not np.array_equal(own[0].axis, [0.0, 0.0, 1.0]):
            raise UrdfError(
                f"its axis is {own[0].axis.tolist()}, and the frames of a kinematics YAML turn about z",
                source=arm.model.source,
                element=f'<joint name="{own[0].name}">',
                line=own[0].line,
                hint="take the URDF from the present ur_description",
            )
        found[link] = own[0]
    return found
