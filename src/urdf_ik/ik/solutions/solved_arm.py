"""The arm as its solutions see it, which lets them do without the room that makes arms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from urdf_ik.kinematics.chain import Chain
    from urdf_ik.kinematics.chain.free_axis import FreeAxis
    from urdf_ik.kinematics.chain.redundancy import Redundancy
    from urdf_ik.kinematics.structure import Structure


class Collisions(Protocol):
    """What ``collision_free`` asks whether the arm touches anything."""

    def in_collision(self, q: NDArray[np.float64], margin: float = 0.0) -> Any:
        """(k, n) rad or m to (k,): whether two bodies come within a margin [m]."""

    def motions_free(self, q0: NDArray[np.float64], q1: NDArray[np.float64], margin: float = 0.0) -> Any:
        """Whether straight motions between joint vectors (k, n) are free, as ``Motions``."""

    def nearest_pair(self, q: NDArray[np.float64]) -> Any:
        """What comes closest to each other, as ``Nearest``."""

    def in_world(self, world: Any) -> Collisions:
        """The same among the obstacles of a world, or itself for None."""


class Control(Protocol):
    """What an arm controls of its tip."""

    @property
    def part(self) -> str:
        """Rows of the Jacobian that matter."""


class SolvedArm(Protocol):
    """What solutions ask of the arm that they belong to."""

    @property
    def name(self) -> str:
        """The robot's name."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Movable joints, base to tip."""

    @property
    def limits(self) -> NDArray[np.float64]:
        """(n, 2) rad or m."""

    @property
    def velocity_limits(self) -> NDArray[np.float64]:
        """(n,) rad/s or m/s, infinite where none is known."""

    @property
    def control(self) -> Control:
        """What the joints control of the tip."""

    def manipulability(self, q: Any, part: str = "all") -> NDArray[np.float64]:
        """Yoshikawa's measure of joint vectors."""

    def clearance(self, q: Any, world: Any = None) -> Any:
        """Least distance of what must not touch [m]."""

    @property
    def collision_model(self) -> Collisions:
        """What ``collision_free`` asks."""

    @property
    def chain(self) -> Chain:
        """The joints and their types."""

    @property
    def redundancy(self) -> Redundancy | None:
        """The parameter of an arm with seven joints."""

    @property
    def redundancies(self) -> tuple[Redundancy, ...]:
        """Every parameter, of an arm with several."""

    def explain(self, T: Any, redundancy: Any = None) -> str:
        """Why a pose has no solution."""


class SolvingArm(SolvedArm, Protocol):
    """What searches ask of an arm: solutions, too."""

    @property
    def dof(self) -> int:
        """Number of joints."""

    @property
    def structure(self) -> Structure:
        """Its axes, and how it is solved."""

    @property
    def free_axis(self) -> FreeAxis | None:
        """The line in the tip about which it may be turned."""

    @property
    def fixed(self) -> SolvingArm:
        """The same arm without a free axis."""

    def fk(self, q: Any) -> NDArray[np.float64]:
        """Pose of the tip."""

    def ik(self, T: Any, *, redundancy: Any = None, threads: int = 1) -> Any:
        """The solutions of poses, as ``IKSolutions``."""

    def nearest_values(self, q: NDArray[np.float64], T: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values of the redundancy parameters at which poses come nearest to joint vectors."""
