"""An arm as HTML, which a notebook shows."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np

from urdf_ik.ik.solutions.tables import stick_picture, table
from urdf_ik.support.palette import colours


def html(arm: Any) -> str:
    """Joints and limits, how it is solved, and a small picture of it nearest to zero within its limits."""
    kinds = arm.chain.joint_types
    rows = [
        [str(k + 1), name, kind, _bound(lower), _bound(upper), "m" if kind == "prismatic" else "rad"]
        for k, (name, kind, (lower, upper)) in enumerate(zip(arm.joint_names, kinds, arm.limits, strict=True))
    ]
    structure = arm.structure
    solved = f"{structure.family}: {structure.solutions_in_words()}" if structure.family else "no solver takes it"
    title = f"{arm.name}: {arm.base} to {arm.tip}"
    q = np.clip(np.zeros(arm.dof), *arm.limits.T)
    picture = stick_picture(arm, q[None], colours(1))
    joints = table(["#", "joint", "type", "lower", "upper", "unit"], rows)
    return f"<div><p><b>{escape(title)}</b><br/>{escape(solved)}</p>{picture}{joints}</div>"


def _bound(value: float) -> str:
    return "none" if np.isinf(value) else f"{value:.4f}"
