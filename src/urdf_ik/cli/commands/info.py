"""Show an arm: its joints, how neighbouring axes lie to each other, and how it is solved.

Examples:
    urdf-ik info zyyzyz_6r
    urdf-ik info my_arm.urdf --base base_link --tip tool0 --format json
    urdf-ik info panda --lock panda_joint3=30deg
    urdf-ik info my_arm.urdf --chains
    urdf-ik info my_arm.urdf --allow link_4,link_6 --pairs
"""

from __future__ import annotations

import textwrap
from dataclasses import asdict
from typing import Annotated, Any

from typer import Option

from urdf_ik.arm import Arm
from urdf_ik.cli import console, options, tables
from urdf_ik.cli.arm_options import ArmOptions, angles_of
from urdf_ik.cli.console import Angles
from urdf_ik.cli.options import ReportFormat
from urdf_ik.kinematics.structure import AxisPair, AxisTriple

_NUMBER = "a number, which orders the solutions of one pose and says nothing about another one"
_SIGN = "the sign of the Jacobian's determinant, which changes only across a singularity"
_NUMBERED = f"where geometry gives no name: {_NUMBER}"
_SIGNED = f"where geometry gives no name: {_SIGN}, and {_NUMBER}"
_UNSOLVED = "none: no solver takes this structure"


