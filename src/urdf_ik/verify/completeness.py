"""Completeness checks: the solutions of two independent methods, compared pose by pose.

The first method is the arm's own solver. The second shares only forward kinematics with it: the elimination of Raghavan
and Roth, set up at three places of the loop, and Newton's method from many random starts.

Each pose comes from a planted joint vector. If neither method finds this vector, the report counts it as missed.
"""

from collections import Counter
from dataclasses import astuple, dataclass
from typing import NamedTuple

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import UnsupportedArm
from urdf_ik.kinematics.chain import Chain
from urdf_ik.support import inputs
from urdf_ik.support.angles import largest_apart, shortest
from urdf_ik.support.text import Section
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.support.watch import Progress, Watch
from urdf_ik.typing import Array
from urdf_ik.verify import second_method
from urdf_ik.verify.crosscheck import EXACT, PlantedReport
from urdf_ik.verify.second_method import descend, errors

_CHUNK = 16  # poses at a time
SOLVER, SECOND, BOTH = "the solver", "the second way", "both"
"""Who missed a solution."""

DISTANCES = tuple(10.0**-k for k in range(1, 9))
"""How far [rad] from a singularity the poses near one are, in turn."""

CORNER = 0.0
"""The value in place of that distance for poses with joints at right angles."""

NOISES = (0.0, 1e-9, 1e-6, 1e-4, 1e-2)
"""How far [rad] from right angles their joints are, in turn. Nearer to one, rounding of the pose decides."""

REGULAR = 1e-2
"""Smallest singular value of their Jacobians, lengths as shares of the arm's size."""


def compare(
    arm: Arm, n: int = 200, seed: int = 0, *, time_limit: float | None = None, progress: Progress | None = None
) -> "Completeness":
    """Compare an arm's solver with a second method for all solutions.

    Joint vectors are drawn over the whole torus, whatever the limits: n at random, and n more 1e-1 to 1e-8 rad from a
    singularity, in turn, and n more at right angles, exactly and nearly. Pinocchio makes the poses.

    Args:
        arm: what :func:`urdf_ik.load` returned; six turning joints.
        n: number of random poses, of those near singularities, and of those at right angles.
        seed: the same seed gives the same report; :func:`replay` gives pose i of it again.
        time_limit: s after which no more poses are compared; what was left out did not pass.
        progress: called with (poses done, poses).

    Returns:
        The report; ``report.passed`` says whether nothing speaks against the solver.

    Raises:
        UnsupportedArm: the arm has no solver, or is not one of six turning joints.
        ArgumentError: n is below 1, or ``time_limit`` is no number of seconds.

    Example:
        >>> import urdf_ik
        >>> report = compare(urdf_ik.load("puma_560"), n=1)
        >>> report.passed, [group.solver == group.second for group in report.groups]
        (True, [True, True, True])
    """
    n = inputs.poses(n)
    watch = Watch(time_limit, progress)
    vectors = planted(arm, n, seed)
    sameness = Sameness(arm.chain, arm.cell.reference)
    counts: dict[float | None, Array] = {}
    differences: list[Difference] = []
    for indices in watch.parts(3 * n, _CHUNK):
        T = sameness.reference.pose(vectors[indices.start : indices.stop])
        mine = arm.ik(T)
        q, valid = np.asarray(mine.q), np.asarray(mine.valid)
        for i, index in enumerate(indices):
            near = _distance_to_singularity(n, index)
            theirs = second_method.solutions(arm.chain, T[i], np.random.default_rng([seed, index, 1]))
            answer = sameness.unmatched(T[i], vectors[index], q[i, valid[i]], theirs)
            names = [name for name, is_there in zip(mine.branches, valid[i], strict=True) if is_there]
            found = [(names[k], SECOND, x) for k, x in answer.only_first]
            found += [(f"number {k + 1} of the second way", SOLVER, x) for k, x in answer.only_second]
            found += [("planted", BOTH, vectors[index])] * answer.planted_lost
            numbers = (1, valid[i].sum(), len(theirs), answer.how[DOUBLE_ROOT], answer.how[CONTINUUM], len(found))
            counts[near] = counts.get(near, np.zeros(6, np.intp)) + numbers
            for branch, missed_by, x in found:
                pair = tuple(map(float, vectors[index])), tuple(map(float, x))
                apart, sigma = sameness.to_nearest(x, answer.everything), sameness.sigma_min(x)
                error = sameness.reference.error(x, T[i])
                differences.append(Difference(index, near, *pair, missed_by, branch, apart, sigma, *error))
    order = sorted(counts, key=lambda near: -np.inf if near is None else -near)
    return Completeness(
        **PlantedReport.subject(arm, n, seed),
        solver=arm.structure.family,
        second=second_method.NAME,
        groups=tuple(Group(near, *counts[near].tolist()) for near in order),
        differences=tuple(differences),
        unlooked=watch.unlooked,
    )


