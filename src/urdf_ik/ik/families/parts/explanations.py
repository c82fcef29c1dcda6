"""Explanations of unreachable poses: lengths in words, and the error of the nearest pose."""

from collections.abc import Callable

import numpy as np

from urdf_ik.ik.descent import Wanted
from urdf_ik.ik.families.parts.written import POSE, WHOLE_POSE, Aim, Numbers
from urdf_ik.ik.minima import searched
from urdf_ik.kinematics.chain import Chain
from urdf_ik.model.poses import to_rotvec
from urdf_ik.support.angles import amount
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array


def outside(text: str, length: float, low: float, high: float = np.inf) -> str:
    """Why a length is outside a range [m]: the text with {at}, {low} and {high}, and how far; '' where it is inside.

    The numbers have six digits, or as many as show that they differ.
    """
    if low <= length <= high:
        return ""
    numbers = (length, low, high)
    texts = (tuple(f"{number:.{digits}g}" for number in numbers) for digits in range(6, 18))
    at, least, most = next(each for each in texts if len(set(each)) == len(set(numbers)))
    off = f"{length - high:.3g} m too far" if length > high else f"{low - length:.3g} m too near"
    return f"{text.format(at=at, low=least, high=most)}: {off}"


def beyond_reach(what: str, lengths: Array, shortest: float, longest: float) -> str:
    """Why no length (k,) is from ``shortest`` to ``longest`` [m], in words; '' where they are not all on one side.

    ``what`` has a place for the length, as in 'axis 3 is {at} m from axis 1'.
    """
    return outside(f"{what}, reach {{high}} m", lengths.min(), -np.inf, longest) or outside(
        f"{what}, closer than the folded arm's {{low}} m", lengths.max(), shortest
    )


def links_beyond_reach(first: str, last: str, lengths: Array, shortest: float, longest: float) -> str:
    """Why two links cannot join two axes at any of the distances (k,) [m] that a pose requires; '' where they can."""
    if not len(lengths):
        return ""
    far = f"{first} would have to be {{at}} m or more from {last}, reach {{high}} m"
    near = f"{first} would be {{at}} m or less from {last}, the folded links' {{low}} m away"
    return outside(far, lengths.min(), -np.inf, longest) or outside(near, lengths.max(), shortest)


def beyond_links(what: str, far: float, size: float) -> str:
    """The text for what is further from axis 1 than the links reach, stretched out; '' where it is not."""
    return outside(f"{what} is {{at}} m from axis 1, and all links together measure {{high}} m", far, -np.inf, size)


_AXES = "xyz"
# A part of an error below this [rad, share of size] is not mentioned beside a larger one.
_SILENT = 1e-6


def seen_in_frame_1(chain: Chain, ends: Numbers, explain: Callable[[Array, Array], str]) -> Callable[[Array], str]:
    """``FamilyMember.why`` for a function of the rotation (3, 3) and solved point (3,) in the ideal frame 1.

    Where that names no length, the text is the error of the nearest pose.
    """

    def explain_pose(T: Array) -> str:
        R, base = T[:3, :3], ends.base_rotation
        point = base @ (R @ ends.tool_point + T[:3, 3] - ends.base_origin)
        return explain(base @ R @ ends.tool_rotation, point) or off_by(chain, T)

    return explain_pose


def off_by(chain: Chain, target: Array, aim: Aim = WHOLE_POSE) -> str:
    """The error, in words, of the nearest pose to a target (4, 4) that a search finds; ``aim``: what is controlled."""
    far = float(np.linalg.norm(target[:3, 3] - chain.points[0]))
    if not chain.prismatic.any() and (why := beyond_links("the tip", far, chain.size)):
        return why
    R, turning = target[:3, :3], aim.kind == POSE or aim.axis is not None
    matrix, constant = (R, 3.0) if aim.axis is None else (2.0 * np.outer(R @ aim.axis, aim.axis), 2.0)
    free = np.tile([-np.inf, np.inf], (chain.n, 1))
    wanted = Wanted(chain, target[None, :3, 3], matrix[None], constant)
    reached = chain.fk(searched(wanted, free, None, 1.0, float(turning))[0, 0])
    off, turn = (target[:3, 3] - reached[:3, 3]) / chain.size, np.zeros(3)
    if aim.axis is not None:
        turn = np.cross(reached[:3, :3] @ aim.axis, R @ aim.axis)
    elif turning:
        lacking = np.eye(4)
        lacking[:3, :3] = R @ reached[:3, :3].T
        turn = to_rotvec(lacking)
    worst = np.abs([off, turn]).max()
    parts = [
        f"{amount(abs(part[k]) * scale, unit, '.3g')} {name} {_AXES[k]}"
        for part, scale, unit, name in ((off, chain.size, "m", "along"), (turn, 1.0, "rad", "about"))
        if abs(part[k := int(np.argmax(np.abs(part)))]) > min(_SILENT, 0.5 * worst)
    ]
    joints = f"{chain.n} joint{'s' if chain.n > 1 else ''}"
    # By the links' names: of a chain from tip to base these are the other way round.
    words = f"{' and '.join(parts)} of {quoted(chain.base)}"
    return f"{joints} cannot bring {quoted(chain.tip)} there: the nearest that was found is off by {words}"
