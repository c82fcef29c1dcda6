"""Every numerical tolerance of the package, with its meaning. Lengths are relative to the arm's size."""

from dataclasses import dataclass

LARGEST = 1e15
"""Greatest valid length [m], angle [rad] or factor: beyond it a double does not resolve a millimetre or an angle, and
products in the solvers begin to overflow. ``src/core/arm/arm.hpp`` has the same value."""

STILL = 1e-17
"""A joint that mimics another with a smaller multiplier stands still: in a turn it moves less than rounding."""


@dataclass(frozen=True)
class SolverTolerances:
    """Tolerances of the compiled solvers: ``Tolerances`` of src/core/arm/arm.hpp.

    Attributes:
        reach: position [of the arm's size] and rotation [rad] error below which a solution is verified.
        edge: squared distance from a singularity, as a share, below which a pose leaves the fast path.
        fold: pose error half way between two solutions below which they are one double root: it falls with the
            square of their distance, and 2e-14 is about 2e-7 rad, the resolution of double precision.
        continuum: squared distance below which a joint counts as free and a representative is returned.
        singular: smallest singular value of the Jacobian, lengths as shares of the size, below which its rank
            counts as dropped.
        duplicate: two joint vectors closer than this in every joint [rad] are one solution.
        rotation: greatest entry of R^T R - I that is still read as a rotation with rounding errors.
        exact_rotation: the same, below which the rotation is used as it stands instead of being projected.
        exact_structure: imperfection [rad, share of size] below which an arm is a member of its family.
    """

    reach: float = 1e-10
    edge: float = 1e-7
    fold: float = 2e-14
    continuum: float = 4e-22
    singular: float = 1e-6
    duplicate: float = 1e-8
    rotation: float = 1e-5
    exact_rotation: float = 1e-12
    exact_structure: float = 1e-13


@dataclass(frozen=True)
class Tolerances(SolverTolerances):
    """All tolerances: those of the compiled solvers, and those of the Python code.

    Attributes:
        near_angle: two axes this close to parallel [rad] may be intended as parallel.
        near_distance: two axes this close [share of size] may be intended to intersect.
        contract: greatest error of every result [share of the arm's size, rad].
        damped: smallest singular value, lengths as shares of the size, below which derivatives are damped.
    """

    near_angle: float = 0.02
    near_distance: float = 1e-3
    contract: float = 1e-9
    damped: float = 0.01


DEFAULT = Tolerances()
