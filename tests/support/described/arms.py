"""URDF text of arms whose structure is known, for tests: random members of every family, and a few named ones.

An arm is made from its axes: directions and points at q = 0 that fulfil the family's conditions. Everything that a URDF
may vary without touching the structure is then varied: the base, the tool, the frames in which the axes are given, the
points along an axis where a joint's frame sits, fixed joints in between, limits.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = Sequence[float] | Array
X, Y, Z = np.eye(3)


@dataclass(frozen=True)
class DescribedArm:
    """An arm as URDF text.

    Attributes:
        name: what a test's id shows.
        kind: the family's conditions in words, such as ``"wrist, 2||3"``.
        urdf: URDF text with the links ``base`` and ``tool``.
        axes: directions (n, 3) at q = 0 in the arm's own frame, before the base transform; None where unused.
        points: a point (n, 3) [m] on each axis, in the same frame.
    """

    name: str
    kind: str
    urdf: str
    axes: Array | None = None
    points: Array | None = None


# ---------------------------------------------------------------- rotations and frames


def rotation(axis: Array, angle: float) -> Array:
    """Rotation matrix (3, 3) by an angle [rad] about an axis (3,) of any length."""
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)


def _rpy(matrix: Array) -> tuple[float, float, float]:
    """Roll, pitch and yaw [rad] of a rotation matrix (3, 3), away from a pitch of 90 degrees."""
    return (
        math.atan2(matrix[2, 1], matrix[2, 2]),
        math.atan2(-matrix[2, 0], math.hypot(matrix[2, 1], matrix[2, 2])),
        math.atan2(matrix[1, 0], matrix[0, 0]),
    )


def _from_rpy(rpy: Sequence[float]) -> Array:
    """Rotation matrix (3, 3) of roll, pitch and yaw [rad]."""
    roll, pitch, yaw = rpy
    return rotation(Z, yaw) @ rotation(Y, pitch) @ rotation(X, roll)


def _direction(rng: np.random.Generator) -> Array:
    """A random unit vector (3,)."""
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def _turn(rng: np.random.Generator) -> Array:
    """A random rotation matrix (3, 3)."""
    return rotation(_direction(rng), rng.uniform(0.3, math.pi))


# ---------------------------------------------------------------- writing URDF


def serial_urdf(
    name: str,
    origins: Sequence[tuple[Numbers, Numbers]],
    axes: Sequence[Numbers | None],
    *,
    limits: Sequence[tuple[float, float] | None] | None = None,
    links: Sequence[str] | None = None,
) -> str:
    """URDF text of a serial chain.

    Args:
        name: the robot's name.
        origins: (xyz [m], rpy [rad]) of every joint.
        axes: the axis of every joint in its own frame; None makes the joint fixed.
        limits: lower and upper [rad] of every joint, None for a continuous one; +-pi where left out.
        links: names of the links, one more than joints; ``base``, ``link_1`` ..., ``tool`` where left out.

    Returns:
        The text. Numbers are written so that they read back exactly.
    """
    links = links or ["base", *(f"link_{i}" for i in range(1, len(origins))), "tool"]
    lines = [f'<robot name="{name}">', *(f'  <link name="{link}"/>' for link in links)]
    movable = 0
    for i, ((xyz, rpy), axis) in enumerate(zip(origins, axes, strict=True)):
        limit = (-math.pi, math.pi) if limits is None else limits[i]
        kind = "fixed" if axis is None else "continuous" if limit is None else "revolute"
        movable += axis is not None
        joint = f"fixed_{i}" if axis is None else f"joint_{movable}"
        lines += [
            f'  <joint name="{joint}" type="{kind}">',
            f'    <origin xyz="{_numbers(xyz)}" rpy="{_numbers(rpy)}"/>',
            f'    <parent link="{links[i]}"/>',
            f'    <child link="{links[i + 1]}"/>',
        ]
        if axis is not None:
            lines.append(f'    <axis xyz="{_numbers(axis)}"/>')
            if limit is not None:
                lines.append(f'    <limit lower="{limit[0]!r}" upper="{limit[1]!r}" effort="10" velocity="2"/>')
        lines.append("  </joint>")
    return "\n".join([*lines, "</robot>", ""])


def _numbers(values: Numbers) -> str:
    """Numbers with all their digits."""
    return " ".join(repr(float(v)) for v in values)


def _describe(
    axes: Array,
    points: Array,
    tool: tuple[Array, Array],
    rng: np.random.Generator,
    *,
    name: str,
    aligned: bool,
) -> str:
    """URDF text for axes and points at q = 0, with everything varied that does not touch the structure.

    ``aligned`` leaves every frame parallel to the base, so that directions are written as they are, exactly.
    """

    def frame() -> Array:
        return np.eye(3) if aligned else _turn(rng)

    # Where each frame sits in the arm's own frame: the base's mount, six joints, the tool.
    origins: list[tuple[Array, Array]] = []
    written_axes: list[Array | None] = []
    limits: list[tuple[float, float] | None] = []
    # The base link's own frame is anywhere.
    here_rotation, here = frame(), rng.uniform(-0.5, 0.5, 3)

    def move_to(to_rotation: Array, to: Array, axis: Array | None) -> Array:
        """Append a joint from the present frame to the given one; returns the rotation that the text will give."""
        nonlocal here_rotation, here
        rpy = (0.0, 0.0, 0.0) if aligned else _rpy(here_rotation.T @ to_rotation)
        xyz = here_rotation.T @ (to - here)
        origins.append((xyz, np.array(rpy)))
        # Follow what is written, so that rounding does not add up from joint to joint.
        here = here + here_rotation @ xyz
        here_rotation = here_rotation @ _from_rpy(rpy)
        written_axes.append(None if axis is None else here_rotation.T @ axis)
        limits.append(_limits(rng) if axis is not None else (0.0, 0.0))
        return here_rotation

    move_to(frame(), rng.uniform(-0.3, 0.3, 3), None)
    for i, (axis, point) in enumerate(zip(axes, points, strict=True)):
        if i in (2, 5):  # a fixed joint inside the chain
            move_to(frame(), point + rng.uniform(-0.2, 0.2, 3), None)
        # The frame slides along the axis: an intersection need not be where the frames are.
        move_to(frame(), point + rng.uniform(-0.4, 0.4) * axis, axis)
    position, turn = tool
    move_to(frame(), 0.5 * (position + points[-1]), None)
    move_to(here_rotation if aligned else turn, position, None)
    return serial_urdf(name, origins, written_axes, limits=limits)


def _limits(rng: np.random.Generator) -> tuple[float, float] | None:
    """Limits [rad] of one joint: continuous, or any interval around zero of one to four pi."""
    if rng.uniform() < 0.2:
        return None
    return -float(rng.uniform(0.5 * math.pi, 2.0 * math.pi)), float(rng.uniform(0.5 * math.pi, 2.0 * math.pi))


# ---------------------------------------------------------------- axes of each family

Screws = tuple[Array, Array]
Maker = Callable[[np.random.Generator, bool], Screws]


def length(rng: np.random.Generator) -> float:
    """A link length [m], of either sign."""
    return float(rng.uniform(0.1, 1.0) * rng.choice([-1.0, 1.0]))


def sign(rng: np.random.Generator) -> float:
    """An axis' sign."""
    return float(rng.choice([-1.0, 1.0]))


