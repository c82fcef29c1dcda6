"""IKSolutions: what ``arm.ik`` returns, and how solutions are filtered, multiplied and chosen."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntFlag
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from urdf_ik._core import Answer
from urdf_ik.errors import UrdfIkError
from urdf_ik.solutions import limits, select
from urdf_ik.solutions import sentences as text

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.collision import CollisionModel
    from urdf_ik.solutions.solved_arm import SolvedArm

    Array = NDArray[np.float64]
    Columns = NDArray[np.intp]

_Number = TypeVar("_Number", bound=np.generic)

# The bit of a pose's first column that says that other solutions may be missing.
_UNCERTAIN = np.uint8(32)


class Singular(IntFlag):
    """Where the Jacobian of a solution loses rank; 0 where it does not."""

    SHOULDER = 1
    ELBOW = 2
    WRIST = 4
    OTHER = 8


@dataclass(frozen=True, eq=False, slots=True)
class Solution:
    """One joint vector that brings the tip to the pose.

    Attributes:
        q: (n,) rad or m, read-only.
        branch: name of its branch, with the turns of an image, as in 'shoulder front, elbow up [q1+360°]'.
        singular: where the arm is singular there.
        index: column in the solutions that it was taken from.
    """

    q: Array
    branch: str
    singular: Singular
    index: int

    def __str__(self) -> str:
        flag = f" (singular: {self.singular.name})" if self.singular else ""
        return f"{self.branch}: [{', '.join(f'{x:.6f}' for x in self.q)}]{flag}"


class Step(NamedTuple):
    """How solutions were made from others.

    Attributes:
        how: 'limits', 'turns', 'collision' or 'nearest'.
        parent: the solutions before.
        columns: (..., B) the column of theirs that each column comes from; None: the same.
        amount: tolerance [rad or m] of the limits, margin [m] of collisions.
    """

    how: str
    parent: IKSolutions
    columns: Columns | None = None
    amount: float = 0.0


class IKSolutions(Answer):
    """The solutions of one pose or of a batch of poses, one column a branch.

    The solutions of a single pose are iterated over, counted with ``len`` and picked with ``s[k]``, the valid
    ones only; a batch is indexed like a NumPy array of its poses, ``s[i]``, ``s[2:5]``, ``s[mask]``.
    ``within_limits``, ``turns``, ``collision_free`` and ``nearest`` return solutions, and compose. Solutions
    do not change.
    """

    # Solving one pose takes a fraction of a microsecond. The compiled base keeps what is set below; where the solver
    # itself made it, it makes the arrays of poses, q and info when they are first asked for.
    __slots__ = ()

    def __init__(
        self,
        arm: SolvedArm,
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
            arm: the arm that was solved.
            T: (..., 4, 4) m, the poses.
            q: (..., B, n) rad or m, NaN rows where there is no solution.
            info: (..., B), bit 0: valid, bits 1 to 4: ``Singular``; bit 5 of the first column: other solutions of the
                pose may be missing.
            branches: B names.
            origin: (B,) each column's branch of the family; default: its own index.
            step: how they were made from other solutions; None: solved.
            redundancy: (...) rad or m, each pose's value of the redundancy parameter; None: its default.
        """
        self.arm = arm
        self._poses = T
        self._q = q
        self._info = info
        self._branches = branches
        self._origin = origin
        self.step = step
        self._redundancy = redundancy

    def __reduce__(self) -> tuple[type[IKSolutions], tuple[Any, ...]]:
        whole = (self.arm, self._poses, self._q, self._info, self._branches, self._origin, self.step, self._redundancy)
        return type(self), whole

    @property
    def q(self) -> Array:
        """(..., B, n) rad or m, NaN where there is no solution; angles in (-pi, pi] as the solver gives them."""
        q = self._q
        q.setflags(write=False)
        return q

    @property
    def valid(self) -> NDArray[np.bool_]:
        """(..., B) whether there is a solution."""
        return _frozen((self._info & 1).view(np.bool_))

    @property
    def singular(self) -> NDArray[np.uint8]:
        """(..., B) bits of ``Singular``, 0 where there is no solution."""
        return _frozen(self._info >> np.uint8(1) & np.uint8(15))

    @property
    def certain(self) -> NDArray[np.bool_]:
        """(...) whether the solver is certain that it has found every solution of the pose.

        A closed form is: each of its steps has all of its branches followed. The general solver is where every root of
        its elimination that may be real led to a solution of its own, or where all complex solutions of the pose were
        counted, as many as the arm has at almost every pose. Both are computed in floating point; neither is a proof.
        What filters drop does not change it.
        """
        solved: IKSolutions = self
        while solved.step is not None:
            solved = solved.step.parent
        return _frozen(np.asarray(solved._info[..., 0] & _UNCERTAIN == 0))

    @property
    def branches(self) -> tuple[str, ...]:
        """B names, one a column, the same for every pose."""
        return self._branches

    @property
    def poses(self) -> Array:
        """(..., 4, 4) m, the poses that were solved, in the base link."""
        return _frozen(self._poses.view())

    @property
    def redundancy(self) -> Array | None:
        """(...) rad or m, the redundancy parameter that each pose was solved at; None for an arm without one."""
        parameter = self.arm.redundancy
        if parameter is None:
            return None
        values = np.full(self.shape, parameter.default) if self._redundancy is None else self._redundancy.view()
        return _frozen(values)

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
        """(..., B) each solution's branch, with the turns of an image; unlike ``branches`` also after ``nearest``."""
        if self.step is None:
            return np.broadcast_to(np.array(self._branches, dtype=np.object_), self._info.shape)
        names: NDArray[np.object_] = self.step.parent.names
        if self.step.columns is not None:
            names = np.take_along_axis(names, self.step.columns, axis=-1)
        if self.step.how == "turns":
            names = names.copy()
            for place in np.argwhere(self._info & 1):
                names[tuple(place)] += text.suffix(self._turns_of(self._q[tuple(place)]))
        return names

    @property
    def filters(self) -> tuple[str, ...]:
        """How they were chosen, in order: 'limits', 'turns', 'collision', 'nearest'."""
        return () if self.step is None else (*self.step.parent.filters, self.step.how)

    @property
    def rotary(self) -> NDArray[np.bool_]:
        """(n,) true for joints that turn, false for prismatic ones."""
        return np.array([kind != "prismatic" for kind in self.arm.chain.joint_types], dtype=np.bool_)

    def to_array(self) -> Array:
        """The valid solutions (k, n) of a single pose.

        Raises:
            TypeError: this is a batch.
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

    def __getitem__(self, index: Any) -> Any:
        """Poses of a batch: ``IKSolutions``; of a single pose the solution with this number: ``Solution``."""
        if not self.shape:
            if isinstance(index, int | np.integer):
                column = self._columns("an index")[index]
                return self._solution(column, self.names[column])
            raise TypeError(f"index {index!r}: the solutions of a single pose take a whole number; or use to_array()")
        place = index if isinstance(index, tuple) else (index,)
        if not all(isinstance(i, int | np.integer | slice) for i in place):
            # Whatever NumPy makes of it, applied to the places of the poses so that columns and joints stay whole.
            place = np.unravel_index(np.arange(np.prod(self.shape)).reshape(self.shape)[index], self.shape)
        elif len(place) > len(self.shape):
            raise IndexError(f"{len(place)} indices for a batch of poses of shape {self.shape}; take s[...].q[...]")
        step = self.step
        if step is not None:
            columns = None if step.columns is None else step.columns[place]
            step = step._replace(parent=step.parent[place], columns=columns)
        at = None if self._redundancy is None else np.asarray(self._redundancy[place])
        return IKSolutions(
            self.arm, self._poses[place], self._q[place], self._info[place], self._branches, self._origin, step, at
        )

    def within_limits(self, tol: float = limits.LIMIT_TOLERANCE) -> IKSolutions:
        """The solutions inside the joint limits.

        The solver gives angles in (-pi, pi]. One that is outside is replaced by its +-2 pi image inside the
        limits, the nearest to it: -1 becomes 5.28 for a joint from 0 to 6.28. What has no image inside is
        dropped. A continuous joint is always inside. Images that ``turns`` gave are kept or dropped as they are.

        Args:
            tol: rad or m that a returned value may exceed a limit by; negative: the margin to keep.

        Raises:
            UrdfIkError: ``tol`` is not finite.
        """
        q, inside = limits.nearest_image(self._q, self.arm.limits, self._turning, tol)
        info = np.where(inside, self._info, np.uint8(0))
        return self._derived(q, info, self._branches, Step("limits", self, amount=tol))

    def turns(self, tol: float = limits.LIMIT_TOLERANCE) -> IKSolutions:
        """Every +-2 pi image inside the joint limits: up to 8 x 64 for six joints of +-2 pi.

        The columns of one branch lie together, the image of fewest turns first. A column's name tells its
        turns, '... [q1+360°]', where they are the same for every pose, which they are for a single one,
        else the number of the image; ``names`` and ``Solution.branch`` always tell the turns. A prismatic
        or continuous joint has only the value it has. Filter collisions first: images do not change them.

        Args:
            tol: rad or m that a returned value may exceed a limit by.

        Raises:
            UrdfIkError: ``tol`` is not finite, or there are too many images for one array; see ``iter_turns``.
        """
        if "turns" in self.filters:
            return self
        turned = limits.turns(self._q, self.arm.limits, self.arm.chain.image_turns, tol)
        columns = np.repeat(np.arange(self._q.shape[-2]), len(turned.ranks))
        info = np.where(turned.valid, self._info[..., columns], np.uint8(0))
        before = self._turns_of(self._q)
        apart: Array = self.arm.chain.image_turns
        total = [k * apart[i] + before[..., i, None] for i, k in enumerate(turned.steps)]
        branches = text.turned_branches(self._branches, total, turned.ranks)
        step = Step("turns", self, np.broadcast_to(columns, info.shape), tol)
        return self._derived(turned.q, info, branches, step)

    def iter_turns(self, tol: float = limits.LIMIT_TOLERANCE) -> Iterator[Solution]:
        """The solutions of ``turns()`` for a single pose one by one, ``index`` being the column here.

        Raises:
            TypeError: this is a batch.
        """
        columns, names, turning = self._columns("iter_turns()"), self.names, self._turning
        is_turned = "turns" in self.filters
        for column in columns:
            for q in limits.iter_turns(self._q[column], self.arm.limits, turning, tol):
                name = names[column] if is_turned else names[column] + text.suffix(self._turns_of(q))
                yield Solution(_frozen(q), name, Singular(int(self._info[column]) >> 1 & 15), int(column))

    def nearest(self, q_ref: ArrayLike, weights: ArrayLike | None = None, n: int = 1) -> IKSolutions:
        """The solution nearest to a joint vector, for every pose: one column, or ``n`` of them, nearest first.

        The distance is sqrt(sum of weight * difference^2), the difference of an angle on the circle, at most
        pi. After ``turns`` it is the way the joint has to go, but for continuous joints, which can go round.
        Equally near solutions: the first branch.

        Args:
            q_ref: (n,) or one for each pose (..., n), rad or m.
            weights: (n,) not negative; default: 1 for every joint.
            n: number of columns, at most B.

        Raises:
            JointVectorError: ``q_ref`` or ``weights`` do not fit the arm, or are not finite.
        """
        reference = select.reference(q_ref, self.arm.joint_names, self.shape)
        factors = None if weights is None else select.factors(weights, self.arm.joint_names)
        if not 1 <= n <= self._q.shape[-2]:
            raise UrdfIkError(f"the {n} nearest of {self._q.shape[-2]} columns asked for")
        round_for_ever = np.isinf(self.arm.limits).any(axis=1)
        on_circle = np.where(round_for_ever, self.arm.chain.image_turns, self._turning)
        far = select.distance(self._q, reference, on_circle, factors)
        columns = select.nearest_columns(far, n)
        q = np.take_along_axis(self._q, columns[..., None], axis=-2)
        info = np.take_along_axis(self._info, columns, axis=-1)
        names = tuple("nearest" if k == 0 else f"nearest {k + 1}" for k in range(n))
        return self._derived(q, info, names, Step("nearest", self, columns))

    def collision_free(self, model: CollisionModel | None = None, margin: float = 0.0) -> IKSolutions:
        """The solutions in which the arm collides with nothing.

        Args:
            model: what to ask, ``in_collision`` or ``distance`` of (k, n) joint vectors; default: the arm's
                self-collision, ``arm.collision_model``.
            margin: m that the bodies must stay apart.

        Raises:
            UrdfIkError: ``margin`` is negative or not finite, or the URDF has no collision shapes.
        """
        if not 0.0 <= margin < np.inf:
            raise UrdfIkError(f"a margin of {margin} given; it must be zero or a positive number of m")
        body = self.arm.collision_model if model is None else model
        q, info = self._q.copy(), self._info.copy()
        places = np.nonzero(info & 1)
        vectors = q[places]
        hits = np.asarray(body.distance(vectors) < margin if margin else body.in_collision(vectors), dtype=np.bool_)
        dropped = tuple(place[hits] for place in places)
        q[dropped], info[dropped] = np.nan, 0
        return self._derived(q, info, self._branches, Step("collision", self, amount=margin))

    def explain(self) -> str | list[Any]:
        """Why there is no solution: out of reach, with the number that is, or dropped by limits or collisions.

        Returns:
            A sentence for a single pose, '' if it has a solution; for a batch a list (of lists) of those.
        """
        if not self.shape:
            return text.explanation(self)
        texts = np.empty(self.shape, dtype=object)
        for place in np.ndindex(self.shape):
            texts[place] = text.explanation(self[place])
        return list(texts.tolist())

    def table(self, degrees: bool = False) -> str:
        """The solutions of a single pose as text, a line each; a batch in one sentence."""
        return text.table(self, degrees)

    def __str__(self) -> str:
        return self.table()

    def __repr__(self) -> str:
        filters = "".join(f", {name}" for name in self.filters)
        if self.shape:
            return f"<IKSolutions of {self.arm.name}: poses {self.shape}, {self.count.sum()} solutions{filters}>"
        return f"<IKSolutions of {self.arm.name}: {self.count} in {self._info.shape[-1]} columns{filters}>"

    @property
    def _turning(self) -> Array:
        """(n,) turns between images that are the same solution: 0 for all where images stand in their own columns."""
        turns: Array = self.arm.chain.image_turns * ("turns" not in self.filters)
        return turns

    def _turns_of(self, q: Array) -> Array:
        """Turns (..., n) that joint vectors are away from where the solver gives them, (-pi, pi]."""
        apart = self.arm.chain.image_turns
        turns: Array = apart * np.ceil((q - np.pi * apart) / (limits.TURN * np.where(apart, apart, 1.0)))
        return turns

    def _derived(self, q: Array, info: NDArray[np.uint8], branches: tuple[str, ...], step: Step) -> IKSolutions:
        return IKSolutions(self.arm, self._poses, q, info, branches, None, step, self._redundancy)

    def _columns(self, what: str) -> Columns:
        """Columns of a single pose's valid solutions."""
        if self.shape:
            raise TypeError(
                f"{what} needs a single pose, and these are the solutions of a batch of shape {self.shape}: take one, "
                "s[i], or the arrays s.q, s.valid and s.count"
            )
        return np.flatnonzero(self._info & 1)

    def _solution(self, column: np.intp, name: str) -> Solution:
        return Solution(_frozen(self._q[column]), name, Singular(int(self._info[column]) >> 1 & 15), int(column))


def _frozen(array: NDArray[_Number]) -> NDArray[_Number]:
    """``array``, read-only: a view or a fresh array, never one that somebody else writes to."""
    array.setflags(write=False)
    return array
