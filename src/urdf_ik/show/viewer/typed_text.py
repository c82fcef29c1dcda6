"""Poses and joint vectors as text: what is pasted into the page, and what is copied from it."""

import json
import re
from typing import Any

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError
from urdf_ik.model.poses import check_poses, pose
from urdf_ik.typing import Array

_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_BESIDE = re.compile(r"[\s,;()\[\]]|np\.|array|tensor")
_DIGITS = 9


def read(text: str, arm: Arm) -> tuple[str, Array]:
    """What a text says: ('q', (n,) rad or m) or ('pose', (4, 4) m).

    Numbers in brackets or without: as many as the arm has joints are a joint vector, 16 a matrix, 7 a position and a
    quaternion (x, y, z, w), 6 a position and roll, pitch, yaw [rad]. Where that leaves a doubt, and in JSON, a word
    says what they are: ``q=...``, ``pose=...``, ``{"q": [...]}``, ``{"pose": [...]}``.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> read("q = [0, 0.5, 0, 0, 0, 0]", arm)[0], read("1.2 0.4 0.9 0 0 0 1", arm)[1][:3, 3].tolist()
        ('q', [1.2, 0.4, 0.9])
    """
    kind, values = _parsed(text)
    n = arm.dof
    if kind == "q" or (not kind and len(values) == n):
        if len(values) != n:
            raise ArgumentError(f"{len(values)} numbers given; {arm.name} has {n} joints: {', '.join(arm.joint_names)}")
        return "q", arm.chain.check(values)
    if len(values) == 16:
        return "pose", check_poses(values.reshape(4, 4))
    if len(values) == 7:
        return "pose", pose(values[:3], quat_xyzw=values[3:])
    if len(values) == 6:
        return "pose", pose(values[:3], rpy=values[3:])
    raise ArgumentError(
        f"{len(values)} numbers given; {n} are a joint vector, 16 a matrix, 7 x,y,z and a quaternion x,y,z,w, 6 x,y,z "
        "and roll,pitch,yaw"
    )


def written(q: Array, target: Array) -> str:
    """A joint vector and the target's pose as lines of Python, each of which :func:`read` takes."""
    joints, matrix = ((np.round(each, _DIGITS) + 0.0).tolist() for each in (q, target))
    return f"q = {joints}\npose = {matrix}"


def _parsed(text: str) -> tuple[str, Array]:
    """The word that says what the numbers are, 'q', 'pose' or '', and the numbers."""
    try:
        data: Any = json.loads(text)
    except ValueError:
        data = None
    if isinstance(data, dict):
        named = [name for name in ("q", "pose") if name in data]
        if len(named) != 1:
            raise ArgumentError("an object with 'q' or with 'pose' is needed, and not with both")
        return named[0], _numbers(json.dumps(data[named[0]]))
    word, sign, rest = text.partition("=")
    if sign and word.strip() in ("q", "pose", "T"):
        return "q" if word.strip() == "q" else "pose", _numbers(rest)
    return "", _numbers(text)


def _numbers(text: str) -> Array:
    left = _BESIDE.sub("", _NUMBER.sub(" ", text)).strip()
    if left:
        raise ArgumentError(f"{left!r} is no number; paste numbers, such as 0.5, 0.1, 0.3, 0, 0, 0, 1")
    return np.array([float(each) for each in _NUMBER.findall(text)])