def leaning(axis: Array, rng: np.random.Generator, *, orthogonal: bool) -> Array:
    """A unit vector that leaves the given one at 30 to 90 degrees to either side, or at exactly 90."""
    if orthogonal:
        candidates = [v for v in (X, Y, Z) if abs(v @ axis) < 0.5]
        return sign(rng) * candidates[int(rng.integers(len(candidates)))]
    across = np.cross(axis, _direction(rng))
    return rotation(across, rng.uniform(math.radians(30.0), math.radians(150.0))) @ axis


def start(rng: np.random.Generator, *, orthogonal: bool) -> Array:
    """The first axis."""
    return sign(rng) * Z if orthogonal else _direction(rng)


def apart(rng: np.random.Generator) -> Array:
    """A step (3,) [m] between two points that leaves no component near zero."""
    return np.array([length(rng) for _ in range(3)])


def _wrist(h3: Array, p3: Array, rng: np.random.Generator, *, orthogonal: bool) -> Screws:
    """Axes 4, 5 and 6 through one point, at a distance from axis 3."""
    h4 = leaning(h3, rng, orthogonal=orthogonal)
    h5 = leaning(h4, rng, orthogonal=orthogonal)
    h6 = leaning(h5, rng, orthogonal=orthogonal)
    return np.array([h4, h5, h6]), np.tile(p3 + apart(rng), (3, 1))


