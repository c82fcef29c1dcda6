"""The chains of a URDF, for ``urdf-ik info --chains``."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

from urdf_ik.cli import console, tables

if TYPE_CHECKING:
    from urdf_ik.model.urdf import UrdfModel


def as_json(model: UrdfModel, base: str | None) -> str:
    """The chains as data."""
    chains = [asdict(each) for each in model.chains(base)]
    return console.json_text({"robot": model.name, "source": model.source, "root": model.root, "chains": chains})


def as_text(model: UrdfModel, base: str | None) -> str:
    """A table of the chains, and how to choose one."""
    chains = model.chains(base)
    if not chains:
        return tables.render(f"{model.source}: no chain of movable joints")
    rows = [
        [each.name, each.base, each.tip, len(each.joints), "yes" if each.chosen else "", each.reason] for each in chains
    ]
    left = ["chain", "base", "tip", "meant", "why this tip"]
    table = tables.grid(["chain", "base", "tip", "joints", "meant", "why this tip"], rows, left=left)
    notes = []
    if not tables.fits(table):
        table = tables.grid(["chain", "base", "tip", "joints", "meant"], [row[:-1] for row in rows], left=left[:-1])
        notes += [f"{each.name}: {each.reason}" for each in chains]
    for each in chains:
        if each.frames:
            notes.append(f"{each.name}: fixed to its last link, too: {', '.join(each.frames)}")
        if each.before:
            notes.append(f"{each.name}: --base {model.root} takes in {', '.join(each.before)}")
    if not any(each.chosen for each in chains):
        notes.append("none is meant by itself: name one with --chain, or with --base and --tip")
    return tables.render(f"{model.name}: {model.source}", "", table, *([""] if notes else []), *notes)