def planted(arm: Arm, n: int, seed: int) -> Array:
    """The joint vectors of a comparison, (3 n, 6) [rad]: n at random, n next to singularities, n at right angles."""
    if arm.dof != 6 or not arm.structure.is_6r:
        kinds = ", ".join(arm.chain.joint_types)
        raise UnsupportedArm(f"{arm.name}: this is checked for six turning joints, and this arm has {kinds}")
    return np.array([_plant(arm.chain, n, seed, index) for index in range(3 * n)])


def replay(arm: Arm, n: int, seed: int, index: int) -> tuple[Array, Array]:
    """Pose ``index`` of a comparison once more.

    Args:
        arm: the arm that was compared.
        n: the report's n; poses n to 2 n are those near singularities, those above are at right angles.
        seed: the report's seed.
        index: the difference's index.

    Returns:
        The planted joint vector (6,) [rad] and Pinocchio's pose for it, (4, 4) [m].
    """
    q = _plant(arm.chain, n, seed, index)
    return q, arm.cell.reference.pose(q)


def _distance_to_singularity(n: int, index: int) -> float | None:
    """How far [rad] from a singularity pose ``index`` is planted."""
    if index >= 2 * n:
        return CORNER
    return None if index < n else DISTANCES[(index - n) % len(DISTANCES)]


def _plant(chain: Chain, n: int, seed: int, index: int) -> Array:
    """Joint vector (6,) [rad] of pose ``index``, over the whole torus."""
    rng = np.random.default_rng([seed, index])
    near = _distance_to_singularity(n, index)
    if near == CORNER:
        return _at_right_angles(chain, rng, NOISES[index % len(NOISES)])
    return rng.uniform(-np.pi, np.pi, chain.n) if near is None else _beside_singularity(chain, rng, near)


def _at_right_angles(chain: Chain, rng: np.random.Generator, noise: float) -> Array:
    """A regular joint vector (6,) of quarter turns, up to three joints anywhere; each up to ``noise`` [rad] off."""
    q: Array = rng.uniform(-np.pi, np.pi, chain.n)
    for _ in range(200):
        q[:] = 0.5 * np.pi * rng.integers(-1, 3, chain.n)
        anywhere = rng.permutation(chain.n)[: rng.integers(0, 4)]
        q[anywhere] = rng.uniform(-np.pi, np.pi, len(anywhere))
        J = np.array(chain.jacobian(q))
        J[:3] /= chain.size
        if np.linalg.svd(J, compute_uv=False)[-1] > REGULAR:
            break
    q += noise * rng.uniform(-1.0, 1.0, chain.n)
    return q


