"""The command ``info``: an arm, the chains of its URDF, or its pairs of links."""

from dataclasses import asdict
from typing import Any

from urdf_ik.arm import Arm
from urdf_ik.cli import console, tables
from urdf_ik.cli.arm_options import ArmOptions
from urdf_ik.cli.console import Angles
from urdf_ik.cli.options import ReportFormat
from urdf_ik.errors import UrdfIkError, listed
from urdf_ik.kinematics.chain.redundancy import Redundancy
from urdf_ik.model.urdf import UrdfModel
from urdf_ik.model.urdf.chains import Limb
from urdf_ik.model.urdf.checks import in_words
from urdf_ik.support.angles import shown, unit_of
from urdf_ik.support.text import counted

_NUMBER = "a number, which orders the solutions of one pose and says nothing about another one"
_SIGN = "the sign of the Jacobian's determinant, which changes only across a singularity"
_NUMBERED = f"where geometry gives no name: {_NUMBER}"
_SIGNED = f"where geometry gives no name: {_SIGN}, and {_NUMBER}"
_UNSOLVED = "none: no solver takes this structure"
_NOT_CUSPIDAL = "no: every change from one solution of a pose to another crosses a singularity"
_JOINT = ("name", "type", "axis", "lower", "upper")
_PAIR = ("axes", "relation", "angle", "distance", "off_angle", "off_distance")
_TRIPLE = ("axes", "relation", "off_angle", "off_distance", "point")
_JOINTS_ANALYSED = 7
"""Chains with more joints are not analysed for the table: each choice of joints to lock is an arm of its own."""


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
        base = chosen.base if model.chains(chosen.base) else None  # None: a frame beside the chain, as 'base' of a UR
        limbs = [{**asdict(each), "family": _family(model, each)} for each in model.limbs(base)]
        found = [asdict(each) for each in model.chains(base)]
        data = {"robot": model.name, "source": model.source, "root": model.root, "chains": found, "limbs": limbs}
        console.emit(printed_as, data, lambda: _chains_text(model, base))
        return
    arm, angles = chosen.loaded(degrees)
    if pairs:
        table = arm.cell.collisions.table()
        data = {"checked": table.checked, "allowed": [[*pair, why] for pair, why in table.allowed.items()]}
        console.emit(printed_as, data, lambda: f"{table}\n")
        return
    console.emit(printed_as, lambda: _data(arm, angles), lambda: as_text(arm, angles))


def _data(arm: Arm, angles: Angles) -> dict[str, Any]:
    """The same facts as data; a limit that is not there is null."""
    structure = arm.structure
    angle, distance = structure.imperfection
    joints = zip(arm.joint_names, arm.chain.joint_types, arm.chain.directions, *angles.shown(arm.limits.T), strict=True)
    turn = angles.angle
    pairs = [
        ([p.first, p.first + 1], p.relation, turn(p.angle), p.distance, turn(p.off_angle), p.off_distance)
        for p in structure.pairs
    ]
    triples = []
    for t in structure.triples:
        off = (turn(t.imperfection), 0.0) if t.relation == "parallel" else (0.0, t.imperfection)
        triples.append(([t.first, t.first + 1, t.first + 2], t.relation, *off, t.point))
    slides = {joint.name for joint in arm.model.joints if joint.type == "prismatic"}
    return {
        "robot": arm.name,
        "source": arm.model.source,
        "warnings": [str(each) for each in arm.model.warnings],
        "base": arm.base,
        "tip": arm.tip,
        "units": {"angle": angles.unit, "length": "m"},
        "locked": {name: value if name in slides else angles.angle(value) for name, value in arm.chain.locked},
        "joints": [dict(zip(_JOINT, row, strict=True)) for row in joints],
        "mimics": [follower._asdict() for follower in arm.chain.followers],
        "structure": {
            "pairs": [dict(zip(_PAIR, row, strict=True)) for row in pairs],
            "triples": [dict(zip(_TRIPLE, row, strict=True)) for row in triples],
            "imperfection": {"angle": angles.angle(angle), "distance": distance},
        },
        "solver": {
            "supported": bool(structure.family),
            "redundancy": None if arm.redundancy is None else _redundancy(arm.redundancy),
            "family": structure.family or None,
            "task": arm.task,
            "method": structure.method or None,
            "exact": structure.is_exact if structure.family else None,
            "cuspidal": structure.cuspidal,
            "max_solutions": structure.max_solutions,
            "branches": structure.branches,
        },
    }


