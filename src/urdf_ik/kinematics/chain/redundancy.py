"""The redundancy parameters of a chain, and the rank of its Jacobian."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError
from urdf_ik.kinematics.chain.serial import Chain
from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN, amount, shown, wrapped
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

SWIVEL, LOCKED_JOINT, FREE_AXIS = "swivel", "locked joint", "free axis"

FARTHEST = 1e6
"""rad: a larger angle lacks the digits that a pose of 1e-9 m and rad needs. A wider range counts as no limit."""


@dataclass(frozen=True)
class Redundancy:
    """One redundancy parameter of an arm: its kind, range and default.

    A 'locked joint' is the value of a joint. A 'free axis' is the angle by which the tip is turned about a line in it,
    see :meth:`urdf_ik.Arm.with_free_axis`. A 'swivel' is the angle about the line from the
    shoulder S, where axes 1, 2 and 3 meet, to the wrist W, where axes 5, 6 and 7 meet: from the normal of the plane
    that holds axis 1 and W (axis 1 times SW) to the direction of axis 4, less its part along SW. Where axis 4 is at
    right angles to upper arm and forearm, this is the angle between that plane and the arm's own; at zero the elbow
    lies in the plane of axis 1 and W, above SW as axis 1 points or below. Where W lies on axis 1, to 1e-7 rad, the
    plane is undefined, and the common normal of axes 1 and 2 at q = 0 replaces its normal: there the angle jumps.

    Attributes:
        kind: 'swivel', 'locked joint' or 'free axis'.
        joint: name of the locked joint, or of the elbow's joint; for a free axis, the axis in words.
        range: least and greatest value [unit]: the joint's limits; (-pi, pi) for a turning joint without
            limits, infinite for a sliding one.
        default: value [unit] that ``ik`` uses by default: zero for a swivel or a free axis, else the middle of the
            joint's limits, zero without limits.
        unit: 'rad' or 'm'.
    """

    kind: str
    joint: str
    range: tuple[float, float]
    default: float
    unit: str

    @property
    def round(self) -> bool:
        """Whether the range holds the whole circle, so that it has no ends."""
        return self.unit == "rad" and self.range[1] - self.range[0] >= 2.0 * math.pi

    @property
    def label(self) -> str:
        """In a word or two: 'swivel angle', the joint's name, 'rotation about the tip's z axis'."""
        return {SWIVEL: "swivel angle", LOCKED_JOINT: self.joint}.get(self.kind, f"rotation about {self.joint}")

    def __str__(self) -> str:
        low, high = self.range
        what = {
            SWIVEL: f"swivel angle of the arm's plane, the one across the axis of joint {self.joint!r}",
            LOCKED_JOINT: f"value of joint {self.joint!r}",
        }.get(self.kind, self.label)
        least, standard = (f"{shown(value, self.unit) + 0.0:.4f}" for value in (low, self.default))
        return f"{what}, {least} to {amount(high, self.unit, '.4f')}, by default {standard}"

    def check(self, value: ArrayLike) -> Array:
        """``value`` as an array (...) of finite numbers."""
        if type(value) is np.ndarray and value.dtype == np.float64 and value.flags.c_contiguous:
            values = value
        else:
            values = inputs.real(value, "redundancy", f"a number [{self.unit}], or an array of numbers: {self}")
        if (bad := inputs.first_bad(values)) is not None:
            problem = f"redundancy is {value!r}; {inputs.why_bad(values[bad])}"
            raise ArgumentError(f"{problem}, finite numbers [{self.unit}]: {self}")
        if self.unit == "rad" and (np.abs(values) > FARTHEST).any():
            raise ArgumentError(f"redundancy is {value!r}; angles up to {FARTHEST:g} rad are taken: {self}")
        return values

    def wrapped(self, values: Array) -> Array:
        """``values`` with angles in (-pi, pi], as joint vectors of solutions hold them."""
        return values if self.unit == "m" else wrapped(values)


def spread(parameters: Sequence[Redundancy], poses: Array, value: ArrayLike) -> tuple[Array, Array]:
    """Poses (..., 4, 4) and values broadcast against each other: (...) of one parameter, (..., k) of k of them."""
    count, batch = len(parameters), poses.shape[:-2]
    for parameter in parameters:
        values = parameter.check(value)
    last = () if count == 1 else values.shape[-1:]
    if count > 1 and last != (count,):
        raise ArgumentError(
            f"redundancy of shape {values.shape} given; this arm has {count} parameters "
            f"({', '.join(each.label for each in parameters)}), so its last dimension must be {count}"
        )
    own = values.shape[: values.ndim - len(last)]
    try:
        shape = np.broadcast_shapes(batch, own)
    except ValueError:
        raise ArgumentError(
            f"poses of shape {batch} and redundancy of shape {own} given; "
            "the shapes must broadcast, as in ik(T[:, None], redundancy=values)"
        ) from None
    return np.broadcast_to(poses, (*shape, 4, 4)).copy(), np.broadcast_to(values, (*shape, *last)).copy()


def locked_joint(chain: Chain, k: int) -> Redundancy:
    """The parameter of an arm whose joint ``k`` is given."""
    low, high = (float(limit) for limit in chain.limits[k])
    slides = bool(chain.prismatic[k])
    endless = not math.isfinite(high - low)
    if endless and not slides:
        low, high = -math.pi, math.pi
    # Some write 1e15 for no limit: the middle of that is far from every posture that anyone means.
    middle = 0.0 if endless else min(max(0.0, low), high) if high - low > FARTHEST else 0.5 * (low + high)
    if not slides and abs(middle) > FARTHEST:
        middle = math.remainder(middle, TURN)
    return Redundancy(LOCKED_JOINT, chain.joint_names[k], (low, high), middle, "m" if slides else "rad")


_SAMPLES = 60


def kinds_of(chain: Chain) -> str:
    """The joints in letters, base to tip: '4R' or 'RRPR'."""
    letters = "".join("P" if slides else "R" for slides in chain.prismatic)
    return letters if "P" in letters else f"{chain.n}R"


def is_redundant(chain: Chain) -> bool:
    """Whether the Jacobian loses rank everywhere: then a pose has a continuum of solutions, or no solution.

    Joint vectors are sampled; the chain is redundant if at least half of them are singular by the solvers' measure.
    Seven joints of a redundant chain do not control all six directions of the tip.
    """
    return typical_stretch(chain) < DEFAULT.singular


def typical_stretch(chain: Chain) -> float:
    """Median of the Jacobian's smallest singular value at sampled joint vectors, lengths as shares of the size."""
    return float(np.median(least_stretches(chain, chain.jacobian(sampled(chain)))))


