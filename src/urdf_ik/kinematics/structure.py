"""``Structure``: parallel, intersecting and coincident joint axes, with the measured imperfection of each relation."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from urdf_ik.kinematics.chain import Chain
from urdf_ik.support.angles import amount
from urdf_ik.support.tolerances import DEFAULT

Vector = NDArray[np.float64]


_KINDS = {"revolute": "R", "continuous": "R", "prismatic": "P"}
# Below this [rad or m] a deviation is not worth a word.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class AxisPair:
    """Two neighbouring joint axes, numbered from 1.

    Attributes:
        first: number of the first axis.
        relation: 'parallel', 'coincident', 'intersecting' or 'skew', within the tolerances.
        angle: angle between the directions, 0 to pi [rad].
        distance: distance between the lines [m].
        off_angle: deviation from parallel [rad] where the relation says parallel or coincident, else 0.
        off_distance: deviation from meeting [m] where it says intersecting or coincident, else 0.
    """

    first: int
    relation: str
    angle: float
    distance: float
    off_angle: float
    off_distance: float

    def __str__(self) -> str:
        apart = f", {self.distance:.6g} m apart" if self.relation in ("parallel", "skew") else ""
        at = "" if self.relation in ("parallel", "coincident") else f" at {np.degrees(self.angle):.6g} deg"
        off = [amount(self.off_angle, form=".2g")] * (self.off_angle > _ROUNDING)
        off += [f"{self.off_distance:.2g} m"] * (self.off_distance > _ROUNDING)
        but = f" but for {' and '.join(off)}" if off else ""
        return f"axes {self.first} and {self.first + 1} are {self.relation}{at}{apart}{but}"


@dataclass(frozen=True)
class AxisTriple:
    """Three neighbouring axes that meet in a point, or are parallel.

    Attributes:
        first: number of the first axis.
        relation: 'meet' or 'parallel'.
        imperfection: greatest distance of an axis from the common point [m], or angle from the common
            direction [rad].
        point: (3,) m the common point in the base at q = 0, where they meet.
    """

    first: int
    relation: str
    imperfection: float
    point: Vector | None = field(default=None, compare=False)

    def __str__(self) -> str:
        numbers = f"axes {self.first}, {self.first + 1} and {self.first + 2}"
        return f"{numbers} {'meet in a point' if self.relation == 'meet' else 'are parallel'}"


@dataclass(frozen=True, repr=False)
class Structure:
    """What is known of an arm before it is solved; ``str()`` gives it in sentences.

    Attributes:
        joint_types: 'revolute', 'continuous' or 'prismatic', base to tip.
        pairs: relations of neighbouring axes.
        triples: triples of neighbouring axes that meet or are parallel.
        family: name of the family, such as '6R spherical wrist, 2||3'; '' where no solver takes the arm.
        reason: why it is solved as one of this family, in words.
        method: how it is solved, in words.
        branches: names of the columns of its solutions.
        imperfection: (rad, m) how far the URDF as written is from the family.
        error: the same as greatest difference between poses of the ideal arm and of the arm as written [rad, share
            of the arm's size]; what decides whether it counts as exact.
        is_general: whether the arm is solved by elimination alone, without a closed form.
        by_quadratics: whether each joint follows from the root of a quadratic, one step after the other, of the arm
            as written.

    Example:
        >>> import urdf_ik
        >>> structure = urdf_ik.load("scara_rrpr").structure
        >>> structure.family, structure.branches
        ('RRPR SCARA', ('elbow left', 'elbow right'))
    """

    joint_types: tuple[str, ...]
    pairs: tuple[AxisPair, ...]
    triples: tuple[AxisTriple, ...]
    family: str = ""
    reason: str = ""
    method: str = ""
    branches: tuple[str, ...] = ()
    imperfection: tuple[float, float] = (0.0, 0.0)
    error: float = 0.0
    is_general: bool = False
    by_quadratics: bool = False

    @property
    def slides(self) -> int:
        """Number of joints that slide."""
        return self.joint_types.count("prismatic")

    @property
    def is_6r(self) -> bool:
        """Whether there are six joints, and all of them turn."""
        return len(self.joint_types) == 6 and not self.slides

    @property
    def is_exact(self) -> bool:
        """Whether the URDF as written is a member of the family, to rounding."""
        return self.error <= DEFAULT.exact_structure

    @property
    def max_solutions(self) -> int:
        """Greatest number of solutions that a pose can have, away from singularities; 0 where unknown."""
        return len(self.branches)

    @property
    def cuspidal(self) -> bool | None:
        """False where an arm of six turning joints cannot change its branch without crossing a singularity; else None.

        Where each joint angle is a root of a quadratic, the Jacobian's determinant is the product of the steps'
        derivatives, but for factors that never vanish. The two roots of a step have derivatives of opposite sign, so on
        a path without a singularity each step keeps its root (Wenger, A new general formalism for the kinematic
        analysis of all nonredundant manipulators, 1992).
        """
        return False if self.is_6r and self.by_quadratics else None

    def is_parallel(self, first: int) -> bool:
        """Whether axes ``first`` and ``first + 1`` are parallel or coincident."""
        return self.pairs[first - 1].relation in ("parallel", "coincident")

    def is_intersecting(self, first: int) -> bool:
        """Whether axes ``first`` and ``first + 1`` meet under an angle."""
        return self.pairs[first - 1].relation == "intersecting"

    def triple(self, first: int, relation: str) -> AxisTriple | None:
        """The triple that begins with axis ``first``, if its relation is this one."""
        return next((t for t in self.triples if t.first == first and t.relation == relation), None)

    def solutions_in_words(self) -> str:
        """How many solutions there can be, and how the columns are counted."""
        further = sum(name.startswith("further ") for name in self.branches)
        most = "one solution at most" if self.max_solutions == 1 else f"up to {self.max_solutions} solutions"
        if not further:
            return most
        ideal = self.max_solutions - further
        return f"{most}: {ideal} next to those of the ideal arm, and {further} that only the arm as written can have"

    def imperfection_in_words(self) -> str:
        """How far the URDF as written is off its family, and what is done about it."""
        if self.is_general:
            return (
                "none, since no relation between the axes is made use of; solutions are verified on the URDF as written"
            )
        if self.is_exact:
            return "none: the URDF as written is of this family, exact to rounding"
        angle, distance = self.imperfection
        off = f"the URDF as written is {amount(angle, form='.2g')} and {distance:.2g} m off this family"
        if max(angle, distance) == 0.0:
            off = f"the URDF as written is off this family by {self.error:.1g} of its size"
        return f"{off}; the ideal arm gives starting points only, and solutions are verified on the URDF as written"

    def __str__(self) -> str:
        kinds = "".join(_KINDS[kind] for kind in self.joint_types)
        name = f"{len(self.joint_types)} joints ({kinds})"
        sentences = [f"{name}: {self.family}" if self.family else f"{name}, of no family that is solved here"]
        sentences.append("; ".join(map(str, (*self.triples, *self.pairs))))
        if self.family:
            # The relations above say why, unless no relation helps.
            sentences += [self.reason if self.is_general else "", self.method, self.solutions_in_words()]
            sentences.append(f"imperfection: {self.imperfection_in_words()}")
        return " ".join(f"{text[0].upper()}{text[1:]}." for text in sentences if text)

    def __repr__(self) -> str:
        return f"<Structure: {self.family or f'{len(self.joint_types)} joints, of no family that is solved here'}>"


def analyse(chain: Chain) -> Structure:
    """Relations between the axes of ``chain``, mimicking ones too; the family is left open.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> analyse(arm.chain).triple(4, "meet").first
        4
    """
    chain = chain.axes
    return Structure(
        joint_types=chain.joint_types,
        pairs=tuple(_pair(chain, i, chain.size) for i in range(chain.n - 1)),
        triples=tuple(t for i in range(chain.n - 2) if (t := _triple(chain, i, chain.size)) is not None),
    )


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product of two vectors (3,), ten times as fast as NumPy's, which an arm needs some hundred times."""
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def _length(v: Vector) -> float:
    return math.hypot(*v.tolist())


def closest_points(p: Vector, u: Vector, q: Vector, v: Vector) -> tuple[Vector, Vector]:
    """Feet of the common normal of the lines p + s u and q + t v, unit directions that are not parallel."""
    normal = cross(u, v)
    square = normal @ normal
    s = cross(q - p, v) @ normal / square
    t = cross(q - p, u) @ normal / square
    return p + s * u, q + t * v


def meeting_point(points: Vector, directions: Vector) -> Vector:
    """The point with the least sum of squared distances from lines (k, 3), (k, 3)."""
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    # Relative to one of the points, so that an arm far from its base loses no digits.
    offset = np.einsum("kij,kj->i", across, points - points[0])
    return np.asarray(points[0] + np.linalg.solve(across.sum(axis=0), offset))


def _pair(chain: Chain, i: int, size: float) -> AxisPair:
    u, v = chain.H[i], chain.H[i + 1]
    p, q = chain.points[i], chain.points[i + 1]
    across = _length(cross(u, v))
    angle = math.atan2(across, float(u @ v))
    off_angle = min(angle, np.pi - angle)
    rotary = chain.joint_types[i] != "prismatic" and chain.joint_types[i + 1] != "prismatic"
    if off_angle < DEFAULT.near_angle:
        distance = _length(cross(q - p, u))
        if distance < DEFAULT.near_distance * size and rotary:
            return AxisPair(i + 1, "coincident", angle, distance, off_angle, distance)
        return AxisPair(i + 1, "parallel", angle, distance, off_angle, 0.0)
    a, b = closest_points(p, u, q, v)
    distance = _length(b - a)
    if distance < DEFAULT.near_distance * size:
        return AxisPair(i + 1, "intersecting", angle, distance, 0.0, distance)
    return AxisPair(i + 1, "skew", angle, distance, 0.0, 0.0)


def _triple(chain: Chain, i: int, size: float) -> AxisTriple | None:
    if "prismatic" in chain.joint_types[i : i + 3]:
        return None
    directions, points = chain.H[i : i + 3], chain.points[i : i + 3]
    signs = np.where(directions @ directions[1] < 0.0, -1.0, 1.0)
    mean = (signs[:, None] * directions).sum(axis=0)
    mean /= _length(mean)
    off = max(_length(cross(direction, mean)) for direction in directions)
    if off < DEFAULT.near_angle:
        return AxisTriple(i + 1, "parallel", off)
    if min(_length(cross(directions[k], directions[k + 1])) for k in (0, 1)) < DEFAULT.near_angle:
        return None
    centre = meeting_point(points, directions)
    off = max(_length(cross(point - centre, direction)) for point, direction in zip(points, directions, strict=True))
    return AxisTriple(i + 1, "meet", off, centre) if off < DEFAULT.near_distance * size else None
