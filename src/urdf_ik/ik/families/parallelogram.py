"""Parallelograms: parallel axes that follow one joint, as +q, -q, +q, are one turn about a shifted axis.

With the angles' partial sums 0 or q, points p_i of the axes and p_0 = 0, the links turn by q about the sum of those
p_i - p_(i-1) before which the partial sum is 0.
"""

from __future__ import annotations

from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.chain.mimic import CoupledChain
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array


def uncoupled(chain: Chain) -> Chain | None:
    """The chain with one axis for each joint; None where axes that follow a joint are no parallelogram."""
    if not isinstance(chain, CoupledChain):
        return None
    H, points = np.empty((chain.n, 3)), np.empty((chain.n, 3))
    driven = chain.gain != 0.0
    drivers = driven.argmax(axis=1)
    if (driven.sum(axis=1) != 1).any() or (np.diff(drivers) < 0).any():
        return None
    for k in range(chain.n):
        axes = np.flatnonzero(driven[:, k])
        made = _one_axis(chain.axes, axes, chain.gain[axes, k])
        if made is None:
            return None
        H[k], points[k] = made
    tip = chain.axes.P.sum(axis=0)
    plain = {each.name: getattr(chain, each.name) for each in fields(Chain)}
    return Chain(**plain | {"H": H, "P": np.diff(np.vstack([np.zeros(3), points, tip]), axis=0), "followers": ()})


def _one_axis(axes: Chain, which: NDArray[np.intp], gains: Array) -> tuple[Array, Array] | None:
    """Direction and a point of the axis about which a joint turns all behind the axes ``which``."""
    h, points = axes.H[which[0]] * np.sign(gains[0]), axes.points[which]
    if abs(abs(gains[0]) - 1.0) > DEFAULT.exact_structure:
        return None
    if len(which) == 1:
        return h, points[0]
    along = axes.H[which] @ h
    sums = np.cumsum(gains * np.sign(along))
    whole = np.abs(sums - np.round(sums)).max() < DEFAULT.exact_structure and np.isin(np.round(sums), (0, 1)).all()
    parallel = np.abs(np.abs(along) - 1.0).max() < DEFAULT.exact_structure
    if axes.prismatic[which].any() or not (whole and parallel and round(sums[-1]) == 1):
        return None
    steps = np.diff(np.vstack([np.zeros(3), points]), axis=0)
    still = np.concatenate([[True], np.round(sums[:-1]) == 0])
    return h, np.asarray(steps[still].sum(axis=0))