def _wrist_with(
    shoulder: Callable[[np.random.Generator, bool], Screws],
) -> Callable[[np.random.Generator, bool], Screws]:
    """A spherical wrist behind a shoulder of axes 1, 2 and 3."""

    def screws(rng: np.random.Generator, orthogonal: bool) -> Screws:
        axes, points = shoulder(rng, orthogonal)
        wrist_axes, wrist_points = _wrist(axes[2], points[2], rng, orthogonal=orthogonal)
        return np.concatenate([axes, wrist_axes]), np.concatenate([points, wrist_points])

    return screws


def _shoulder_23(rng: np.random.Generator, orthogonal: bool) -> Screws:
    """2 || 3, axis 1 passes both at a distance."""
    h1 = start(rng, orthogonal=orthogonal)
    h2 = leaning(h1, rng, orthogonal=orthogonal)
    p2 = apart(rng)
    return np.array([h1, h2, sign(rng) * h2]), np.array([np.zeros(3), p2, p2 + apart(rng)])


def _shoulder_12_23(rng: np.random.Generator, orthogonal: bool) -> Screws:
    """2 || 3 and 1 x 2."""
    axes, points = _shoulder_23(rng, orthogonal)
    points[1] = axes[0] * length(rng)
    return axes, points


def _shoulder_12(rng: np.random.Generator, orthogonal: bool) -> Screws:
    """1 x 2, axis 3 skew."""
    h1 = start(rng, orthogonal=orthogonal)
    h2 = leaning(h1, rng, orthogonal=orthogonal)
    h3 = leaning(h2, rng, orthogonal=orthogonal)
    p2 = h1 * length(rng)
    return np.array([h1, h2, h3]), np.array([np.zeros(3), p2, p2 + apart(rng)])


def _shoulder_general(rng: np.random.Generator, orthogonal: bool) -> Screws:
    """No two neighbours parallel or intersecting."""
    axes, points = _shoulder_12(rng, orthogonal)
    step = apart(rng)
    points[1:] += step
    return axes, points


def _shoulder_1parallel2(rng: np.random.Generator, orthogonal: bool) -> Screws:
    """1 || 2, axis 3 skew: a general shoulder."""
    h1 = start(rng, orthogonal=orthogonal)
    h3 = leaning(h1, rng, orthogonal=orthogonal)
    p2 = apart(rng)
    return np.array([h1, sign(rng) * h1, h3]), np.array([np.zeros(3), p2, p2 + apart(rng)])


def _shoulder_2x3(rng: np.random.Generator, orthogonal: bool) -> Screws:
    """2 x 3, axis 1 skew: a general shoulder."""
    axes, points = _shoulder_general(rng, orthogonal)
    points[2] = points[1] + axes[1] * length(rng)
    return axes, points


def _three_parallel(rng: np.random.Generator, orthogonal: bool) -> Screws:
    """2 || 3 || 4 with random signs; 5 and 6 skew, 1 and 2 skew."""
    h1 = start(rng, orthogonal=orthogonal)
    h2 = leaning(h1, rng, orthogonal=orthogonal)
    h5 = leaning(h2, rng, orthogonal=orthogonal)
    h6 = leaning(h5, rng, orthogonal=orthogonal)
    points = np.cumsum([np.zeros(3), *(apart(rng) for _ in range(5))], axis=0)
    return np.array([h1, h2, sign(rng) * h2, sign(rng) * h2, h5, h6]), points


def _three_parallel_56(rng: np.random.Generator, orthogonal: bool) -> Screws:
    """2 || 3 || 4 and 5 x 6."""
    axes, points = _three_parallel(rng, orthogonal)
    points[5] = points[4] + axes[4] * length(rng)
    return axes, points


def _three_parallel_12_56(rng: np.random.Generator, orthogonal: bool) -> Screws:
    """2 || 3 || 4, 1 x 2 and 5 x 6."""
    axes, points = _three_parallel_56(rng, orthogonal)
    points[1] = axes[0] * length(rng)
    return axes, points