def _redundancy(parameter: Redundancy) -> dict[str, Any]:
    low, high, default = (shown(value, parameter.unit) for value in (*parameter.range, parameter.default))
    return asdict(parameter) | {"range": (low, high), "default": default, "unit": unit_of(parameter.unit)}


def as_text(arm: Arm, angles: Angles) -> str:
    """Tables and lines for people."""
    from urdf_ik.ik.solutions import branch_names

    structure, data, unit = arm.structure, _data(arm, angles), f"[{angles.unit}]"
    allowed, relations = len(arm.cell.disabled), data["structure"]
    about: dict[str, Any] = {"robot": arm.name, "source": arm.model.source}
    about["chain"] = f"{arm.base} to {arm.tip}, {counted(arm.dof, 'joint')}"
    about["mimics"] = "; ".join(map(str, arm.chain.followers))
    about[f"locked [{angles.unit}, m]"] = ", ".join(f"{name} = {value:.6g}" for name, value in data["locked"].items())
    about["may touch"] = f"{counted(allowed, 'pair')} of links, by the SRDF; `--pairs` lists all" if allowed else ""
    about["warnings"] = "; ".join(in_words(arm.model.warnings))
    about["joints"] = [
        {"joint": joint["name"], "type": joint["type"], "axis at q = 0": tables.numbers(joint["axis"], 3)}
        | {name: f"{joint[name]:.6g}".replace("inf", "none") for name in ("lower", "upper")}
        | {"unit": shown_in}
        for joint, shown_in in zip(data["joints"], angles.units, strict=True)
    ]
    about["relations"] = [
        {"axes": each["axes"], "relation": each["relation"], f"angle {unit}": each.get("angle")}
        | {"distance [m]": each.get("distance")}
        | {f"off {unit}": f"{each['off_angle']:.1e}", "off [m]": f"{each['off_distance']:.1e}"}
        for each in (*relations["pairs"], *relations["triples"])
    ]
    if not structure.family:
        return tables.render(tables.outline(about), "", tables.outline({"family": _UNSOLVED}))
    local = bool(branch_names.local(structure.branches))
    solver = {
        "family": structure.family,
        "controls": arm.task if arm.task != "pose" else "",
        "why": structure.reason,
        "solver": structure.method,
        "solutions": structure.solutions_in_words(),
        "imperfection": structure.imperfection_in_words(),
        "cuspidal": _NOT_CUSPIDAL if structure.cuspidal is False else "not known" if structure.is_6r else "",
        "redundancy": "" if arm.redundancy is None else str(arm.redundancy),
        "names": "" if not local else _NUMBERED if branch_names.square(arm.solver) is None else _SIGNED,
    }
    solver["branches"] = "; ".join(structure.branches)
    return tables.render(tables.outline(about), "", tables.outline(solver))


def _chains_text(model: UrdfModel, base: str | None) -> str:
    """A table of the limbs, and how to choose one."""
    chains, limbs = model.chains(base), model.limbs(base)
    if not chains:
        return tables.render(f"{model.source}: no chain of movable joints")
    meant = {(each.base, each.tip): each for each in chains if each.chosen}
    there = {(each.base, each.tip) for each in limbs}
    more = [Limb(each.name, "chain", *key, each.joints) for key, each in meant.items() if key not in there]
    rows = [
        {"chain": each.name, "joints": len(each.joints), "tip": each.tip, "family": _family(model, each)}
        | {"meant": "yes" if (each.base, each.tip) in meant else ""}
        for each in (*more, *limbs)
    ]
    notes = []
    for each in meant.values():
        frames = f"; fixed to its last link, too: {listed(each.frames, 4)}" if each.frames else ""
        before = f"; --base {model.root} takes in {listed(each.before, 4)}" if each.before else ""
        notes.append(f"{each.tip} ({each.reason}){frames}{before}")
    notes += [] if meant else ["none is meant by itself: name one with --chain, or with --base and --tip"]
    table = tables.outline({"chains": rows})
    return tables.render(f"{model.name}: {model.source}", table, "", *(tables.folded(note, "", "  ") for note in notes))


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