def _beside_singularity(chain: Chain, rng: np.random.Generator, near: float) -> Array:
    """A joint vector (6,) at which one joint is ``near`` [rad] from where the Jacobian's determinant changes sign."""
    grid = np.linspace(-np.pi, np.pi, 25)
    q = rng.uniform(-np.pi, np.pi, chain.n)
    for _ in range(200):
        q = rng.uniform(-np.pi, np.pi, chain.n)
        joint = int(rng.integers(chain.n))
        line = np.tile(q, (len(grid), 1))
        line[:, joint] = grid
        values = np.linalg.det(chain.jacobian(line))
        crossings = np.flatnonzero(values[:-1] * values[1:] < 0.0)
        if not len(crossings):
            continue
        i = int(rng.choice(crossings))
        low, high = grid[i], grid[i + 1]
        while (middle := 0.5 * (low + high)) not in (low, high):
            q[joint] = middle
            if np.linalg.det(chain.jacobian(q)) * values[i] > 0.0:
                low = middle
            else:
                high = middle
        q[joint] = middle + near * rng.choice([-1.0, 1.0])
        return q
    return q  # an arm that is singular nowhere, or everywhere


def _in_words(near: float | None) -> str:
    """Where poses were planted."""
    if near is None:
        return "random"
    return f"{near:.0e} rad from a singularity" if near else "at right angles"


@dataclass(frozen=True)
class Group:
    """The poses at one distance from a singularity.

    Attributes:
        near: how far [rad] from a singularity they were planted; None: random ones; 0: at right angles.
        poses: how many.
        solver: solutions that the arm's solver found.
        second: solutions that the second way found.
        double_roots: solutions of one that are a double root of the other.
        continua: representatives of a continuum that the other represents elsewhere.
        differences: solutions that only one of them has, and planted joint vectors that neither has.
    """

    near: float | None
    poses: int
    solver: int
    second: int
    double_roots: int
    continua: int
    differences: int


@dataclass(frozen=True)
class Difference:
    """One solution that not both ways found.

    Attributes:
        index: number of the pose.
        near: how far [rad] from a singularity it was planted; None: a random one; 0: at right angles.
        planted: (6,) rad, the joint vector that made it.
        q: (6,) rad, the solution.
        missed_by: ``SOLVER``, ``SECOND``, or ``BOTH``, which is said of planted joint vectors.
        branch: its branch, or what else it is called.
        nearest: largest angle [rad] to the nearest other solution of the pose; infinite where there is none.
        sigma_min: smallest singular value of the Jacobian there, lengths as shares of the arm's size.
        position_error: [m] under Pinocchio.
        rotation_error: [rad] under Pinocchio.
    """

    index: int
    near: float | None
    planted: tuple[float, ...]
    q: tuple[float, ...]
    missed_by: str
    branch: str
    nearest: float
    sigma_min: float
    position_error: float
    rotation_error: float

    @property
    def counts(self) -> bool:
        """Whether it speaks against the solver: a solution that it missed, or one that does not hold."""
        return self.missed_by != SECOND or max(self.position_error, self.rotation_error) > EXACT

    def place(self) -> str:
        """The pose, in words."""
        where = _in_words(self.near)
        return f"pose {self.index}, {where}, planted q = [{', '.join(map(repr, self.planted))}]"

    def __str__(self) -> str:
        return (
            f"missed by {self.missed_by}: {self.branch}, nearest other {self.nearest:.1e} rad, "
            f"sigma_min {self.sigma_min:.1e}, error {self.position_error:.1e} m, {self.rotation_error:.1e} rad, "
            f"q = [{', '.join(map(repr, self.q))}]"
        )


