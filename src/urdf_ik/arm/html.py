"""The table of an arm in a notebook."""

from __future__ import annotations

from html import escape

import numpy as np

from urdf_ik.ik.solutions.tables import stick_picture
from urdf_ik.ik.solver import Solver
from urdf_ik.support.display import table
from urdf_ik.support.palette import colours


def html(solver: Solver) -> str:
    """Joints and limits, how it is solved, and a small picture of it nearest to zero within its limits."""
    kinds = solver.chain.joint_types
    rows = [
        [str(k + 1), name, kind, _bound(lower), _bound(upper), "m" if kind == "prismatic" else "rad"]
        for k, (name, kind, (lower, upper)) in enumerate(zip(solver.joint_names, kinds, solver.limits, strict=True))
    ]
    structure = solver.structure
    solved = f"{structure.family}: {structure.solutions_in_words()}" if structure.family else "no solver takes it"
    title = f"{solver.name}: {solver.chain.base} to {solver.chain.tip}"
    q = np.clip(np.zeros(solver.dof), *solver.limits.T)
    picture = stick_picture(solver.chain, q[None], colours(1))
    joints = table(["#", "joint", "type", "lower", "upper", "unit"], rows)
    return f"<div><p><b>{escape(title)}</b><br/>{escape(solved)}</p>{picture}{joints}</div>"


def _bound(value: float) -> str:
    return "none" if np.isinf(value) else f"{value:.4f}"
