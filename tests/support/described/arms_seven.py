"""URDF text of arms with seven joints: random members of S-R-S and of what is left when an end joint is held."""

import numpy as np
from arms import (
    KINDS,
    Array,
    DescribedArm,
    Screws,
    Z,
    _describe,
    _turn,
    apart,
    leaning,
    length,
    serial_urdf,
    sign,
)


def _triple(h: Array, rng: np.random.Generator, *, orthogonal: bool) -> Array:
    """Three directions (3, 3), the first leaning away from h."""
    out = []
    for _ in range(3):
        h = leaning(h, rng, orthogonal=orthogonal)
        out.append(h)
    return np.array(out)


def _srs(rng: np.random.Generator, orthogonal: bool, *, offset: bool) -> Screws:
    """Axes 1 to 3 through one point, 5 to 7 through another; axis 4 passes their line at a distance, or crosses it."""
    start = sign(rng) * Z if orthogonal else _turn(rng) @ Z
    shoulder = _triple(start, rng, orthogonal=orthogonal)
    elbow = leaning(shoulder[2], rng, orthogonal=orthogonal)
    wrist = _triple(elbow, rng, orthogonal=orthogonal)
    if offset:
        at_elbow, at_wrist = apart(rng), apart(rng)
    else:
        # At q = 0 the arm is stretched, and axis 4 is at right angles to it.
        away = leaning(elbow, rng, orthogonal=True) if orthogonal else np.cross(elbow, _turn(rng) @ Z)
        away /= np.linalg.norm(away)
        at_elbow, at_wrist = abs(length(rng)) * away, abs(length(rng)) * away
    points = np.concatenate([np.zeros((3, 3)), [at_elbow], np.tile(at_elbow + at_wrist, (3, 1))])
    return np.concatenate([shoulder, [elbow], wrist]), points


def _before(kind: str, rng: np.random.Generator, orthogonal: bool) -> Screws:
    """One more axis in front of a six-joint member of ``kind``."""
    axes, points = KINDS[kind](rng, orthogonal)
    h = leaning(axes[0], rng, orthogonal=orthogonal)
    return np.vstack([h, axes]), np.vstack([points[0] + apart(rng), points])


def _behind(kind: str, rng: np.random.Generator, orthogonal: bool) -> Screws:
    """The same from the tip: a mirrored member of ``kind``, and one more axis behind it."""
    axes, points = _before(kind, rng, orthogonal)
    return axes[::-1].copy(), points[::-1].copy()


SEVEN = {
    "S-R-S": lambda rng, orthogonal: _srs(rng, orthogonal, offset=False),
    "S-R-S, offset elbow": lambda rng, orthogonal: _srs(rng, orthogonal, offset=True),
    "one before wrist, 2||3": lambda rng, orthogonal: _before("wrist, 2||3", rng, orthogonal),
    "one before wrist, 1x2": lambda rng, orthogonal: _before("wrist, 1x2", rng, orthogonal),
    "one behind wrist, 1x2": lambda rng, orthogonal: _behind("wrist, 1x2", rng, orthogonal),
    "one before 2||3||4, 5x6": lambda rng, orthogonal: _before("2||3||4, 5x6", rng, orthogonal),
    "one behind 2||3||4, 5x6": lambda rng, orthogonal: _behind("2||3||4, 5x6", rng, orthogonal),
}
"""Conditions in words, with what makes axes and points that fulfil them."""


def random_seven(kind: str, seed: int, *, orthogonal: bool = False, aligned: bool = False) -> DescribedArm:
    """A random member of a kind of ``SEVEN``; arguments as those of ``arms.random_arm``."""
    rng = np.random.default_rng([seed, *kind.encode()])
    axes, points = SEVEN[kind](rng, orthogonal)
    tool = points[-1] + apart(rng) * 0.5, _turn(rng)
    words = ["orthogonal"] * orthogonal + ["aligned"] * aligned
    name = "-".join([kind.replace(", ", "+").replace("||", "p").replace(" ", "_"), *words, str(seed)])
    return DescribedArm(name, kind, _describe(axes, points, tool, rng, name=name, aligned=aligned), axes, points)


def skew(n: int) -> str:
    """URDF text of n skew axes."""
    rng = np.random.default_rng(n)
    origins = [(rng.uniform(0.1, 0.4, 3), rng.uniform(-1.0, 1.0, 3)) for _ in range(n + 1)]
    return serial_urdf(f"{n}R", origins, [*rng.normal(size=(n, 3)), None])


def sliding(urdf: str, joint: int, lower: float, upper: float) -> str:
    """URDF text in which joint ``joint``, counted from 1, slides between these limits [m]."""
    head, mark, tail = urdf.partition(f'<joint name="joint_{joint}" ')
    body, end, rest = tail.partition("</joint>")
    kept = [line for line in body.splitlines() if "<limit" not in line]
    kept[0] = 'type="prismatic">'
    limit = f'    <limit lower="{lower!r}" upper="{upper!r}" effort="10" velocity="2"/>'
    return head + mark + "\n".join([*kept[:-1], limit, kept[-1]]) + end + rest
