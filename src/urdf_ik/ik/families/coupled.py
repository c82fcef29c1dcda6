"""Arms in which joints mimic others, with up to four independent ones: the joint space searched by proven bounds.

Six independent joints are solved where the wrist mimics: see ``hollow_wrist``.
"""

import math
from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.families import hollow_wrist
from urdf_ik.ik.families.parts.explanations import beyond_links
from urdf_ik.ik.families.parts.family import Family, FamilyMember, columns
from urdf_ik.ik.families.parts.written import Numbers, driven
from urdf_ik.kinematics.chain import Chain, is_redundant
from urdf_ik.kinematics.chain.mimic import MOST_TURNS, CoupledChain
from urdf_ik.kinematics.structure import Structure
from urdf_ik.support.text import quoted
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

MOST_JOINTS, MOST_AXES = 4, 12
# Axes this close to parallel [rad] count as parallel where turns are added up: far below the bounds' own slack.
_PARALLEL = 1e-10
# Columns of a pose; a range [rad, shares of the size] that is too wide to be searched.
_COLUMNS, _MOST_COLUMNS, _TOO_WIDE = 16, 96, 1e3


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember:
    """The plan of an arm for which ``why_not`` has no reason."""
    assert isinstance(chain, CoupledChain)
    kinds = "".join("P" if slides else "R" for slides in chain.axes.prismatic)
    kinds = kinds if "P" in kinds else f"{len(kinds)}R"
    turns = int(np.prod(np.maximum(chain.image_turns, 1.0)))
    names = columns(min(_MOST_COLUMNS, _COLUMNS * turns))
    return family.member(
        chain,
        _arm(chain, len(names)),
        name=f"{kinds} driven by {chain.n} joint{'s' * (chain.n > 1)}",
        reason=f"{family.reason}: {', '.join(map(str, chain.followers))}",
        method="Bisection of the joint space with proven bounds: every part is shown to hold no solution, or one, "
        "which Newton's method finds on the URDF as written" + _searched_within_limits(chain),
        branches=names,
        why=lambda T: _out_of_reach(chain, T[:3, 3]),
    )


FAMILY = Family(
    name="joints that mimic others",
    reason="joints mimic others, and at most four are independent",
    steps="bisection of the joint space with proven bounds",
    branches=columns(_MOST_COLUMNS),
    matches=lambda structure, chain: isinstance(chain, CoupledChain) and chain.n <= MOST_JOINTS and not why_not(chain),
    prepare=_prepare,
)


def why_not(chain: CoupledChain) -> str:
    """Why the chain cannot be solved; '' where it can."""
    if chain.n > MOST_JOINTS:
        general = f"with joints that mimic others at most {MOST_JOINTS} independent ones are solved in general, "
        general += f"and these are {chain.n}"
        if chain.n != 6:
            return general
        wrist = hollow_wrist.why_not(chain)
        return wrist and f"{general}; nor is it a 6R arm whose wrist mimics: {wrist}"
    if chain.axes.n > MOST_AXES:
        return f"at most {MOST_AXES} axes are solved, and the joints drive {chain.axes.n}"
    for j, name in enumerate(chain.joint_names):
        lower, upper = chain.limits[j]
        if not chain.image_turns[j] and not upper - lower <= _TOO_WIDE * _unit(chain, j):
            factors = ", ".join(f"{factor:g}" for factor in chain.gain[:, j] if factor)
            return (
                f"joint {quoted(name)}, with the multipliers {factors}, does not repeat within {MOST_TURNS} turns and "
                f"has the limits {lower:g} to {upper:g}, between which no search ends: give it limits"
            )
    if is_redundant(chain):
        return "the joints are redundant: the Jacobian loses rank everywhere"
    return ""


def _searched_within_limits(chain: CoupledChain) -> str:
    names = [repr(name) for name, turns in zip(chain.joint_names, chain.image_turns, strict=True) if not turns]
    return f"; {', '.join(names)} within the limits" if names else ""


def _unit(chain: CoupledChain, joint: int) -> float:
    """A joint's unit: 1 rad, or the arm's size where it slides [m]."""
    return chain.size if chain.joint_types[joint] == "prismatic" else 1.0


def _arm(chain: CoupledChain, many: int) -> Numbers:
    """The arm for the compiled search, with so many columns."""
    units = np.array([_unit(chain, j) for j in range(chain.n)])
    turns = chain.image_turns
    lower, upper = chain.limits.T / units
    with np.errstate(invalid="ignore"):
        middle = np.where(turns > 0.0, 0.0, 0.5 * (lower + upper))
    return Numbers(
        kind="coupled",
        joints=chain.n,
        written=driven(chain, units),
        middle=middle,
        # A value at the very end of its range lies inside the box.
        half=np.where(turns > 0.0, math.pi * turns, 0.5 * (upper - lower) + 1e-6),
        rates=_rates(chain.axes, chain.gain * units),
        columns=many,
    )


def _rates(axes: Chain, gain: Array) -> Array:
    """(m, n) greatest rates [rad] at which the joints turn the links behind each axis."""
    done, run = np.zeros(gain.shape[1]), np.zeros(gain.shape[1])
    along = np.zeros(3)
    rates = np.empty_like(gain)
    for k, (h, slides) in enumerate(zip(axes.H, axes.prismatic, strict=True)):
        if not slides:
            if np.linalg.norm(np.cross(h, along)) > _PARALLEL or not along.any():
                done, run, along = done + np.abs(run), np.zeros(gain.shape[1]), h
            run = run + math.copysign(1.0, float(h @ along)) * gain[k]
        rates[k] = done + np.abs(run)
    return rates


def _out_of_reach(chain: CoupledChain, point: Array) -> str:
    """Why a target at ``point`` (3,) [m] has no solution."""
    far = float(np.linalg.norm(point - chain.points[0]))
    if not chain.axes.prismatic.any() and (why := beyond_links("the tip", far, chain.size)):
        return why
    joints = f"{chain.n} independent joint{'s' if chain.n > 1 else ''}"
    return f"{joints} ({', '.join(chain.joint_names)}) cannot bring the tip there{_searched_within_limits(chain)}"


def uncoupled(chain: Chain) -> Chain | None:
    """The chain with one axis for each joint; None where axes that follow a joint are no parallelogram.

    Parallel axes that follow one joint, as +q, -q, +q, are one turn about a shifted axis: with the angles' partial sums
    0 or q, points p_i of the axes and p_0 = 0, the links turn by q about the sum of those p_i - p_(i-1) before which
    the partial sum is 0.
    """
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
