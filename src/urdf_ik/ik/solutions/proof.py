"""What the solver proves about the solutions of one pose, as data that others can check."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.support.read_only import frozen
from urdf_ik.typing import Array

Complex = NDArray[np.complex128]

WORDS = {0: "complete", 32: "incomplete", 64: "clustered", 96: "continuum"}
"""Statuses by the bits of a pose's first column."""
_WHY = (
    "nothing is proven",
    "six turning joints have at most 16 solutions",
    "the axes are exactly those of the family",
    "each real solution is a zero of the elimination's determinant, which has no more",
)


@dataclass(frozen=True, eq=False, slots=True)
class Proof:
    """The complex solutions of one pose that are proven to exist, and how many there can be.

    Joint vectors q are those of ``s.q``: the tip is at the pose where the product of the joints' motions is, with
    complex angles as well; whole turns do not count. Ball k holds the joint vectors ``roots[k] + d`` with complex
    ``|d_j| <= inner[k]`` for each joint j.

    Attributes:
        status: as ``s.status``.
        expected: how many isolated complex solutions there can be, counted by multiplicity; or how many real ones, as
            ``why`` says, and then the complex ones are not here.
        why: why there are no more than that, in words.
        roots: (k, 6) rad, complex; of a conjugate pair both.
        inner: (k,) rad, one solution is at most that far from each root, in every joint; the balls are disjoint.
        outer: (k,) rad, no second one is.
        real: (k,) whether the solution is real; otherwise its imaginary part exceeds ``inner`` in some joint.
        counted: the solutions in all balls.
    """

    status: str
    expected: int
    why: str
    roots: Complex
    inner: Array
    outer: Array
    real: NDArray[np.bool_]

    @property
    def counted(self) -> int:
        """The solutions in all balls."""
        return len(self.roots)


def proof_of(data: dict[str, Any]) -> Proof:
    """The proof from what the compiled solver says."""
    return Proof(
        status=WORDS[data["status"]],
        expected=data["expected"],
        why=_WHY[data["why"]],
        roots=_complex(data["roots"]),
        inner=frozen(data["inner"]),
        outer=frozen(data["outer"]),
        real=frozen(np.array(data["real"], dtype=np.bool_)),
    )


def _complex(pairs: Array) -> Complex:
    return frozen(pairs[..., 0] + 1j * pairs[..., 1])