@dataclass(frozen=True, repr=False)
class Completeness(PlantedReport):
    """Two ways to all solutions of an arm, compared.

    Attributes:
        robot: the robot's name.
        base: base link.
        tip: tip link.
        joint_names: joints of a joint vector, base to tip.
        n: number of random poses, of poses near singularities, and of poses at right angles.
        seed: seed of the joint vectors that made them.
        reference: who measured the errors, with the version.
        solver: the arm's solver.
        second: what it was compared with.
        groups: counts by distance from a singularity, random ones first.
        differences: every one.
        unlooked: what the time limit left out; '' where every pose was compared.
    """

    solver: str
    second: str
    groups: tuple[Group, ...]
    differences: tuple[Difference, ...]
    unlooked: str = ""

    @property
    def faulty(self) -> bool:
        """Whether something speaks against the solver.

        It must have every solution that the second way found and every planted joint vector, and what only it has must
        reach the pose under Pinocchio. What the second way missed is reported, but no fault of the solver.
        """
        return any(difference.counts for difference in self.differences)

    def title(self) -> str:
        """The arm, the two ways, and who measured them."""
        arm = f"{self.robot}, {self.base} to {self.tip}"
        title = f"{arm}: all solutions by two ways, seed {self.seed}, {self.reference}"
        return f"{title}\nsolver:     {self.solver}\nsecond way: {self.second}"

    def sections(self) -> tuple[Section, ...]:
        """A table with a row for each distance from a singularity."""
        header = ("poses", "number", "solver", "second way", "one double root", "one continuum", "differences")
        rows = tuple((_in_words(group.near), *map(str, astuple(group)[1:])) for group in self.groups)
        return (Section("", header, rows, left=("poses",)),)

    def lines(self) -> tuple[str, ...]:
        """Every difference under its pose, those that speak against the solver first."""
        lines, pose = [], None
        for difference in sorted(self.differences, key=lambda d: (not d.counts, d.index)):
            if (difference.counts, difference.index) != pose:
                pose = difference.counts, difference.index
                lines.append(difference.place())
            lines.append(f"    {difference}")
        return (*lines, "") if lines else ()

    def summary(self) -> str:
        """The number of poses, and who missed how many solutions."""
        missed = [difference.missed_by for difference in self.differences]
        parts = [f"{missed.count(who)} missed by {who}" for who in (SOLVER, SECOND, BOTH) if who in missed]
        return f"{sum(group.poses for group in self.groups)} poses, {', '.join(parts) or 'no difference'}"


DOUBLE_ROOT, CONTINUUM = "double root", "continuum"
"""How two joint vectors that differ may be one solution."""

SAME = 1e-6
ROUNDING = 1e-13
LOOSEST = 1e-3
"""Tolerances of the first rule [rad]."""

NEIGHBOURS = 1e-2
"""Vectors further apart than this in a joint [rad] are no double root."""

STEP, STEPS = 0.02, 2000
"""Length [rad] and greatest number of steps of a walk along a continuum, each way."""


class _Unmatched(NamedTuple):
    """Solutions that only one of two answers to a pose has.

    Attributes:
        only_first: (row, joint vector) of each solution that only the first answer has.
        only_second: the same for the second answer.
        planted_lost: whether neither answer has the planted joint vector.
        how: number of solutions that the other answer has as a ``DOUBLE_ROOT``, and of those on one ``CONTINUUM``.
        everything: (k, 6) both answers and the planted joint vector.
    """

    only_first: list[tuple[int, Array]]
    only_second: list[tuple[int, Array]]
    planted_lost: bool
    how: Counter[str]
    everything: Array


