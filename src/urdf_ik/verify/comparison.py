"""Comparisons of two arms or of two URDFs of one arm: the differences, and their effect on solutions and tool.

They answer the questions before a swap: another arm, another tool, a calibrated copy of a nominal arm. Each arm solves
for the part of a pose that it controls (see ``Arm.task``); Pinocchio computes where its tip really is. The fields of a
comparison are in m and rad; its text shows mm and degrees.
"""

import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from urdf_ik.arm import Arm, Robot, loaded
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import UrdfIkError
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.ik.solutions.branch_names import short
from urdf_ik.model.poses import as_pose_array, check_poses
from urdf_ik.support import inputs
from urdf_ik.support.angles import shortest, shown, unit_of
from urdf_ik.support.report import Report
from urdf_ik.support.text import Section
from urdf_ik.support.tolerances import DEFAULT as TOLERANCES
from urdf_ik.typing import Array
from urdf_ik.verify.alignment import Alignment, aligned
from urdf_ik.verify.description import Description, described, matrix, parameters_of
from urdf_ik.verify.differences import (
    DEFAULT,
    Difference,
    Tolerance,
    apart,
    between_axes,
    differences,
    ignored,
    moved,
    order_of,
    summed,
)
from urdf_ik.verify.sampling import redundancy_at, solutions_of

_SAMPLES = 20_000
_ROUNDING = 1e-9  # rad, m: an imperfection that is no more than rounded decimals
# 'solution 3', 'further 1': such a number says nothing about the posture, unlike 'elbow up'.
_NUMBERED = re.compile(r"\d+$")


