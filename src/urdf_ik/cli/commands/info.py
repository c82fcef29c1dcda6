"""The command ``info``: an arm, the chains of its URDF, or its pairs of links."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from urdf_ik.arm import Arm
from urdf_ik.cli import console, tables
from urdf_ik.cli.arm_options import ArmOptions, angles_of
from urdf_ik.cli.console import Angles
from urdf_ik.cli.options import ReportFormat
from urdf_ik.errors import UrdfIkError, listed
from urdf_ik.kinematics.chain.redundancy import Redundancy
from urdf_ik.model.urdf import UrdfModel
from urdf_ik.model.urdf.chains import Limb
from urdf_ik.support.angles import shown, unit_of

_NUMBER = "a number, which orders the solutions of one pose and says nothing about another one"
_SIGN = "the sign of the Jacobian's determinant, which changes only across a singularity"
_NUMBERED = f"where geometry gives no name: {_NUMBER}"
_SIGNED = f"where geometry gives no name: {_SIGN}, and {_NUMBER}"
_UNSOLVED = "none: no solver takes this structure"
_JOINTS_ANALYSED = 7
"""Chains with more joints are not analysed for the table: each choice of joints to lock is an arm of its own."""
_LIMBS_SHOWN = 12


def info(
    *,
    chains: bool = False,
    pairs: bool = False,
    chosen: ArmOptions,
    degrees: bool = False,
    printed_as: ReportFormat = ReportFormat.TABLE,
) -> None:
    """Show an arm: its joints, how neighbouring axes lie to each other, and how it is solved.

    Examples:
        urdf-ik info zyyzyz_6r
        urdf-ik info my_arm.urdf --base base_link --tip tool0 --format json
        urdf-ik info panda --lock panda_joint3=30deg
        urdf-ik info my_arm.urdf --chains
        urdf-ik info my_arm.urdf --allow link_4,link_6 --pairs

    Options:
        chains: List the chains of the URDF instead, and the default one.
        pairs: List the pairs of links instead: checked for contact, or allowed, and why.
    """
    if chains and pairs:
        raise console.usage("--chains and --pairs are two lists; ask for one of them", "--pairs")
    if chains:
        model = chosen.model()
        limbs = [{**asdict(each), "family": _family(model, each)} for each in model.limbs(chosen.base)]
        found = [asdict(each) for each in model.chains(chosen.base)]
        data = {"robot": model.name, "source": model.source, "root": model.root, "chains": found, "limbs": limbs}
        console.emit(printed_as, data, lambda: _chains_text(model, chosen.base))
        return
    arm = chosen.load(degrees)
    if pairs:
        table = arm.cell.collisions.table()
        data = {"checked": table.checked, "allowed": [[*pair, why] for pair, why in table.allowed.items()]}
        console.emit(printed_as, data, lambda: f"{table}\n")
        return
    angles = angles_of(arm, degrees)
    console.emit(printed_as, lambda: _data(arm, angles), lambda: as_text(arm, angles))


def _data(arm: Arm, angles: Angles) -> dict[str, Any]:
    """The same facts as data; a limit that is not there is null."""
    from urdf_ik.ik.cuspidality import is_cuspidal

    structure = arm.structure
    angle, distance = structure.imperfection
    limits = angles.shown(arm.limits.T).T
    slides = {joint.name for joint in arm.model.joints if joint.type == "prismatic"}
    return {
        "robot": arm.name,
        "source": arm.model.source,
        "warnings": [str(each) for each in arm.model.warnings],
        "base": arm.base,
        "tip": arm.tip,
        "units": {"angle": angles.unit, "length": "m"},
        "locked": {name: value if name in slides else angles.angle(value) for name, value in arm.chain.locked},
        "joints": [
            {"name": name, "type": kind, "axis": axis, "lower": lower, "upper": upper}
            for name, kind, axis, (lower, upper) in zip(
                arm.joint_names, arm.chain.joint_types, arm.chain.directions, limits, strict=True
            )
        ],
        "mimics": [follower._asdict() for follower in arm.chain.followers],
        "structure": {
            "pairs": [
                {
                    "axes": [pair.first, pair.first + 1],
                    "relation": pair.relation,
                    "angle": angles.angle(pair.angle),
                    "distance": pair.distance,
                    "off_angle": angles.angle(pair.off_angle),
                    "off_distance": pair.off_distance,
                }
                for pair in structure.pairs
            ],
            "triples": [
                {
                    "axes": [triple.first + k for k in range(3)],
                    "relation": triple.relation,
                    "off_angle": angles.angle(triple.imperfection) if triple.relation == "parallel" else 0.0,
                    "off_distance": triple.imperfection if triple.relation == "meet" else 0.0,
                    "point": triple.point,
                }
                for triple in structure.triples
            ],
            "imperfection": {"angle": angles.angle(angle), "distance": distance},
        },
        "solver": {
            "supported": bool(structure.family),
            "redundancy": None if arm.redundancy is None else _redundancy(arm.redundancy),
            "family": structure.family or None,
            "task": arm.task,
            "method": structure.method or None,
            "exact": structure.is_exact if structure.family else None,
            "cuspidal": is_cuspidal(arm.solver),
            "max_solutions": structure.max_solutions,
            "branches": structure.branches,
        },
    }


def _redundancy(parameter: Redundancy) -> dict[str, Any]:
    low, high, default = (shown(value, parameter.unit) for value in (*parameter.range, parameter.default))
    return asdict(parameter) | {"range": (low, high), "default": default, "unit": unit_of(parameter.unit)}


def as_text(arm: Arm, angles: Angles) -> str:
    """Tables and lines for people."""
    from urdf_ik.ik.cuspidality import in_words, is_cuspidal
    from urdf_ik.ik.solutions import branch_names

    structure, chain, unit = arm.structure, arm.chain, angles.unit
    limits = [
        ["none" if abs(x) == float("inf") else tables.number(x) for x in ends] for ends in angles.shown(arm.limits.T).T
    ]
    directions = [" ".join(f"{x:>7}" for x in tables.numbers(axis)) for axis in chain.directions]
    columns = zip(arm.joint_names, chain.joint_types, directions, limits, angles.units, strict=True)
    joints = tables.grid(
        ["#", "joint", "type", "axis in base at q = 0", "lower", "upper", "unit"],
        [[i, name, kind, axis, *ends, unit] for i, (name, kind, axis, ends, unit) in enumerate(columns, 1)],
        left=["joint", "type", "axis in base at q = 0", "unit"],
    )
    rows = []
    for pair in structure.pairs:
        turned, apart = f"{angles.angle(pair.off_angle):.1e} {unit}", f"{pair.off_distance:.1e} m"
        off = {"parallel": turned, "coincident": f"{turned}, {apart}", "intersecting": apart}.get(pair.relation, "-")
        distance = "0" if pair.off_distance else f"{pair.distance:.6g}"
        axes = f"{pair.first}, {pair.first + 1}"
        rows.append([axes, pair.relation, f"{angles.angle(pair.angle):.6g}", distance, off])
    for triple in structure.triples:
        meet = triple.relation == "meet"
        off = f"{triple.imperfection:.1e} m" if meet else f"{angles.angle(triple.imperfection):.1e} {unit}"
        axes = ", ".join(str(triple.first + k) for k in range(3))
        rows.append([axes, "meet in a point" if meet else triple.relation, "-", "-", off])
    header = ["axes", "relation", f"angle [{unit}]", "distance [m]", "imperfection"]
    axes_table = tables.grid(header, rows, left=["axes", "relation", "imperfection"])
    slides = {joint.name for joint in arm.model.joints if joint.type == "prismatic"}
    facts = [
        ("robot", arm.name),
        ("source", arm.model.source),
        ("chain", f"{arm.base} to {arm.tip}, {arm.dof} joint{'s' if arm.dof > 1 else ''}"),
        *[("mimics", str(follower)) for follower in chain.followers],
    ]
    for name, value in chain.locked:
        at = f"{value:.6g} m" if name in slides else f"{angles.angle(value):.6g} {unit}"
        facts.append(("locked", f"{name} at {at}"))
    if allowed := len(arm.cell.disabled):
        facts.append(("may touch", f"{allowed} pair{'s' * (allowed > 1)} of links, by the SRDF; `--pairs` lists all"))
    facts += [("warning", str(each)) for each in arm.model.warnings]
    solver, branches = [("family", structure.family or _UNSOLVED)], []
    if structure.family:
        local = bool(branch_names.local(structure.branches))
        solver += [
            ("controls", arm.task if arm.task != "pose" else ""),
            ("why", structure.reason),
            ("solver", structure.method),
            ("solutions", structure.solutions_in_words()),
            ("imperfection", structure.imperfection_in_words()),
            ("cuspidal", in_words(is_cuspidal(arm.solver)) if structure.is_6r else ""),
            ("redundancy", "" if arm.redundancy is None else str(arm.redundancy)),
            ("names", "" if not local else _NUMBERED if branch_names.square(arm.solver) is None else _SIGNED),
        ]
        branches = [f"{'' if i else 'branches':<14}{line}" for i, line in enumerate(_columns(structure.branches))]
    solver = [(heading, text) for heading, text in solver if text]
    return tables.render(tables.facts(facts), "", joints, "", axes_table, "", tables.facts(solver), branches)


def _columns(branches: tuple[str, ...]) -> list[str]:
    """The columns of an answer: one line each, but one for a run of names that are only numbered."""
    lines, start = [], 0
    while start < len(branches):
        kind, _, number = branches[start].rpartition(" ")
        end = start + 1
        while number.isdigit() and end < len(branches) and branches[end] == f"{kind} {int(number) + end - start}":
            end += 1
        if end - start == 1:
            lines.append(f"{start + 1:>2}  {branches[start]}")
        else:
            lines.append(f"{start + 1:>2} to {end}  {branches[start]} to {branches[end - 1]}")
        start = end
    return lines


def _chains_text(model: UrdfModel, base: str | None) -> str:
    """A table of the limbs, and how to choose one."""
    chains, limbs = model.chains(base), [each for each in model.limbs(base) if each.kind != "finger"]
    if not chains:
        return tables.render(f"{model.source}: no chain of movable joints")
    meant = [Limb(each.name, "chain", each.base, each.tip, each.joints) for each in chains if each.chosen]
    there = {(each.base, each.tip) for each in limbs}
    shown = [*(each for each in meant if (each.base, each.tip) not in there), *limbs]
    chosen = {(each.base, each.tip) for each in meant}
    heads = ["chain", "joints", "base", "tip", "family", "meant"]
    rows = [
        dict(zip(heads, (each.name, len(each.joints), each.base, each.tip, _family(model, each)), strict=False))
        | {"meant": "yes" if (each.base, each.tip) in chosen else ""}
        for each in shown[:_LIMBS_SHOWN]
    ]
    table: list[str] = []
    for dropped in ("", "base", "tip"):  # as many columns as the terminal has room for
        heads = [head for head in heads if head != dropped]
        table = tables.grid(heads, [[row[head] for head in heads] for row in rows], left=[*heads[:1], *heads[2:]])
        if tables.fits(table):
            break
    notes = [f"{len(shown) - _LIMBS_SHOWN} more: --format json lists them"] if len(shown) > _LIMBS_SHOWN else []
    for each in chains:
        if each.chosen and each.frames:
            notes.append(f"{each.tip} ({each.reason}); fixed to its last link, too: {listed(each.frames, 4)}")
        if each.chosen and each.before:
            notes.append(f"--base {model.root} takes in {listed(each.before, 4)}")
    if fingers := [each for each in model.limbs(base) if each.kind == "finger"]:
        notes.append("fingers: " + listed([f"{each.name} ({len(each.joints)})" for each in fingers], 4))
    if not meant:
        notes.append("none is meant by itself: name one with --chain, or with --base and --tip")
    folded = [line for note in notes for line in tables.folded(note, further="  ")]
    return tables.render(f"{model.name}: {model.source}", "", table, [""] if folded else [], folded)


def _family(model: UrdfModel, limb: Limb) -> str:
    """How the limb is solved, in a few words."""
    from urdf_ik.ik import families
    from urdf_ik.kinematics.chain import from_urdf
    from urdf_ik.kinematics.structure import analyse

    if len(limb.joints) > _JOINTS_ANALYSED:
        return f"lock {len(limb.joints) - _JOINTS_ANALYSED} or more"
    try:
        chain = from_urdf(model, limb.base, limb.tip)
        plan = families.choose(analyse(chain), chain) if chain.n else None
    except UrdfIkError:
        return "broken"
    return plan.name if plan is not None else "none"
