"""One root of the loop equations, enclosed by a theorem that is evaluated in ball arithmetic."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import acb, acb_mat, arb

from urdf_ik.verify.proof.loop import Loop, box, is_identity, largest, midpoints, residual

_STEPS = 12  # from about sixteen digits to the precision, where the root is single
_LEAST, _GREATEST = arb(2) ** -48, arb(2) ** -4  # half widths of the boxes that are tried


@dataclass(frozen=True)
class Enclosure:
    """A box that holds exactly one root of the loop. The root is real where the centre is.

    Attributes:
        centre: six complex angles [rad].
        radius: half width of the box in every real and imaginary part [rad].
    """

    centre: list[acb]
    radius: arb


def enclosed(loop: Loop, start: Sequence[acb]) -> Enclosure | None:
    """A box that holds ``start`` and exactly one root, which Newton's method from there finds; None if there is none.

    With C an approximate inverse of the Jacobian at the centre c, ``-C f(c) + (1 - C J(B)) (B - c)`` inside B - c
    proves that B holds exactly one root (R. Krawczyk, Computing 4, 1969). It holds for analytic functions of complex
    boxes, as J(B) encloses the mean of the Jacobian along every segment of B. The equations are real: with a root its
    conjugate is one, and in a box around real numbers they are the same.
    """
    centre = midpoints(start)
    step = arb("inf")
    try:
        for _ in range(_STEPS):
            X, J = loop.jacobian(centre)
            move = J.solve(_column(residual(X))).entries()
            taken = largest(move)
            if not taken < step:
                break
            centre, step = midpoints([c - d for c, d in zip(centre, move, strict=True)]), taken
        X, J = loop.jacobian(centre)
        C = acb_mat(6, 6, midpoints(J.inv().entries()))
    except ZeroDivisionError:
        return None
    moved = C * _column(residual(X))
    radius = (2 * largest([*moved.entries(), *between(start, centre)])).max(_LEAST)
    while radius < _GREATEST:
        X, J = loop.jacobian(box(centre, radius))
        rest = acb_mat(np.eye(6, dtype=int).tolist()) - C * J
        image = (rest * _column(box([acb(0)] * 6, radius)) - moved).entries()
        if all(abs(x.real) < radius and abs(x.imag) < radius for x in image):
            return Enclosure(centre, radius) if is_identity(X) else None
        radius *= 8
    return None


def _column(values: Sequence[acb]) -> acb_mat:
    return acb_mat([[value] for value in values])


def between(a: Sequence[acb], b: Sequence[acb]) -> list[acb]:
    """The differences of angles, without whole turns."""
    out = []
    for one, other in zip(a, b, strict=True):
        d = one - other
        whole = round(float(d.real) / (2 * np.pi))
        out.append(acb(d.real - 2 * whole * arb.pi(), d.imag))
    return out