def compare(
    a: Robot,
    b: Robot,
    n: int = 200,
    seed: int = 0,
    *,
    poses: Any = None,
    tolerance_mm: float | None = None,
    tolerance_deg: float | None = None,
    ignore: str | Iterable[str] = (),
    align: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> "Comparison":
    """Compare two arms.

    Each arm draws ``n`` joint vectors within its limits; both arms solve all poses that these make. Joints are paired
    by name if both arms have the same names, else by their order from base to tip. If the numbers of joints differ, or
    one arm cannot be solved, some parts of the comparison are skipped; ``notes`` lists them.

    Args:
        a: the first arm, such as the nominal one, or what :func:`urdf_ik.load` takes.
        b: the second arm, such as the calibrated one.
        n: number of poses that each arm makes.
        seed: the same seed gives the same comparison.
        poses: (..., 4, 4) m, further poses that both arms solve.
        tolerance_mm: greatest difference of lengths that is ignored [mm]; default: 1e-6.
        tolerance_deg: greatest difference of angles that is ignored [deg]; default: 6e-8.
        ignore: kinds of differences that do not count: 'limits', 'collisions', 'visuals', 'names'.
        align: whether base frame, tip frame, joint zeros and signs of B are fitted to A first, as for models of one arm
            by two authors; names do not count then. ``alignment`` says what was fitted.
        progress: called with (steps done, steps).

    Returns:
        The comparison; ``print`` it, or take its fields.

    Raises:
        ArgumentError: n is below 1, a tolerance is negative, or a kind cannot be ignored.
        PoseError: one of ``poses`` is invalid.

    Example:
        >>> import urdf_ik
        >>> a, b = urdf_ik.load("zyyzyz_6r"), urdf_ik.load("dh_6r")
        >>> len(compare(a, b, n=10).structure) > 0
        True
    """
    a, b = loaded(a), loaded(b)
    n = inputs.poses(n)
    notes: list[str] = []
    tolerance, skipped = Tolerance.read(tolerance_mm, tolerance_deg), ignored(ignore)
    own = None if poses is None else check_poses(as_pose_array(poses)).reshape(-1, 4, 4)
    written, alignment = b, None
    if align:
        b, alignment = aligned(a, b)
        skipped |= {"names"}
    ours, theirs = described(a), described(b)
    order, reason = _order(ours, theirs)
    if reason:
        notes.append(f"axes, limits, joint differences and the tool error: {reason}")
    vectors = _drawn(a, n, seed)
    answers: list[_Answers] = []
    try:
        for maker, q in ((a, vectors), (b, _drawn(b, n, seed))):
            answers.append(_answers(a, b, maker.cell.reference.pose(q), maker, q))
            if progress is not None:
                progress(len(answers), 2)
    except UrdfIkError as error:
        notes.append(f"reach, numbers of solutions and branches: {error}")
    solved = len(answers) == 2
    reach = []
    if solved:
        notes += _cautions(a, b)
        reach = [answers[0].reach("A"), answers[1].reach("B")]
        if own is not None and len(own):
            answers.append(_answers(a, b, own))
            reach.append(answers[2].reach("you"))
    # The tool error counts where the arm is going to be used: at poses of the caller's, if there are any.
    found = [each.a for each in (*answers[2:], *answers[:1]) if each.a.valid.any()]
    tried = found[0].q[found[0].valid] if found else vectors
    axes = () if order is None else _axes(a, b, order)
    signs = np.array([-1.0 if axis.flipped else 1.0 for axis in axes])
    differing = differences(ours, theirs, tolerance, frames=not align)
    return Comparison(
        differences=tuple(difference for difference in differing if difference.kind not in skipped),
        a=_side(a),
        b=_side(written),
        n=n,
        seed=seed,
        structure=_structure(a, b),
        axes=axes,
        tip=apart(a.fk(np.zeros(a.dof)), b.fk(np.zeros(b.dof))),
        limits=tuple(
            _LimitChange(a.joint_names[i], b.joint_names[k], tuple(a.limits[i].tolist()), tuple(b.limits[k].tolist()))
            for i, k in enumerate(order or ())
        ),
        farthest=(_farthest(a, seed), _farthest(b, seed)),
        reach=tuple(reach),
        branches=answers[0].branches(order, signs) if solved and order is not None else (),
        tool=None if order is None else _tool_error(a.cell.reference, b.cell.reference, tried, order),
        notes=tuple(notes),
        alignment=alignment,
    )


def _side(arm: Arm) -> "_Side":
    prismatic = tuple(arm.chain.prismatic.tolist())
    return _Side(arm.name, arm.model.source, arm.base, arm.tip, arm.joint_names, prismatic)


def _structure(a: Arm, b: Arm) -> tuple["_Fact", ...]:
    """Structural properties of both arms, and the relations between axes that differ."""

    def known(arm: Arm) -> dict[str, str]:
        structure = arm.structure
        kinds = "".join("P" if slides else "R" for slides in arm.chain.prismatic)
        words = {None: "not known", False: "no"}
        facts = {
            "joints": f"{arm.dof} ({kinds})",
            "family": structure.family or "none that is solved",
            "controls": arm.task,
            "solutions at most": str(structure.max_solutions),
            "cuspidal": words[structure.cuspidal],
        }
        if structure.family:
            facts["exact"] = "yes" if structure.is_exact or structure.is_general else _off(arm)
        if arm.redundancy is not None:
            facts["free"] = f"{arm.redundancy.kind}, {arm.redundancy.joint}"
        return facts

    def related(arm: Arm) -> dict[str, str]:
        out = {}
        for relation in (*arm.structure.triples, *arm.structure.pairs):
            axes, _, what = str(relation).partition(" are " if " are " in str(relation) else " meet ")
            out[axes] = what if " are " in str(relation) else f"meet {what}"
        return out

    facts, relations = (
        [_Fact(what, left.get(what, "-"), right.get(what, "-")) for what in {**left, **right}]
        for left, right in ((known(a), known(b)), (related(a), related(b)))
    )
    return (*facts, *(fact for fact in relations if not fact.same))


def _off(arm: Arm) -> str:
    angle, distance = arm.structure.imperfection
    if angle <= _ROUNDING and distance <= _ROUNDING:
        return arm.structure.imperfection_in_words()
    return f"off by {angle:.2g} rad, {distance:.2g} m"


def _axes(a: Arm, b: Arm, order: list[int]) -> tuple["_AxisChange", ...]:
    out = []
    for i, k in enumerate(order):
        ours, theirs = (a.chain.points[i], a.chain.H[i]), (b.chain.points[k], b.chain.H[k])
        distance, angle = between_axes(ours, theirs, bool(a.chain.prismatic[i]))
        flipped = angle > np.pi - TOLERANCES.near_angle
        out.append(_AxisChange(a.joint_names[i], b.joint_names[k], angle, distance, flipped))
    return tuple(out)


def _farthest(arm: Arm, seed: int) -> float:
    """Greatest distance of the tip from the base's origin over sampled joint vectors."""
    return float(np.linalg.norm(arm.fk(_drawn(arm, _SAMPLES, seed))[:, :3, 3], axis=1).max())


def _drawn(arm: Arm, n: int, seed: int) -> Array:
    """Joint vectors (n, dof) within the limits."""
    lower, upper = arm.cell.reference.ranges.T
    return np.random.default_rng(seed).uniform(lower, upper, (n, arm.dof))


def _answers(a: Arm, b: Arm, T: Array, maker: Arm | None = None, q: Array | None = None) -> "_Answers":
    """Solutions of both arms for poses T (m, 4, 4), as far as each task controls them."""
    same = [maker is not None and (arm is maker or _same_parameter(arm, maker)) for arm in (a, b)]
    values = None if maker is None or q is None else redundancy_at(maker, q)
    return _Answers(*(solutions_of(arm, T, values if own else None) for arm, own in zip((a, b), same, strict=True)))


@dataclass(frozen=True, eq=False)
class _Answers:
    """The solutions of two arms for the same poses."""

    a: IKSolutions
    b: IKSolutions

    def reach(self, made_by: str) -> "Reach":
        """How many poses each has a solution for, and how many solutions."""
        counts = self.a.count, self.b.count
        within = self.a.within_limits().count, self.b.within_limits().count
        reached, inside = ((int((a > 0).sum()), int((b > 0).sum())) for a, b in (counts, within))
        every = int(counts[0].sum()), int(counts[1].sum())
        return Reach(made_by, len(counts[0]), reached, inside, every, int((counts[0] == counts[1]).sum()))

    def branches(self, order: list[int], signs: Array) -> tuple["BranchChange", ...]:
        """Every branch of A that has solutions, against B."""
        theirs = {name: k for k, name in enumerate(self.b.branches) if not _NUMBERED.search(name)}
        theirs = theirs if (signs > 0.0).all() else {}
        out = []
        for k, name in enumerate(self.a.branches):
            rows = np.flatnonzero(self.a.valid[:, k])
            if not len(rows):
                continue
            mine, others = self.a.q[rows, k], self.b.q[rows][..., order]
            if name in theirs:
                column = np.full(len(rows), theirs[name])
            else:
                far = self._gap(mine[:, None], others * signs).max(axis=-1)
                column = np.argmin(np.where(self.b.valid[rows], far, np.inf), axis=1)
            gaps = self._gap(mine, others[np.arange(len(rows)), column])
            gaps = gaps[~np.isnan(gaps).any(axis=1)]  # where B has that solution
            nothing = np.full((1, len(order)), np.nan)
            spread = (tuple(of(gaps if len(gaps) else nothing, axis=0).tolist()) for of in (np.median, np.max))
            matched = "name" if name in theirs else "nearest"
            out.append(BranchChange(name, matched, len(gaps), len(rows) - len(gaps), *spread))
        return tuple(out)

    def _gap(self, q: Array, other: Array) -> Array:
        """Difference of each joint (..., n), that of an angle on the circle."""
        difference = np.abs(q - other)
        return np.where(self.a.rotary, np.abs(shortest(difference)), difference)


def _order(a: Description, b: Description) -> tuple[list[int] | None, str]:
    """B's joints in the order of A's, or None and the reason why they are not the same joints."""
    if a.dof != b.dof:
        return None, f"A has {a.dof} joints and B has {b.dof}"
    order = list(order_of(a, b))
    for i, k in enumerate(order):
        slide = [side.joint_types[j] == "prismatic" for side, j in ((a, i), (b, k))]
        if slide[0] != slide[1]:
            kinds = ["slides" if each else "turns" for each in slide]
            return None, f"joint {a.joint_names[i]!r} of A {kinds[0]}, joint {b.joint_names[k]!r} of B {kinds[1]}"
    return order, ""


def _cautions(a: Arm, b: Arm) -> list[str]:
    """Cautions about the comparison of the numbers of solutions."""
    out = []
    if a.task != b.task:
        out.append(f"like with like: A is asked for the {a.task}, B for the {b.task}, which is what each controls")
    elif a.dof != b.dof and min(a.dof, b.dof) < 6:
        out.append("all poses alike: with fewer than six joints an arm reaches only those of its own kind")
    for letter, arm, other in (("A", a, b), ("B", b, a)):
        if arm.redundancy is not None:
            own = "the one that made the pose" + ("" if _same_parameter(arm, other) else ", of other poses the default")
            out.append(
                f"all solutions of {letter}: with {arm.dof} joints a pose has infinitely many; counted are those at "
                f"one value of the redundancy parameter, {own}"
            )
    return out


def _tool_error(a: Reference, b: Reference, q: Array, order: list[int]) -> "ToolError | None":
    """Difference between the tip poses of A and B at joint vectors ``q`` (m, n) of A; None without one."""
    if not len(q):
        return None
    position, rotation = b.errors(q[:, np.argsort(order)], a.pose(q))
    return ToolError(len(q), _spread(position), _spread(rotation), tuple(q[int(np.argmax(position))].tolist()))


def _same_parameter(a: Arm, b: Arm) -> bool:
    one, other = parameters_of(a), parameters_of(b)
    return bool(one) and one == other


def _spread(values: Array) -> tuple[float, float, float]:
    """Median, 95th percentile, greatest."""
    return float(np.median(values)), float(np.percentile(values, 95.0)), float(values.max())


@dataclass(frozen=True)
class _Side:
    """One of the two arms.

    Attributes:
        robot: the robot's name.
        source: where its URDF was read from.
        base: base link.
        tip: tip link.
        joint_names: base to tip.
        prismatic: (n,) true for joints that slide.
    """

    robot: str
    source: str
    base: str
    tip: str
    joint_names: tuple[str, ...]
    prismatic: tuple[bool, ...]


@dataclass(frozen=True)
class _Fact:
    """One thing that is known of both arms' structure, in words."""

    what: str
    a: str
    b: str

    @property
    def same(self) -> bool:
        """Whether it is the same for both."""
        return self.a == self.b


@dataclass(frozen=True)
class _AxisChange:
    """How a joint axis of B lies to that of A at q = 0, each in its own base.

    Attributes:
        joint: the joint's name in A.
        joint_b: its name in B.
        angle: between the directions, 0 to pi [rad].
        distance: of the axis of B from the origin of A's joint [m]; 0 for a joint that slides, whose axis has no place.
        flipped: whether the direction is the opposite one, so that the joint turns the other way.
    """

    joint: str
    joint_b: str
    angle: float
    distance: float
    flipped: bool


@dataclass(frozen=True)
class _LimitChange:
    """The limits of a joint, lower and upper [rad or m], infinite where there is no limit."""

    joint: str
    joint_b: str
    a: tuple[float, float]
    b: tuple[float, float]


@dataclass(frozen=True)
class Reach:
    """Solutions of both arms for the same poses.

    Attributes:
        made_by: 'A' or 'B', the arm whose joint vectors, drawn within its limits, made the poses; 'you' for given ones.
        poses: number of poses.
        solved: number of poses with a solution, for A and for B.
        within_limits: number of poses with a solution within the limits, for A and for B.
        solutions: number of solutions over all poses, for A and for B.
        same_number: number of poses for which both arms have the same number of solutions.
    """

    made_by: str
    poses: int
    solved: tuple[int, int]
    within_limits: tuple[int, int]
    solutions: tuple[int, int]
    same_number: int


@dataclass(frozen=True)
class BranchChange:
    """Joint values of one branch of A against those of B, over the poses that A's joint vectors made.

    Attributes:
        branch: its name in A.
        matched: 'name' where B has a branch of that name and no axis is flipped, else 'nearest': of each pose's
            solutions in B the nearest, joints that turn the other way taken with the other sign.
        poses: number of poses compared.
        unmatched: number of solutions of A without a counterpart in B.
        median: (n,) rad or m, median difference of each joint, for angles on the circle; NaN if none was compared.
        worst: (n,) rad or m, greatest difference of each joint, likewise.
    """

    branch: str
    matched: str
    poses: int
    unmatched: int
    median: tuple[float, ...]
    worst: tuple[float, ...]


@dataclass(frozen=True)
class ToolError:
    """Difference between the tip poses of A and B at the same joint vectors, both computed by Pinocchio.

    Attributes:
        joint_vectors: how many were tried: A's solutions of the poses that it made.
        position: median, 95th percentile and worst [m].
        rotation: the same [rad].
        q: (n,) rad or m, the joint vector of the worst position.
    """

    joint_vectors: int
    position: tuple[float, float, float]
    rotation: tuple[float, float, float]
    q: tuple[float, ...]


@dataclass(frozen=True, repr=False)
class Comparison(Report):
    """Two arms, compared; ``print`` shows it as tables.

    Attributes:
        differences: what is different beyond rounding, or the tolerances given, in words.
        a: the first arm.
        b: the second arm.
        n: number of poses that each of them made.
        seed: seed of the joint vectors.
        structure: what is known of their axes and how they are solved.
        axes: joint by joint; empty where their numbers differ.
        tip: distance [m] and angle [rad] between the tips at q = 0, each in its own base.
        limits: joint by joint; empty where their numbers differ.
        farthest: greatest distance [m] of the tip from the base's origin that sampled joint vectors show, of A and B.
        reach: the poses that A made, and those that B made; empty where one of them cannot be solved.
        branches: joint values, branch by branch; empty where they cannot be compared.
        tool: what happens when A's joint vectors are used on B; None where they cannot be.
        notes: what was not compared, and why.
        alignment: what was fitted first; None where nothing was. All else is about B after it.
    """

    JUDGES: ClassVar[bool] = False

    differences: tuple[Difference, ...]
    a: _Side
    b: _Side
    n: int
    seed: int
    structure: tuple[_Fact, ...]
    axes: tuple[_AxisChange, ...]
    tip: tuple[float, float]
    limits: tuple[_LimitChange, ...]
    farthest: tuple[float, float]
    reach: tuple[Reach, ...]
    branches: tuple[BranchChange, ...]
    tool: ToolError | None
    notes: tuple[str, ...]
    alignment: Alignment | None = None

    @property
    def same(self) -> bool:
        """Whether both are the same arm, to rounding or the tolerances given."""
        return not self.differences

    @property
    def faulty(self) -> bool:
        """Whether they differ."""
        return not self.same

    def to_dict(self) -> dict[str, Any]:
        """The comparison as plain lists, numbers and text; numbers that are not finite are the text 'inf', 'nan'."""
        content = super().to_dict()
        if self.alignment is None:
            del content["alignment"]
        return {"same": self.same, "units": {"length": "m", "angle": "rad"}, **content}

    def title(self) -> str:
        """Both arms, a line each."""
        sides = (("A", self.a), ("B", self.b))
        return "\n".join(f"{letter}: {side.robot}, {side.base} to {side.tip} ({side.source})" for letter, side in sides)

    def sections(self) -> tuple[Section, ...]:
        """The tables: tool error, structure, frames, reach, branches."""
        tables = [] if self.alignment is None else [_alignment_table(self, self.alignment)]
        tables += [_tool_table(self.tool, self.a.prismatic)] if self.tool is not None else []
        tables += [_structure_table(self), _frames_table(self)]
        tables += [_reach_table(self)] if self.reach else []
        tables += [_branches_table(self)] if self.branches else []
        return tuple(tables)

    def lines(self) -> tuple[str, ...]:
        """The differences, and what was not compared."""
        return (*summed(self.differences), *(f"not compared: {note}" for note in self.notes))

    def summary(self) -> str:
        """How far the tips are apart, and the number of differences."""
        count = len(self.differences)
        words = f"{count} difference{'' if count == 1 else 's'}" if count else "same to rounding"
        matters = count and self.tool is not None and self.tool.position[2] > DEFAULT.distance
        if self.tool is None or not (matters or self.alignment is not None):
            return words
        (median, _, worst), angle = self.tool.position, self.tool.rotation[2]
        after = "after aligning, " if self.alignment is not None else ""
        apart = f"{_mm(median)} mm apart in the median, at most {_mm(worst)} mm and {_deg(angle)} deg"
        return f"{after}the tips are {apart}; {words}"


def _alignment_table(comparison: Comparison, found: Alignment) -> Section:
    ends = (("base", found.base), ("tip", found.tip))
    lines = tuple(f"{what}: {moved(*apart(np.eye(4), matrix(row)))}" for what, row in ends)
    sides = zip(comparison.a.joint_names, comparison.b.joint_names, comparison.a.prismatic, strict=True)
    rows = tuple(
        (_pair(a, b), "negated" if sign < 0.0 else "", *((_mm(zero), "mm") if slides else (_deg(zero), "deg")))
        for (a, b, slides), sign, zero in zip(sides, found.signs, found.zeros, strict=True)
    )
    title = "aligned first: B in the conventions of A"
    return Section(title, ("joint", "sign", "zero", "unit"), rows, lines, ("joint",))


def _structure_table(comparison: Comparison) -> Section:
    facts = comparison.structure
    differ = sum(not fact.same for fact in facts)
    title = f"structure: {f'{differ} of {len(facts)} facts differ' if differ else 'the same'}"
    rows = tuple((fact.what, fact.a, fact.b, "" if fact.same else "differs") for fact in facts)
    return Section(title, ("", "A", "B", " "), rows, left=("", "A", "B", " "))


def _frames_table(comparison: Comparison) -> Section:
    distance, angle = comparison.tip
    same = distance <= DEFAULT.distance and angle <= DEFAULT.angle
    apart = "at the same place" if same else f"{_mm(distance)} mm and {_deg(angle)} deg apart"
    farthest = "farthest sampled tip from the base: A {:.4f} m, B {:.4f} m".format(*comparison.farthest)
    rows = tuple(
        (_pair(c.joint, c.joint_b), _deg(c.angle), _mm(c.distance), "flipped" if c.flipped else "")
        for c in comparison.axes
        if c.angle > DEFAULT.angle or c.distance > DEFAULT.distance
    )
    moved = f": {len(rows)} of {len(comparison.axes)} axes moved" if rows else ": no axis moved"
    title, remarks = f"frames{moved if comparison.axes else ''}", (f"tip at q = 0: {apart}", farthest)
    return Section(title, ("joint", "turned [deg]", "moved [mm]", ""), rows, remarks, left=("joint", ""))


def _reach_table(comparison: Comparison) -> Section:
    rows = []
    for r in comparison.reach:
        for k, letter in enumerate("AB"):
            counts = map(str, (r.solved[k], r.within_limits[k], r.solutions[k]))
            mean, same = f"{r.solutions[k] / r.poses:.2f}", "" if k else str(r.same_number)
            maker = "yours" if r.made_by == "you" else r.made_by
            rows.append((f"{r.poses} poses of {maker}", letter, *counts, mean, same))
    header = ("asked for", "arm", "reached", "within limits", "solutions", "a pose", "same in both")
    return Section("reach and solutions", header, tuple(rows), left=("asked for", "arm"))


def _branches_table(comparison: Comparison) -> Section:
    slides = comparison.a.prismatic
    joints = [f"q{i + 1}{' [mm]' if sliding else ''}" for i, sliding in enumerate(slides)]
    scale = np.where(slides, 1e3, 180.0 / math.pi)
    several = len({branch.matched for branch in comparison.branches}) > 1
    rows = []
    for b in comparison.branches:
        medians = ("-" if math.isnan(value) else f"{value:.3g}" for value in np.multiply(b.median, scale))
        matched = (b.matched,) if several else ()
        rows.append((short(b.branch), *matched, str(b.poses), str(b.unmatched), *medians))
    worst = [np.nan_to_num(b.worst * scale) for b in comparison.branches]
    row, k = np.unravel_index(int(np.argmax(worst)), np.shape(worst))
    branch = short(comparison.branches[row].branch)
    farthest = f"{worst[row][k]:.4g} {'mm' if slides[k] else 'deg'}, q{k + 1} of {branch}"
    how = "" if several else f", matched by {comparison.branches[0].matched}"
    title = f"joint differences by branch [deg]: medians over {comparison.n} poses of A{how}"
    header = ("branch", *("matched by",) * several, "poses", "lost", *joints)
    return Section(title, header, tuple(rows), (f"worst: {farthest}",), left=("branch", "matched by"))


def _tool_table(tool: ToolError, slides: tuple[bool, ...]) -> Section:
    rows = (("position [mm]", *map(_mm, tool.position)), ("rotation [deg]", *map(_deg, tool.rotation)))
    q = ", ".join(f"{value:.6g}" for value in np.where(slides, tool.q, shown(np.asarray(tool.q))))
    worst = (f"worst at q = [{q}] ({unit_of()}, m)",) * any(tool.position)
    title = f"tool error when A's joint vectors ({tool.joint_vectors}) are used on B"
    return Section(title, ("", "median", "95 %", "worst"), rows, worst, left=("",))


def _pair(a: str, b: str) -> str:
    return a if a == b else f"{a} / {b}"


def _mm(value: float) -> str:
    return _number(1000.0 * value)


def _deg(value: float) -> str:
    return _number(math.degrees(value))


def _number(value: float) -> str:
    """Four digits after the point, fewer for what is exact; rounding errors in the form 1e-13."""
    if math.isnan(value):
        return "-"
    if value == 0.0:
        return "0"
    return f"{value:.4g}" if abs(value) < 1e-3 else f"{value:.4f}".rstrip("0").rstrip(".")