def command(
    *,
    chains: Annotated[
        bool, Option("--chains", help="List the chains of the URDF instead, and the default one.")
    ] = False,
    pairs: Annotated[
        bool, Option("--pairs", help="List the pairs of links instead: checked for contact, or allowed, and why.")
    ] = False,
    chosen: ArmOptions,
    degrees: options.Degrees = False,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Print the arm, the chains of its URDF, or its pairs of links."""
    if chains and pairs:
        raise console.usage("--chains and --pairs are two lists; ask for one of them", "--pairs")
    if chains:
        from urdf_ik.cli.commands import chains as list_of_chains

        show = list_of_chains.as_json if printed_as is ReportFormat.JSON else list_of_chains.as_text
        return console.write(show(chosen.model(), chosen.base), None)
    arm = chosen.load(degrees)
    if pairs:
        table = arm.cell.collisions.table()
        listed = {"checked": table.checked, "allowed": [[*pair, why] for pair, why in table.allowed.items()]}
        return console.write(console.json_text(listed) if printed_as is ReportFormat.JSON else f"{table}\n", None)
    write = as_json if printed_as is ReportFormat.JSON else as_text
    return console.write(write(arm, angles_of(arm, degrees)), None)


def as_json(arm: Arm, angles: Angles) -> str:
    """The same facts as data; a limit that is not there is null."""
    from urdf_ik.ik.cuspidality import is_cuspidal

    structure = arm.structure
    angle, distance = structure.imperfection
    limits = angles.shown(arm.limits.T).T
    return console.json_text(
        {
            "robot": arm.name,
            "source": arm.model.source,
            "warnings": [str(each) for each in arm.model.warnings],
            "base": arm.base,
            "tip": arm.tip,
            "units": {"angle": angles.unit, "length": "m"},
            "locked": dict(arm.chain.locked),
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
                        "axes": _numbers(triple),
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
                "redundancy": None if arm.redundancy is None else asdict(arm.redundancy),
                "family": structure.family or None,
                "task": arm.task,
                "method": structure.method or None,
                "exact": structure.is_exact if structure.family else None,
                "cuspidal": is_cuspidal(arm.solver),
                "max_solutions": structure.max_solutions,
                "branches": structure.branches,
            },
        }
    )


def as_text(arm: Arm, angles: Angles) -> str:
    """Tables and lines for people."""
    from urdf_ik.ik.cuspidality import in_words, is_cuspidal
    from urdf_ik.ik.solutions import branch_names

    structure = arm.structure
    unit = angles.unit
    joints = tables.grid(
        ["#", "joint", "type", "axis in base at q = 0", "lower", "upper", "unit"],
        [
            [i + 1, name, kind, _vector(axis), *(_limit(x) for x in limits), "m" if kind == "prismatic" else unit]
            for i, (name, kind, axis, limits) in enumerate(
                zip(
                    arm.joint_names,
                    arm.chain.joint_types,
                    arm.chain.directions,
                    angles.shown(arm.limits.T).T,
                    strict=True,
                )
            )
        ],
        left=["joint", "type", "axis in base at q = 0", "unit"],
    )
    axes = tables.grid(
        ["axes", "relation", f"angle [{unit}]", "distance [m]", "imperfection"],
        [_pair_row(pair, angles) for pair in structure.pairs] + [_triple_row(t, angles) for t in structure.triples],
        left=["axes", "relation", "imperfection"],
    )
    facts = [
        ("robot", arm.name),
        ("source", arm.model.source),
        ("chain", f"{arm.base} to {arm.tip}, {arm.dof} joint{'s' if arm.dof > 1 else ''}"),
        *[("mimics", str(follower)) for follower in arm.chain.followers],
        *[("locked", f"{name} at {_held(arm, name, value, angles)}") for name, value in arm.chain.locked],
    ]
    solver = [("family", structure.family or _UNSOLVED)]
    branches = []
    if structure.family:
        solver += [("controls", arm.task)] if arm.task != "pose" else []
        solver += [
            ("why", structure.reason),
            ("solver", structure.method),
            ("solutions", structure.solutions_in_words()),
            ("imperfection", structure.imperfection_in_words()),
            *([("cuspidal", in_words(is_cuspidal(arm.solver)))] if structure.is_6r else []),
            *([] if arm.redundancy is None else [("redundancy", str(arm.redundancy))]),
        ]
        if branch_names.local(structure.branches):
            solver.append(("names", _NUMBERED if branch_names.square(arm.solver) is None else _SIGNED))
        branches = [f"{'branches' if i == 0 else '':<14}{line}" for i, line in enumerate(_columns(structure.branches))]
    solver = [(heading, text) for heading, text in solver if text]
    if allowed := len(arm.cell.disabled):
        facts.append(("may touch", f"{allowed} pair{'s' * (allowed > 1)} of links, by the SRDF; `--pairs` lists all"))
    facts += [("warning", str(each)) for each in arm.model.warnings]
    return tables.render(_facts(facts), "", joints, "", axes, "", _facts(solver), *branches)


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


def _facts(facts: list[tuple[str, str]]) -> str:
    """Lines of a heading and its text, folded under itself."""
    lines = []
    for heading, text in facts:
        folded = textwrap.wrap(text, 64, break_long_words=False, break_on_hyphens=False) or [""]
        lines += [f"{heading if i == 0 else '':<14}{line}" for i, line in enumerate(folded)]
    return "\n".join(lines)


def _pair_row(pair: AxisPair, angles: Angles) -> list[str]:
    distance = "0" if pair.off_distance else f"{pair.distance:.6g}"
    off = {
        "parallel": f"{angles.angle(pair.off_angle):.1e} {angles.unit}",
        "coincident": f"{angles.angle(pair.off_angle):.1e} {angles.unit}, {pair.off_distance:.1e} m",
        "intersecting": f"{pair.off_distance:.1e} m",
    }
    return [
        f"{pair.first}, {pair.first + 1}",
        pair.relation,
        f"{angles.angle(pair.angle):.6g}",
        distance,
        off.get(pair.relation, "-"),
    ]


def _triple_row(triple: AxisTriple, angles: Angles) -> list[str]:
    axes = ", ".join(map(str, _numbers(triple)))
    if triple.relation == "meet":
        return [axes, "meet in a point", "-", "-", f"{triple.imperfection:.1e} m"]
    return [axes, triple.relation, "-", "-", f"{angles.angle(triple.imperfection):.1e} {angles.unit}"]


def _numbers(triple: AxisTriple) -> list[int]:
    return [triple.first, triple.first + 1, triple.first + 2]


def _vector(axis: Any) -> str:
    return " ".join(f"{tables.number(float(x), 4):>7}" for x in axis)


def _held(arm: Arm, name: str, value: float, angles: Angles) -> str:
    slides = any(joint.name == name and joint.type == "prismatic" for joint in arm.model.joints)
    return f"{value:.6g} m" if slides else f"{angles.angle(value):.6g} {angles.unit}"


def _limit(value: float) -> str:
    return "none" if abs(value) == float("inf") else tables.number(float(value), 4)
