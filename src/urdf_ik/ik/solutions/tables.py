"""Solutions as pandas tables, as xarray data sets, and as HTML for a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.errors import MissingPackage
from urdf_ik.ik.solutions import limits
from urdf_ik.ik.solutions.explanations import parameters_in_words
from urdf_ik.ik.solutions.solution import Singular
from urdf_ik.kinematics import velocity
from urdf_ik.kinematics.chain import Chain
from urdf_ik.support.display import Markup, table
from urdf_ik.support.palette import colours
from urdf_ik.typing import Array

INSTALL = "pip install 'urdf-ik[tables]'"
MOST_ROWS = 32
"""Solutions that a notebook shows of an answer."""
_WIDTH, _HEIGHT, _EDGE = 260, 200, 12


def to_frame(solutions: Any, contacts: bool = True) -> Any:
    """See :meth:`urdf_ik.IKSolutions.to_frame`."""
    try:
        import pandas
    except ImportError:
        raise MissingPackage(f"to_frame() needs pandas: {INSTALL}") from None
    solver, places = solutions.solver, np.argwhere(solutions.valid)
    at, q = tuple(places.T), solutions.q[solutions.valid]
    columns: dict[str, Any] = {"arm": [solver.name] * len(q)}
    columns["pose"] = np.ravel_multi_index(at[:-1], solutions.shape) if solutions.shape else np.zeros(len(q), np.intp)
    if len(solutions.shape) > 1:
        columns |= {f"pose_{k}": places[:, k] for k in range(len(solutions.shape))}
    if (parameters := solutions.redundancy) is not None:
        values = parameters[at[:-1]].reshape(len(q), -1) if solutions.shape else np.tile(parameters, (len(q), 1))
        columns |= {_numbered("redundancy", k, values.shape[1]): values[:, k] for k in range(values.shape[1])}
    columns["branch"] = solutions.names[at]
    columns |= {f"q{k + 1}": q[:, k] for k in range(solver.dof)}
    columns["within_limits"] = _within(solutions)[at]
    columns["limit_margin"] = limits.margin(q, solver.limits)
    columns["manipulability"] = velocity.manipulability(solver.chain, q)
    bodies = solver.contacts.in_world(None)
    touching = bodies.in_collision(q) if contacts and bodies.has_geometry else [pandas.NA] * len(q)
    columns["contact"] = pandas.array(touching, dtype="boolean")
    columns["status"] = solutions.status[at[:-1]]
    columns["singular"] = [str(Singular(int(flags)).name or "") if flags else "" for flags in solutions.singular[at]]
    frame = pandas.DataFrame(columns)
    kinds = solver.chain.joint_types
    frame.attrs |= {
        "arm": solver.name,
        "base": solver.chain.base,
        "tip": solver.chain.tip,
        "joints": {f"q{k + 1}": name for k, name in enumerate(solver.joint_names)},
        "units": {f"q{k + 1}": "m" if kind == "prismatic" else "rad" for k, kind in enumerate(kinds)},
        "redundancy": [str(parameter) for parameter in solver.parameters],
        "contacts": bodies.unchecked if contacts else "not asked for",
    }
    return frame


def _numbered(name: str, k: int, count: int) -> str:
    return name if count == 1 else f"{name}_{k + 1}"


def to_xarray(solutions: Any) -> Any:
    """See :meth:`urdf_ik.IKSolutions.to_xarray`."""
    try:
        import xarray
    except ImportError:
        raise MissingPackage(f"to_xarray() needs xarray: {INSTALL}") from None
    pose_axes = solutions.valid.ndim - 1
    poses = ["pose"] if pose_axes == 1 else [f"pose_{k}" for k in range(pose_axes)]
    solver = solutions.solver
    units = ["m" if kind == "prismatic" else "rad" for kind in solver.chain.joint_types]
    return xarray.Dataset(
        {
            "q": ((*poses, "branch", "joint"), solutions.q),
            "valid": ((*poses, "branch"), solutions.valid),
            "singular": ((*poses, "branch"), solutions.singular),
            "within_limits": ((*poses, "branch"), _within(solutions)),
            "status": (tuple(poses), solutions.status),
            "T": ((*poses, "row", "column"), solutions.poses),
        },
        coords={
            "branch": list(solutions.branches),
            "joint": list(solver.joint_names),
            "unit": ("joint", units),
        },
        attrs={"arm": solver.name, "base": solver.chain.base, "tip": solver.chain.tip},
    )


def html(solutions: Any) -> str:
    """A table of the solutions and a small picture of them; of a batch, the number of solutions of its poses."""
    solver = solutions.solver
    title = f"{solver.name}: {solver.chain.base} to {solver.chain.tip}"
    if solutions.valid.ndim > 1:
        counts = solutions.valid.sum(axis=-1)
        lines = f"{counts.size} poses, {int((counts > 0).sum())} solved, {int(counts.sum())} solutions"
        return f"<div><p><b>{escape(title)}</b><br/>{lines}</p></div>"
    places = np.flatnonzero(solutions.valid)
    if not len(places):
        return f"<div><p><b>{escape(title)}</b><br/>no solution: {escape(solutions.explain())}</p></div>"
    within, names = _within(solutions), solutions.names
    shades = colours(len(solutions.branches))
    rows = []
    for k, place in enumerate(places[:MOST_ROWS]):
        singular = solutions.singular[place]
        values = [f"{value:.4f}" for value in solutions.q[place]]
        flags = str(Singular(int(singular)).name or "").lower().replace("|", ", ") if singular else "-"
        rows.append([_dot(shades[place]), str(k), names[place], *values, "yes" if within[place] else "no", flags])
    header = ["", "#", "branch", *solver.joint_names, "in limits", "singular"]
    rest = f"<p>and {len(places) - MOST_ROWS} more</p>" if len(places) > MOST_ROWS else ""
    drawn = places[:MOST_ROWS]
    picture = stick_picture(solver.chain, solutions.q[drawn], [shades[place] for place in drawn])
    count = f"{len(places)} solution{'' if len(places) == 1 else 's'}{escape(parameters_in_words(solutions))}"
    checked = "free of collisions" if "collision" in solutions.filters else "collisions: s.collision_free()"
    return f"<div><p><b>{escape(title)}</b><br/>{count}; {checked}</p>{picture}{table(header, rows)}{rest}</div>"


def stick_picture(chain: Chain, q: Array, shades: Sequence[tuple[float, float, float]]) -> str:
    """Stick figures (k, n) from the side as SVG, seen along the horizontal direction in which they are widest."""
    points = stick(chain, q)
    flat = points.reshape(-1, 3)
    sideways = flat[:, :2] - flat[:, :2].mean(axis=0)
    across = np.linalg.svd(sideways, full_matrices=False)[2][0] if np.ptp(sideways) > 0.0 else np.array([1.0, 0.0])
    seen = np.stack([points[..., :2] @ across, points[..., 2]], axis=-1)
    low, high = seen.min(axis=(0, 1)), seen.max(axis=(0, 1))
    scale = min((_WIDTH - 2 * _EDGE) / max(high[0] - low[0], 1e-9), (_HEIGHT - 2 * _EDGE) / max(high[1] - low[1], 1e-9))
    at = _EDGE + (seen - low) * scale
    at[..., 1] = _HEIGHT - at[..., 1]
    lines = "".join(
        f'<polyline points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in figure)}" fill="none" stroke="{_css(shade)}" '
        'stroke-width="3" stroke-linejoin="round" opacity="0.8"/>'
        for figure, shade in zip(at, shades, strict=True)
    )
    return f'<svg width="{_WIDTH}" height="{_HEIGHT}" role="img" aria-label="the arm from the side">{lines}</svg>'


def stick(chain: Chain, q: Array) -> Array:
    """(..., k, 3) m, the frames' origins of the chain's links at ``q`` (..., n), base to tip."""
    poses = chain.link_poses(q)
    return np.stack([poses[link][..., :3, 3] for link in chain.links], axis=-2)


def _dot(shade: tuple[float, float, float]) -> str:
    return Markup(f'<span style="color:{_css(shade)}">&#9679;</span>')


def _css(shade: tuple[float, float, float]) -> str:
    return "#" + "".join(f"{round(255 * part):02x}" for part in shade)


def _within(solutions: Any) -> NDArray[np.bool_]:
    """(..., B) whether a solution, or an image of it, lies inside the joint limits."""
    inside: NDArray[np.bool_] = solutions.within_limits().valid
    return inside
