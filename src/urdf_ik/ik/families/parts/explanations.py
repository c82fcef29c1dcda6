"""Explanations of unreachable poses: lengths in words, and the error of the nearest pose."""

from collections.abc import Callable

import numpy as np

from urdf_ik.ik.families.parts.written import WHOLE_POSE, Aim, Numbers
from urdf_ik.kinematics.chain import Chain
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


_STARTS, _ROUNDS = 32, 40
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
    e = _least(chain, aim, target)
    worst = np.abs(e).max()
    parts = [
        f"{amount(abs(part[k]) * scale, unit, '.3g')} {name} {_AXES[k]}"
        for part, scale, unit, name in ((e[:3], chain.size, "m", "along"), (e[3:], 1.0, "rad", "about"))
        if abs(part[k := int(np.argmax(np.abs(part)))]) > min(_SILENT, 0.5 * worst)
    ]
    joints = f"{chain.n} joint{'s' if chain.n > 1 else ''}"
    # By the links' names: of a chain from tip to base these are the other way round.
    off = f"{' and '.join(parts)} of {quoted(chain.base)}"
    return f"{joints} cannot bring {quoted(chain.tip)} there: the nearest that was found is off by {off}"


def _least(chain: Chain, aim: Aim, target: Array) -> Array:
    """The error (6,) of least squares, lengths as shares of the size, that is smallest of those from many starts."""
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (_STARTS, chain.n))
    unit = np.where(chain.prismatic, chain.size, 1.0)
    q = np.where(chain.prismatic, q * chain.size / np.pi, q)
    best, least = np.zeros(6), np.inf
    for _ in range(_ROUNDS):
        T = chain.fk(q)
        e, J = _error(chain, aim, target, T), _jacobian(chain, aim, chain.jacobian(q), T)
        squares = (e**2).sum(axis=1)
        if squares.min() < least:
            least, best = float(squares.min()), e[squares.argmin()]
        # Least squares, damped, by the singular values.
        damping = 0.03 * np.minimum(1.0, np.sqrt(squares)) + 1e-9
        U, s, V = np.linalg.svd(J, full_matrices=False)
        along = np.einsum("kij,ki->kj", U, e) * s / (s**2 + damping[:, None] ** 2)
        step = np.einsum("kji,kj->ki", V, along)
        q = q + np.minimum(1.0, 0.5 / (np.abs(step).max(axis=1, keepdims=True) + 1e-12)) * step * unit
    return best


def _error(chain: Chain, aim: Aim, target: Array, T: Array) -> Array:
    """Error (m, 6) of poses T (m, 4, 4) in the controlled components; lengths divided by the arm's size."""
    e = np.zeros((len(T), 6))
    e[:, :3] = (target[:3, 3] - T[:, :3, 3]) / chain.size
    if aim.kind == 0:
        E = target[:3, :3] @ T[:, :3, :3].transpose(0, 2, 1)
        skew = 0.5 * np.stack([E[:, 2, 1] - E[:, 1, 2], E[:, 0, 2] - E[:, 2, 0], E[:, 1, 0] - E[:, 0, 1]], axis=1)
        # The skew part of a rotation falls again beyond a quarter turn: its angle leads on.
        sine = np.linalg.norm(skew, axis=1)
        angle = np.arctan2(sine, 0.5 * (np.trace(E, axis1=1, axis2=2) - 1.0))
        e[:, 3:] = skew * (angle / np.maximum(sine, 1e-12))[:, None]
    elif aim.axis is not None:
        now, wanted = T[:, :3, :3] @ aim.axis, target[:3, :3] @ aim.axis
        e[:, 3:] = np.cross(_in_plane(now, aim), _in_plane(wanted, aim))
    e[:, :3] = _in_plane(e[:, :3], aim)
    return e


def _jacobian(chain: Chain, aim: Aim, J: Array, T: Array) -> Array:
    """What of geometric Jacobians ``J`` (m, 6, n) at the poses ``T`` counts; slides by shares of the size."""
    linear, turning = J[:, :3] / np.where(chain.prismatic, 1.0, chain.size), J[:, 3:]
    if aim.kind != 0 and aim.axis is None:
        turning = np.zeros_like(turning)
    elif aim.normal is not None:
        turning = aim.normal[:, None] * (aim.normal @ turning)[:, None, :]
    elif aim.axis is not None:
        along = T[:, :3, :3] @ aim.axis
        turning = turning - along[:, :, None] * np.einsum("ki,kij->kj", along, turning)[:, None, :]
    linear = _in_plane(linear.transpose(0, 2, 1), aim).transpose(0, 2, 1)
    return np.concatenate([linear, turning], axis=1)


def _in_plane(v: Array, aim: Aim) -> Array:
    """Vectors (..., 3) without what is across the plane, where there is one."""
    return v if aim.normal is None else v - (v @ aim.normal)[..., None] * aim.normal
