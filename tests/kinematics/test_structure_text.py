"""How a structure reads: its text, and the names of its branches."""

import re

import cases
import numpy as np
import pytest
from arms import KINDS, X, Z, industrial, rotation
from arms_general import crx_like
from numpy.typing import NDArray
from structures import of_kind, relations, structure_of, text_of

import urdf_ik

Array = NDArray[np.float64]


def test_text_of_the_article_arm() -> None:
    """The sentences say family, relations, method, number of solutions and imperfection."""
    structure = cases.from_catalogue("zyyzyz_6r").arm.structure
    assert str(structure) == (
        "6 joints (RRRRRR): 6R spherical wrist, 2||3 and 1x2. Axes 4, 5 and 6 meet in a point; axes 1 and 2 are "
        "intersecting at 90 deg; axes 2 and 3 are parallel, 1 m apart; axes 3 and 4 are intersecting at 90 deg; axes 4 "
        "and 5 are intersecting at 90 deg; axes 5 and 6 are intersecting at 90 deg. "
        f"{structure.method}. Up to 8 solutions. Imperfection: none: the URDF as written is of this family, exact to "
        "rounding."
    )


def test_text_tells_the_imperfection() -> None:
    """An arm that is not exact says by how much, in rad and m, and that it is solved as written all the same."""
    wrist = industrial()
    axes, points = wrist.axes.copy(), wrist.points.copy()
    axes[2] = rotation(X, 3e-5) @ axes[2]
    points[5] += 6e-4 * Z
    structure = structure_of(axes, points)
    text = str(structure)
    assert "3e-05 rad and 0.0004 m off" in text
    assert "exact to rounding" not in text
    assert "verified on the URDF as written" in text
    assert "Up to 16 solutions: 8 next to those of the ideal arm, and 8 that only the arm as written can have." in text
    assert structure.is_exact is False


def test_text_of_a_general_arm() -> None:
    """An arm without a closed form says why it has none, and claims no exactness of a structure it does not use."""
    text = str(cases.described(crx_like()).arm.structure)
    assert "No three neighbouring axes meet in a point or are parallel, so no closed form applies." in text
    assert "exact" not in text
    assert "Up to 16 solutions." in text


def test_text_tells_what_nearly_intersects() -> None:
    """Where axes 1 and 2 miss each other by 0.4 mm, which the family does not mind, nothing says that they meet."""
    wrist = industrial()
    points = wrist.points.copy()
    points[1:] -= [0.1496, 0.0, 0.0]
    structure = structure_of(wrist.axes, points)
    assert structure.pairs[0].distance == pytest.approx(4e-4)
    assert re.search(r"axes 1 and 2 are [^;]*(0\.0004|4e-04)", str(structure), re.IGNORECASE)


@pytest.mark.parametrize(
    ("direction", "point", "text"),
    [
        (Z, [0.3, 0.4, 7.0], "axes 1 and 2 are parallel, 0.5 m apart"),
        (-Z, [0.0, 0.0, 7.0], "axes 1 and 2 are coincident"),
        (np.array([0.6, 0.0, 0.8]), [3.0, 0.0, 1.0], "axes 1 and 2 are intersecting at 36.8699 deg"),
        (X, [4.0, 0.25, 2.0], "axes 1 and 2 are skew at 90 deg, 0.25 m apart"),
    ],
)
def test_text_of_a_pair(direction: Array, point: list[float], text: str) -> None:
    """A pair reads as a clause with its angle and its distance, where the relation leaves them open."""
    assert str(relations([Z, direction], [np.zeros(3), point]).pairs[0]) == text


def test_branch_names_are_the_columns() -> None:
    """The names that the structure tells are those of the answers, for every pose, reachable or not."""
    for kind in KINDS:
        described = of_kind(kind)
        arm = urdf_ik.load(text_of(described.axes, described.points), "base", "tool")
        far = np.eye(4)
        far[0, 3] = 1e3
        for target in (arm.fk(np.full(6, 0.4)), far, np.array([far, far])):
            assert arm.ik(target).branches == arm.structure.branches