KINDS: dict[str, Maker] = {
    "wrist, 2||3": _wrist_with(_shoulder_23),
    "wrist, 2||3, 1x2": _wrist_with(_shoulder_12_23),
    "wrist, 1x2": _wrist_with(_shoulder_12),
    "wrist, general": _wrist_with(_shoulder_general),
    "wrist, 1||2": _wrist_with(_shoulder_1parallel2),
    "wrist, 2x3": _wrist_with(_shoulder_2x3),
    "2||3||4, 5x6": _three_parallel_56,
    "2||3||4, 1x2, 5x6": _three_parallel_12_56,
    "2||3||4": _three_parallel,
}
"""Every family's conditions in words, with what makes axes and points that fulfil them and no further ones."""


def random_arm(
    kind: str, seed: int, *, orthogonal: bool = False, aligned: bool = False, kinds: Mapping[str, Maker] = KINDS
) -> DescribedArm:
    """A random member of a family.

    Args:
        kind: a key of ``kinds``.
        seed: the same seed gives the same arm.
        orthogonal: neighbouring axes are parallel or at right angles, along x, y or z of the arm at q = 0.
        aligned: every frame is parallel to the base's, so that the structure is exact to the last digit.
        kinds: what makes axes and points, by kind.
    """
    rng = np.random.default_rng([seed, *kind.encode()])
    axes, points = kinds[kind](rng, orthogonal)
    tool = points[-1] + apart(rng) * 0.5, _turn(rng)
    words = ["orthogonal"] * orthogonal + ["aligned"] * aligned
    name = "-".join([kind.replace(", ", "+").replace("||", "p"), *words, str(seed)])
    urdf = _describe(axes, points, tool, rng, name=name, aligned=aligned)
    return DescribedArm(name, kind, urdf, axes, points)


# ---------------------------------------------------------------- named arms


def from_screws(
    name: str,
    kind: str,
    axes: Sequence[Array] | Array,
    points: Sequence[Sequence[float]] | Array,
    tip: Sequence[float] | Array,
    tip_rpy: Sequence[float] = (0.4, -0.3, 0.9),
) -> DescribedArm:
    """An arm whose frames are the base's at q = 0: directions (n, 3), points (n, 3) on them, the tip (3,)."""
    steps = np.diff(np.vstack([points, tip]), axis=0, prepend=np.zeros((1, 3)))
    origins = [(step, (0.0, 0.0, 0.0)) for step in steps[:-1]] + [(steps[-1], tip_rpy)]
    urdf = serial_urdf(name, origins, [*axes, None])
    return DescribedArm(name, kind, urdf, np.array(axes, dtype=np.float64), np.array(points, dtype=np.float64))


def industrial(*, b: float = 0.0, tool: Sequence[float] = (0.05, 0.02, 0.11)) -> DescribedArm:
    """An arm like the usual six-axis industrial one: shoulder and elbow offsets, axes z y y x y x at q = 0.

    Args:
        b: lateral offset of the wrist's centre [m].
        tool: the tip's place in the flange [m].
    """
    points = np.array(
        [[0, 0, 0.2], [0.15, 0, 0.5], [0.15, 0, 1.1], [0.5, b, 1.22], [0.85, b, 1.22], [0.94, b, 1.22]], dtype=float
    )
    axes = [Z, Y, Y, X, Y, X]
    return from_screws("industrial", "wrist, 2||3", axes, points, points[-1] + tool, (0.1, math.pi / 2 - 0.2, -0.3))


def ur_like(signs: Sequence[float] = (1, 1, 1, 1, 1, 1), tool: Sequence[float] = (0.01, 0.12, 0.05)) -> DescribedArm:
    """An arm with the proportions of a UR: axes z y y y z y at q = 0, straight up, each with a sign of its own.

    Args:
        signs: +-1 for every axis.
        tool: the tip's place in the flange [m].
    """
    points = np.array(
        [[0, 0, 0.09], [0, 0.135, 0.09], [0, 0.02, 0.51], [0, 0.02, 0.9], [0, 0.11, 0.9], [0, 0.11, 1.0]], dtype=float
    )
    axes = [sign * axis for sign, axis in zip(signs, [Z, Y, Y, Y, Z, Y], strict=True)]
    return from_screws("ur_like", "2||3||4, 1x2, 5x6", axes, points, points[-1] + tool, (0.3, 0.2, -0.1))