class Sameness:
    """Decides whether joint vectors are one solution; lengths are shares of the arm's size.

    Two joint vectors of one pose, both polished on the arm as written, count as one solution if

    - they differ by no more than rounding of the pose explains: 1e-6 rad, plus 1e-13 over the Jacobian's smallest
      singular value, up to 1e-3 rad;
    - or the arm is still in the pose half way between them, to the solvers' tolerance ``fold``: a double root;
    - or both lie on one continuum of solutions: a walk from the one along the Jacobian's null direction, with the arm
      in the pose to ``fold`` at every step, leads to the other. The first step is 0.02 rad, too long for an isolated
      solution to stay in the pose, however near a singularity it lies.

    A joint vector that misses the pose by more than 1e-9 under Pinocchio is not a solution, and always a difference.

    Args:
        chain: the arm's chain.
        reference: Pinocchio's model of it.
        fold: pose error up to which the arm counts as in the pose, between two roots and along a continuum.
    """

    def __init__(self, chain: Chain, reference: Reference, fold: float = DEFAULT.fold) -> None:
        self.reference = reference
        self.singular = max(DEFAULT.singular, fold / STEP)
        """Smallest singular value below which a solution may be one of a continuum."""
        self._chain = chain
        self._fold = fold

    def unmatched(self, T: Array, planted: Array, first: Array, second: Array) -> _Unmatched:
        """Compare two answers (k, 6), (m, 6) to the pose T (4, 4), made of a planted joint vector (6,)."""
        alone: list[list[tuple[int, Array]]] = [[], []]
        hows: Counter[str] = Counter()
        for mine, theirs, only in ((first, second, alone[0]), (second, first, alone[1])):
            position, rotation = self.reference.errors(mine, T)
            for i, q in enumerate(mine):
                # A joint vector that misses the pose is not a solution, even if polishing would make it one.
                how = self.has(T, q, theirs) if max(position[i], rotation[i]) <= EXACT else ""
                hows[how] += 1
                if not how:
                    only.append((i, q))
        answered = np.concatenate([first, second])
        lost = not self.has(T, planted, answered)
        return _Unmatched(alone[0], alone[1], lost, hows, np.concatenate([answered, planted[None]]))

    def sigma_min(self, q: Array) -> float:
        """Smallest singular value of the Jacobian at q (6,)."""
        return float(np.linalg.svd(self._jacobian(q), compute_uv=False)[-1])

    def to_nearest(self, q: Array, others: Array) -> float:
        """Largest angle [rad] from q to the nearest of the others that is not q itself; infinite without one."""
        far = largest_apart(others, q)
        return float(far[far > SAME].min(initial=np.inf))

    def has(self, T: Array, q: Array, others: Array) -> str:
        """How q (6,) is one of the others (k, 6), solutions of the pose T (4, 4); '' where it is none of them."""
        if (largest_apart(others, q) <= SAME).any():
            return "equal"
        q = descend(self._chain, T, q[None], 20, 0.0)[0][0]
        tolerance = SAME + min(ROUNDING / max(self.sigma_min(q), 1e-300), LOOSEST)
        others = descend(self._chain, T, others, 20, 0.0)[0]
        far = largest_apart(others, q)
        if (far <= tolerance).any():
            return "equal"
        near = others[far < NEIGHBOURS]
        if (errors(self._chain, T, q + 0.5 * shortest(near - q))[1] <= self._fold).any():
            return DOUBLE_ROOT
        regular = self.sigma_min(q) > self.singular or not len(others)
        return CONTINUUM if not regular and self._on_one_continuum(T, q, others) else ""

    def _on_one_continuum(self, T: Array, q: Array, others: Array) -> bool:
        """Whether a walk along the continuum through q, if there is one, meets one of the others."""
        for sign in (1.0, -1.0):
            here, ahead = q, sign * np.linalg.svd(self._jacobian(q))[2][-1]
            for _ in range(STEPS):
                there = here + STEP * ahead
                if not self._correct(T, there):
                    break
                ahead = shortest(there - here)
                ahead /= np.linalg.norm(ahead)
                here = there
                if (largest_apart(others, here) < STEP).any():
                    return True
                if np.abs(shortest(here - q)).max() < 0.5 * STEP:
                    return False  # all the way round
        return False

    def _correct(self, T: Array, q: Array) -> bool:
        """Move q (6,), in place, back into the pose by steps across the continuum; False if the move is too long."""
        start = q.copy()
        for _ in range(8):
            (e,), (error,) = errors(self._chain, T, q[None])
            if error <= self._fold:
                return bool(np.abs(q - start).max() < 0.25 * STEP)
            # The correction leaves out the Jacobian's null direction.
            q += np.linalg.pinv(self._jacobian(q), rcond=10.0 * DEFAULT.singular) @ e
        return False

    def _jacobian(self, q: Array) -> Array:
        J = np.array(self._chain.jacobian(q))
        J[:3] /= self._chain.size
        return J