def dependent_joints(chain: Chain) -> tuple[str, ...]:
    """The smallest set of joints that are linearly dependent at almost every joint vector; () where there is none."""
    J = chain.jacobian(sampled(chain))

    def depends(joints: list[int]) -> bool:
        return float(np.median(least_stretches(chain, J, joints))) < DEFAULT.singular

    kept = list(range(chain.n))
    if chain.n > 6 or not depends(kept):
        return ()
    for k in range(chain.n):
        fewer = [j for j in kept if j != k]
        if fewer and depends(fewer):
            kept = fewer
    return tuple(chain.joint_names[k] for k in kept)


def sampled(chain: Chain) -> Array:
    """Joint vectors (k, n) all over."""
    q = np.random.default_rng(0).uniform(-math.pi, math.pi, (_SAMPLES, chain.n))
    return np.where(chain.prismatic, q * chain.size / math.pi, q)


def least_stretches(chain: Chain, J: Array, joints: Sequence[int] | None = None) -> Array:
    """Smallest singular values (k,) of Jacobians (k, rows, n), lengths as shares of the arm's size.

    Args:
        chain: the arm.
        J: its Jacobians, or the rows of them that matter [m or rad, by rad or m].
        joints: those whose columns count; None: all.
    """
    scaled = J / chain.size
    scaled[:, 3:] = J[:, 3:]
    scaled[:, :, chain.prismatic] *= chain.size
    if joints is not None:
        scaled = scaled[:, :, list(joints)]
    return np.asarray(np.linalg.svd(scaled, compute_uv=False)[:, -1], dtype=np.float64)
