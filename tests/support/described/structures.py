"""Structures of axes that are given as they are, and of arms of a kind."""

import numpy as np
from arms import DescribedArm, from_screws, random_arm
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.kinematics.chain import from_urdf
from urdf_ik.kinematics.structure import Structure, analyse
from urdf_ik.model import urdf

Array = NDArray[np.float64]


def text_of(axes: Array, points: Array, *, mount: tuple[Array, Array] | None = None) -> str:
    """URDF text of axes through points (n, 3) [m] with a tool at 0.3 m, every frame aligned with the base at q = 0.

    ``mount``: rotation (3, 3) and place (3,) of the arm in its base link.
    """
    turn, place = mount if mount else (np.eye(3), np.zeros(3))
    axes, points = axes @ turn.T, points @ turn.T + place
    reach = np.linalg.norm(np.ptp(points, axis=0)) or 1.0
    tip = points[-1] + 0.3 * reach * turn @ np.array([0.6, 0.48, 0.64])
    return from_screws("made", "", axes, points, tip, np.zeros(3)).urdf


def relations(axes: Array, points: Array) -> Structure:
    """What the package finds out about these axes, the family aside."""
    return analyse(from_urdf(urdf.read(text_of(np.asarray(axes, float), np.asarray(points, float)))))


def structure_of(axes: Array, points: Array, **how: tuple[Array, Array]) -> Structure:
    """The structure of the loaded arm."""
    return urdf_ik.load(text_of(axes, points, **how), "base", "tool").structure


def of_kind(kind: str, seed: int = 0, *, orthogonal: bool = False) -> DescribedArm:
    """A member of a family, as axes and points without a base."""
    return random_arm(kind, seed, orthogonal=orthogonal, aligned=True)
