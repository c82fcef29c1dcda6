"""One solution, the arrays of all solutions of a batch, and the steps by which these were made."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntFlag
from typing import TYPE_CHECKING, Any, NamedTuple, Self, overload

import numpy as np
from numpy.typing import NDArray

from urdf_ik._core import Answer
from urdf_ik.errors import ArgumentError
from urdf_ik.ik.solutions import branch_names
from urdf_ik.ik.solutions.branch_names import suffix
from urdf_ik.ik.solutions.proof import WORDS
from urdf_ik.ik.solver import Solver
from urdf_ik.support.angles import TURN
from urdf_ik.support.read_only import frozen
from urdf_ik.support.report import html_of
from urdf_ik.support.text import Section, quoted
from urdf_ik.typing import Array


def picked(shape: tuple[int, ...], index: Any) -> NDArray[np.intp]:
    """Numbers of those poses of a batch of ``shape`` that an index picks, whatever NumPy takes for one.

    Raises:
        ArgumentError: it is no index, or leads out of the batch.
    """
    try:
        return np.asarray(np.arange(math.prod(shape)).reshape(shape)[index])
    except (IndexError, TypeError, ValueError) as failure:
        raise ArgumentError(f"index {quoted(index)} into a batch of shape {shape}: {failure}") from None


def place_of(count: int, index: int, what: str) -> int:
    """The place in a sequence that an index names, from its end where it is negative.

    Raises:
        ArgumentError: it leads out of the sequence.
    """
    try:
        return range(count)[index]
    except IndexError:
        raise ArgumentError(f"index {index} given; there are {count} {what}") from None


Columns = NDArray[np.intp]
Places = slice | tuple[int | slice, ...] | list[int] | NDArray[Any]

# A pose's status stands in two bits of its first column's flags; the lower one says that solutions may be missing.
_STATUS, _UNCERTAIN = np.uint8(5), np.uint8(32)
_WORDS = np.array([WORDS[32 * k] for k in range(4)])


class Singular(IntFlag):
    """Where the Jacobian of a solution loses rank; 0 where it does not.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("puma_560")
        >>> q = [0.3, -0.5, 0.8, 0.4, 0.0, -0.2]
        >>> arm.ik(arm.fk(q), q).nearest(q)[0].singular == Singular.WRIST
        True
    """

    SHOULDER = 1
    ELBOW = 2
    WRIST = 4
    OTHER = 8


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Solution:
    """One joint vector that brings the tip to the pose.

    Attributes:
        q: (n,) rad or m, read-only.
        branch: name of its branch, with the turns of an image, as in 'shoulder front, elbow up [q1+360°]'.
        singular: where the arm is singular there.
        index: column in the solutions that it was taken from.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("scara_rrpr")
        >>> solution = arm.ik(arm.fk([0.3, 0.5, 0.1, 0.2])).nearest([0.3, 0.5, 0.1, 0.2])[0]
        >>> solution.branch, solution.q.round(6).tolist(), bool(solution.singular)
        ('elbow right', [0.3, 0.5, 0.1, 0.2], False)
    """

    q: Array
    branch: str
    singular: Singular
    index: int

    def __str__(self) -> str:
        flag = f" (singular: {self.singular.name})" if self.singular else ""
        return f"{self.branch}: [{', '.join(f'{x:.6f}' for x in self.q)}]{flag}"

    def __repr__(self) -> str:
        return f"<Solution {self}>"

    def _repr_html_(self) -> str:
        header = [f"q{k + 1}" for k in range(len(self.q))]
        found = f"singular: {self.singular.name}" if self.singular else "solution"
        return html_of(
            self.branch, found, not self.singular, [Section("", tuple(header), (tuple(f"{x:.6f}" for x in self.q),))]
        )


class Error(NamedTuple):
    """What solutions miss of their targets: ``position`` (..., B) m and ``rotation`` (..., B) rad."""

    position: Array
    rotation: Array


class Step(NamedTuple):
    """How solutions were made from others.

    Attributes:
        how: 'limits', 'turns', 'collision', 'within', 'configuration', 'nearest' or 'best'.
        parent: the solutions before.
        columns: (..., B) the column of theirs that each column comes from; None: the same.
        amount: tolerance [rad or m] of the limits, margin [m] of collisions.
        apart: (..., B, n) rad or m, how far each joint of the solutions before was from the reference, for 'within'.
        within: (n,) rad or m, how far it may be, for 'within'.
        model: what was asked whether anything touches, for 'collision'; text and vendor, for 'configuration'.
    """

    how: str
    parent: "KeptSolutions"
    columns: Columns | None = None
    amount: float = 0.0
    apart: Array | None = None
    within: Array | None = None
    model: Any = None


class KeptSolutions(Answer):
    """The arrays of :class:`IKSolutions`, which adds what is done with them."""

    # Solving one pose takes a fraction of a microsecond. The compiled base keeps what is set below; where the solver
    # itself made it, it makes the arrays of poses, q and info when they are first asked for.
    __slots__ = ()

    def __init__(
        self,
        solver: Solver,
        T: Array,
        q: Array,
        info: NDArray[np.uint8],
        branches: tuple[str, ...],
        origin: Columns | None = None,
        step: Step | None = None,
        redundancy: Array | None = None,
    ) -> None:
        """Keep the arrays as they are, without a check or a copy.

        Args:
            solver: the solver that made them.
            T: (..., 4, 4) m, the poses.
            q: (..., B, n) rad or m, NaN rows where there is no solution.
            info: (..., B), bit 0: valid, bits 1 to 4: ``Singular``; bits 5 and 6 of the first column: the pose's
                status.
            branches: B names.
            origin: (B,) each column's branch of the family; default: its own index.
            step: how they were made from other solutions; None: solved.
            redundancy: (...) rad or m, each pose's value of the redundancy parameter; None: its default.
        """
        self.solver = solver
        self._poses = T
        self._q = q
        self._info = info
        self._branches = branches
        self._origin = origin
        self.step = step
        self._redundancy = redundancy

    if TYPE_CHECKING:

        @property
        def q(self) -> Array:
            """(..., B, n) rad or m, NaN where there is no solution; angles in (-pi, pi] as the solver gives them."""
    else:
        q = Answer._read_only_q  # a property written in Python takes as long as a fifth of solving a pose

    def __reduce__(self) -> tuple[type[Self], tuple[Any, ...]]:
        arrays = (self._poses, self._q, self._info)
        return type(self), (self.solver, *arrays, self._branches, self._origin, self.step, self._redundancy)

    @property
    def arm(self) -> Any:
        """The :class:`urdf_ik.Arm` that they are solutions of."""
        return self.solver.arm

    @property
    def valid(self) -> NDArray[np.bool_]:
        """(..., B) whether there is a solution."""
        return frozen((self._info & 1).view(np.bool_))

    @property
    def singular(self) -> NDArray[np.uint8]:
        """(..., B) bits of ``Singular``, 0 where there is no solution."""
        return frozen(self._info >> np.uint8(1) & np.uint8(15))

    @property
    def status(self) -> NDArray[np.str_]:
        """(...) what is known about each pose's solutions, in one word.

        - 'complete': every solution is there, once. Without solutions the pose is unreachable.
        - 'clustered': every solution is counted; the rounding of the pose decides how many a group of close ones
          has: they stand as one, or each for itself.
        - 'continuum': a curve of solutions keeps the pose. Its representatives are there; other ones may be missing.
        - 'incomplete': solutions may be missing.

        docs/explanation/proven.md says for which arms the first two are proven, and up to which rounding. What filters
        drop does not change it.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("puma_560")
            >>> str(arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])).status)
            'complete'
        """
        return frozen(np.asarray(_WORDS[(self._first_flags >> _STATUS) & np.uint8(3)]))

    @property
    def certain(self) -> NDArray[np.bool_]:
        """(...) whether no solution is missing: the status is 'complete' or 'clustered'."""
        return frozen(np.asarray(self._first_flags & _UNCERTAIN == 0))

    @property
    def _first_flags(self) -> NDArray[np.uint8]:
        """(...) flags of the first columns, as they were solved."""
        solved: KeptSolutions = self
        while solved.step is not None:
            solved = solved.step.parent
        return np.asarray(solved._info[..., 0])

    @property
    def branches(self) -> tuple[str, ...]:
        """B names, one a column, the same for every pose."""
        return self._branches

    @property
    def poses(self) -> Array:
        """(..., 4, 4) m, the poses that were solved, in the base link."""
        return frozen(self._poses.view())

    @property
    def redundancy(self) -> Array | None:
        """(...) rad or m, the redundancy parameter that each pose was solved at; None for an arm without one.

        (..., k) for an arm with k parameters.
        """
        if self._redundancy is not None:
            return frozen(self._redundancy.view())
        defaults = np.array([parameter.default for parameter in self.solver.parameters])
        if not len(defaults):
            return None
        return frozen(np.full(self.shape, defaults[0]) if len(defaults) == 1 else np.tile(defaults, (*self.shape, 1)))

    @property
    def error(self) -> Error:
        """What each solution misses of its target: ``error.position`` (..., B) m and ``error.rotation`` (..., B) rad.

        NaN where there is no solution. :meth:`urdf_ik.Arm.ik` finds exact ones, to 1e-9, unless a tolerance is given.
        """
        return Error(*self.missed(self.solver.chain.fk(self._q), (..., None)))

    def missed(self, reached: Array, index: Any) -> tuple[Array, Array]:
        """What poses of the tip miss of the targets ``[index]``: distances [m] and angles [rad]."""
        solver, T = self.solver, self._poses
        if solver.targets is not None:
            target: Array = T[(*index, slice(None))] if isinstance(index, tuple) else T[index]
            off, angle = solver.control.errors(reached, target)
            return off, angle
        if solver.free_axis is not None:
            values = np.zeros(self.shape) if self._redundancy is None else self._redundancy
            T = T @ solver.free_axis.rotation(values if len(solver.parameters) < 2 else values[..., 0])
        T = T[(*index, slice(None), slice(None))] if isinstance(index, tuple) else T[index]
        off, angle = solver.asked.errors(T, reached)
        return off, angle

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the batch; () for a single pose."""
        return self._info.shape[:-1]

    @property
    def count(self) -> NDArray[np.intp]:
        """(...) number of solutions of each pose."""
        return np.asarray(np.sum(self._info & 1, axis=-1, dtype=np.intp))

    @property
    def origin(self) -> Columns:
        """(..., B) index of each solution's branch in the family's branches."""
        if self.step is None:
            own = np.arange(self._info.shape[-1]) if self._origin is None else self._origin
            return np.broadcast_to(own, self._info.shape)
        origin = self.step.parent.origin
        return origin if self.step.columns is None else np.take_along_axis(origin, self.step.columns, axis=-1)

    @property
    def names(self) -> NDArray[np.object_]:
        """(..., B) each solution's branch, with the turns of an image; unlike ``branches`` also of those picked.

        Where geometry gives no name: the sign of the Jacobian's determinant, which lasts, and a number, which does not;
        see :mod:`urdf_ik.ik.solutions.branch_names`.
        """
        if self.step is None:
            plain = np.broadcast_to(np.array(self._branches, dtype=np.object_), self._info.shape)
            local = branch_names.local(self._branches)
            return branch_names.signed(plain, self._q, self.singular, self.solver) if local else plain
        names: NDArray[np.object_] = self.step.parent.names
        if self.step.columns is not None:
            names = np.take_along_axis(names, self.step.columns, axis=-1)
        if self.step.how == "turns":
            names = names.copy()
            for place in np.argwhere(self._info & 1):
                names[tuple(place)] += suffix(self._turns_of(self._q[tuple(place)]))
        return names

    @property
    def filters(self) -> tuple[str, ...]:
        """How they were chosen: the ``how`` of each step, in order."""
        return () if self.step is None else (*self.step.parent.filters, self.step.how)

    @property
    def rotary(self) -> NDArray[np.bool_]:
        """(n,) true for joints that turn, false for prismatic ones."""
        return np.array([kind != "prismatic" for kind in self.solver.chain.joint_types], dtype=np.bool_)

    def to_array(self) -> Array:
        """The valid solutions (k, n) of a single pose.

        Raises:
            ArgumentError: this is a batch.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> arm.ik(arm.fk([0.3, 0.5, 0.1, 0.2])).to_array().round(4).tolist()
            [[0.7574, -0.5, 0.1, -0.3426], [0.3, 0.5, 0.1, 0.2]]
        """
        return self._q[self._columns("to_array()")]

    def __len__(self) -> int:
        return len(self._columns("len()"))

    def __bool__(self) -> bool:
        return len(self._columns("the truth value")) > 0

    def __iter__(self) -> Iterator[Solution]:
        columns = self._columns("iteration")
        names = self.names
        return (self._solution(column, names[column]) for column in columns)

    @overload
    def __getitem__(self, index: int) -> Any: ...  # a Solution of a single pose, the solutions of one pose of a batch

    @overload
    def __getitem__(self, index: Places) -> Self: ...

    def __getitem__(self, index: int | Places) -> Any:
        """Poses of a batch: ``IKSolutions``; of a single pose the solution with this number: ``Solution``."""
        if not self.shape:
            if isinstance(index, int | np.integer):
                columns = self._columns("an index")
                column = columns[place_of(len(columns), index, "solutions of this pose")]
                return self._solution(column, self.names[column])
            raise ArgumentError(
                f"index {quoted(index)}: the solutions of a single pose take a whole number; or use to_array()"
            )
        # Applied to the places of the poses, so that columns and joints stay whole.
        place = np.unravel_index(picked(self.shape, index), self.shape)
        step = self.step
        if step is not None:
            own = None if step.columns is None else step.columns[place]
            apart = None if step.apart is None else step.apart[place]
            step = step._replace(parent=step.parent[place], columns=own, apart=apart)
        at = None if self._redundancy is None else np.asarray(self._redundancy[place])
        return type(self)(
            self.solver, self._poses[place], self._q[place], self._info[place], self._branches, self._origin, step, at
        )

    @property
    def _turning(self) -> Array:
        """(n,) turns between images that are the same solution: 0 for all where images stand in their own columns."""
        return np.asarray(self.solver.chain.image_turns * ("turns" not in self.filters))

    def _turns_of(self, q: Array) -> Array:
        """Turns (..., n) that joint vectors are away from where the solver gives them, (-pi, pi]."""
        apart = self.solver.chain.image_turns
        return np.asarray(apart * np.ceil((q - np.pi * apart) / (TURN * np.where(apart, apart, 1.0))))

    def _columns(self, what: str) -> Columns:
        """Columns of a single pose's valid solutions."""
        if self.shape:
            raise ArgumentError(
                f"{what} needs a single pose, and these are the solutions of a batch of shape {self.shape}: take one, "
                "s[i], or the arrays s.q, s.valid and s.count"
            )
        return np.flatnonzero(self._info & 1)

    def _solution(self, column: np.intp, name: str) -> Solution:
        return Solution(frozen(self._q[column]), name, Singular(int(self._info[column]) >> 1 & 15), int(column))
