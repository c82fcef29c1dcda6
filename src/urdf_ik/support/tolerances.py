"""Every numerical tolerance of the package, with its meaning. Lengths are relative to the arm's size."""

from __future__ import annotations

from dataclasses import dataclass

LARGEST = 1e15
"""Greatest length [m], angle [rad] or factor that is taken: beyond it a double holds no digit of a millimetre or of an
angle, and squares of what solvers multiply begin to overflow. ``src/core/kinematics/arm.hpp`` has the same."""

STILL = 1e-17
"""A joint that mimics another with a smaller multiplier stands still: in a turn it moves less than rounding."""


@dataclass(frozen=True)
class SolverTolerances:
    """What the compiled solvers compare with: ``Tolerances`` of src/core/kinematics/arm.hpp.

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
    """What all else compares with, too.

    Attributes:
        near_angle: two axes this close to parallel [rad] may be meant to be.
        near_distance: two axes this close [share of size] may be meant to meet.
        contract: error [of the arm's size, rad] that every result keeps within.
        damped: smallest singular value, lengths as shares of the size, below which joint velocities are damped.
        damping: their damping at a singularity.
    """

    near_angle: float = 0.02
    near_distance: float = 1e-3
    contract: float = 1e-9
    damped: float = 0.01
    damping: float = 0.01


DEFAULT = Tolerances()
