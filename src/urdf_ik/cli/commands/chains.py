"""The limbs and chains of a URDF, for ``urdf-ik info --chains``."""

from __future__ import annotations

import textwrap
from dataclasses import asdict

from urdf_ik.cli import console, tables
from urdf_ik.errors import UrdfIkError, listed
from urdf_ik.model.urdf import UrdfModel
from urdf_ik.model.urdf.chains import Limb

_MOST_JOINTS = 7
"""Chains with more joints are not analysed for the table: each choice of joints to lock is an arm of its own."""
_MOST_LINES = 12
"""Limbs and notes that are listed, so that all of it fits on one screen."""


def as_json(model: UrdfModel, base: str | None) -> str:
    """The chains and limbs as data."""
    chains = [asdict(each) for each in model.chains(base)]
    limbs = [{**asdict(each), "family": _family(model, each)} for each in model.limbs(base)]
    facts = {"robot": model.name, "source": model.source, "root": model.root}
    return console.json_text({**facts, "chains": chains, "limbs": limbs})


def as_text(model: UrdfModel, base: str | None) -> str:
    """A table of the limbs, and how to choose one."""
    chains, limbs = model.chains(base), [each for each in model.limbs(base) if each.kind != "finger"]
    if not chains:
        return tables.render(f"{model.source}: no chain of movable joints")
    meant = [Limb(each.name, "chain", each.base, each.tip, each.joints) for each in chains if each.chosen]
    there = {(each.base, each.tip) for each in limbs}
    shown = [*(each for each in meant if (each.base, each.tip) not in there), *limbs]
    chosen = {(each.base, each.tip) for each in meant}
    rows = [
        [each.name, len(each.joints), each.base, each.tip, _family(model, each), _yes((each.base, each.tip) in chosen)]
        for each in shown[:_MOST_LINES]
    ]
    heads = ["chain", "joints", "base", "tip", "family", "meant"]
    left = ["chain", "base", "tip", "family", "meant"]
    table = tables.grid(heads, rows, left=left)
    for dropped in ("base", "tip"):
        if not tables.fits(table):
            at = heads.index(dropped)
            heads, rows = heads[:at] + heads[at + 1 :], [row[:at] + row[at + 1 :] for row in rows]
            table = tables.grid(heads, rows, left=[each for each in left if each in heads])
    notes = [f"{len(shown) - _MOST_LINES} more: --format json lists them"] if len(shown) > _MOST_LINES else []
    for each in chains:
        if each.chosen and each.frames:
            notes.append(f"{each.tip} ({each.reason}); fixed to its last link, too: {listed(each.frames, 4)}")
        if each.chosen and each.before:
            notes.append(f"--base {model.root} takes in {listed(each.before, 4)}")
    if fingers := [each for each in model.limbs(base) if each.kind == "finger"]:
        notes.append("fingers: " + listed([f"{each.name} ({len(each.joints)})" for each in fingers], 4))
    if not meant:
        notes.append("none is meant by itself: name one with --chain, or with --base and --tip")
    folded = [line for note in notes for line in textwrap.wrap(note, 79, subsequent_indent="  ")]
    return tables.render(f"{model.name}: {model.source}", "", table, *([""] if folded else []), *folded)


def _yes(it_is: bool) -> str:
    return "yes" if it_is else ""


def _family(model: UrdfModel, limb: Limb) -> str:
    """How the limb is solved, in a few words."""
    from urdf_ik.ik import families
    from urdf_ik.kinematics.chain import from_urdf
    from urdf_ik.kinematics.structure import analyse

    if len(limb.joints) > _MOST_JOINTS:
        return f"lock {len(limb.joints) - _MOST_JOINTS} or more"
    try:
        chain = from_urdf(model, limb.base, limb.tip)
        plan = families.choose(analyse(chain), chain) if chain.n else None
    except UrdfIkError:
        return "broken"
    return plan.name if plan is not None else "none"
