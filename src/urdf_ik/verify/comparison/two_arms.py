"""compare(): the differences of two arms, or of two URDFs of one arm, and their effect on solutions and tool."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.errors import UrdfIkError
from urdf_ik.ik.cuspidality import is_cuspidal
from urdf_ik.model.poses import as_pose_array, check_poses
from urdf_ik.support import inputs
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.verify.change import Tolerance, angle_between, apart, ignored
from urdf_ik.verify.change_search import differences
from urdf_ik.verify.comparison import answers
from urdf_ik.verify.comparison.report import AxisChange, Comparison, Fact, LimitChange, Side
from urdf_ik.verify.description import described

_SAMPLES = 20_000
_ROUNDING = 1e-9  # rad, m: an imperfection that is no more than rounded decimals


def compare(
    a: Arm,
    b: Arm,
    n: int = 200,
    seed: int = 0,
    *,
    poses: Any = None,
    tolerance_mm: float | None = None,
    tolerance_deg: float | None = None,
    ignore: str | Iterable[str] = (),
    progress: Callable[[int, int], None] | None = None,
) -> Comparison:
    """Compare two arms.

    Each arm draws ``n`` joint vectors within its limits; both arms solve all poses that these make. Joints are paired
    by name if both arms have the same names, else by their order from base to tip. If the numbers of joints differ, or
    one arm cannot be solved, some parts of the comparison are skipped; ``notes`` lists them.

    Args:
        a: the first arm, such as the nominal one.
        b: the second arm, such as the calibrated one.
        n: number of poses that each arm makes.
        seed: the same seed gives the same comparison.
        poses: (..., 4, 4) m, further poses that both arms solve.
        tolerance_mm: greatest difference of lengths that is ignored [mm]; default: 1e-6.
        tolerance_deg: greatest difference of angles that is ignored [deg]; default: 6e-8.
        ignore: kinds of differences that do not count: 'limits', 'collisions', 'visuals', 'names'.
        progress: called with (steps done, steps).

    Returns:
        The comparison; ``print`` it, or take its fields.

    Raises:
        ArgumentError: n is below 1, the seed or a tolerance is negative, or a kind cannot be ignored.
        PoseError: one of ``poses`` is invalid.

    Example:
        >>> import urdf_ik
        >>> a, b = urdf_ik.load("zyyzyz_6r"), urdf_ik.load("dh_6r")
        >>> len(compare(a, b, n=10).structure) > 0
        True
    """
    for what, each in (("a", a), ("b", b)):
        inputs.arm(each, what)
    n, seed = inputs.poses(n), inputs.whole(seed, "seed", high=2**64)
    notes: list[str] = []
    inputs.callback(progress, "progress")
    tolerance, skipped = Tolerance.read(tolerance_mm, tolerance_deg), ignored(ignore)
    own = None if poses is None else check_poses(as_pose_array(poses)).reshape(-1, 4, 4)
    order, reason = answers.paired(a, b)
    if reason:
        notes.append(f"axes, limits, joint differences and the tool error: {reason}")
    first, second = answers.Drawn(a, n, seed), answers.Drawn(b, n, seed)
    given: list[answers.Answers] = []
    try:
        for drawn in (first, second):
            given.append(answers.Answers(a, b, drawn))
            if progress is not None:
                progress(len(given), 2)
    except UrdfIkError as error:
        notes.append(f"reach, numbers of solutions and branches: {error}")
    both = len(given) == 2
    if both:
        notes += answers.cautions(a, b)
    tried = given[0].of_a if given else first.q
    axes = () if order is None else _axes(a, b, order)
    signs = np.array([-1.0 if axis.flipped else 1.0 for axis in axes])
    found = differences(described(a), described(b), tolerance)
    reach = [each.reach("AB"[k]) for k, each in enumerate(given)] if both else []
    if both and own is not None and len(own):
        reach.append(answers.Answers(a, b, answers.Given(own)).reach("you"))
    return Comparison(
        differences=tuple(each for each in found if each.kind not in skipped),
        a=_side(a),
        b=_side(b),
        n=n,
        seed=seed,
        structure=_structure(a, b),
        axes=axes,
        tip=apart(a.fk(np.zeros(a.dof)), b.fk(np.zeros(b.dof))),
        limits=() if order is None else _limits(a, b, order),
        farthest=(_farthest(a, seed), _farthest(b, seed)),
        reach=tuple(reach),
        branches=given[0].branches(order, signs) if both and order is not None else (),
        tool=None if order is None else answers.tool_error(first.reference, second.reference, tried, order),
        notes=tuple(notes),
    )


def _side(arm: Arm) -> Side:
    prismatic = tuple(bool(slides) for slides in arm.chain.prismatic)
    return Side(arm.name, arm.model.source, arm.base, arm.tip, arm.joint_names, prismatic)


def _structure(a: Arm, b: Arm) -> tuple[Fact, ...]:
    """Structural properties of both arms, and the relations between axes that differ."""

    def known(arm: Arm) -> dict[str, str]:
        structure = arm.structure
        kinds = "".join("P" if slides else "R" for slides in arm.chain.prismatic)
        words = {None: "not known", True: "yes", False: "no"}
        facts = {
            "joints": f"{arm.dof} ({kinds})",
            "family": structure.family or "none that is solved",
            "controls": arm.task,
            "solutions at most": str(structure.max_solutions),
            "cuspidal": words[is_cuspidal(arm.solver)],
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

    left, right = known(a), known(b)
    facts = [Fact(what, left.get(what, "-"), right.get(what, "-")) for what in {**left, **right}]
    left, right = related(a), related(b)
    relations = [Fact(what, left.get(what, "-"), right.get(what, "-")) for what in {**left, **right}]
    return (*facts, *(fact for fact in relations if not fact.same))


def _off(arm: Arm) -> str:
    angle, distance = arm.structure.imperfection
    if angle <= _ROUNDING and distance <= _ROUNDING:
        return arm.structure.imperfection_in_words()
    return f"off by {angle:.2g} rad, {distance:.2g} m"


def _axes(a: Arm, b: Arm, order: list[int]) -> tuple[AxisChange, ...]:
    out = []
    for i, k in enumerate(order):
        u, v = a.chain.H[i], b.chain.H[k]
        angle = angle_between(u, v)
        slides = bool(a.chain.prismatic[i])
        distance = 0.0 if slides else float(np.linalg.norm(np.cross(a.chain.points[i] - b.chain.points[k], v)))
        flipped = angle > np.pi - DEFAULT.near_angle
        out.append(AxisChange(a.joint_names[i], b.joint_names[k], angle, distance, flipped))
    return tuple(out)


def _limits(a: Arm, b: Arm, order: list[int]) -> tuple[LimitChange, ...]:
    def bounds(arm: Arm, i: int) -> tuple[float, float]:
        lower, upper = arm.limits[i]
        return float(lower), float(upper)

    return tuple(
        LimitChange(a.joint_names[i], b.joint_names[k], bounds(a, i), bounds(b, k)) for i, k in enumerate(order)
    )


def _farthest(arm: Arm, seed: int) -> float:
    """Greatest distance of the tip from the base's origin over sampled joint vectors."""
    Q = answers.Drawn(arm, _SAMPLES, seed).q
    return float(np.linalg.norm(arm.fk(Q)[:, :3, 3], axis=1).max())
