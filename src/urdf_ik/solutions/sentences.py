"""Words for solutions: names of images, the reason why there are none, a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik.solutions import limits

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from urdf_ik.solutions.ik_solutions import IKSolutions

    Array = NDArray[np.float64]

_MOST_ROWS = 32


def suffix(turns: Array) -> str:
    """Turns (n,) of an image as ' [q1+360°, q6-360°]'; '' without any."""
    parts = [f"q{i + 1}{360 * int(k):+d}°" for i, k in enumerate(turns) if k]
    return f" [{', '.join(parts)}]" if parts else ""


def turned_branches(branches: Sequence[str], turns: Sequence[Array], ranks: NDArray[np.intp]) -> tuple[str, ...]:
    """Names of the columns of ``limits.turns``: the turns where all poses share them, else the image's number.

    Args:
        branches: B names.
        turns: one array (..., B, m_i) a joint: turns of each of its images, NaN where there are fewer.
        ranks: (M, n) which image each joint has in the M columns of a branch.
    """
    parts: list[list[list[str]]] = []
    for i, k in enumerate(turns):
        rows = k.reshape(-1, *k.shape[-2:])
        # fmin and fmax pass over NaN; an image that no pose has stays at the starting values.
        least, most = np.fmin.reduce(rows, axis=0, initial=np.inf), np.fmax.reduce(rows, axis=0, initial=-np.inf)
        parts.append([[_image(i, r, *ends) for r, ends in enumerate(zip(*row, strict=True))]
                      for row in zip(least.tolist(), most.tolist(), strict=True)])  # fmt: skip
    names = []
    for b, branch in enumerate(branches):
        for rank in ranks.tolist():
            turned = [part for i, r in enumerate(rank) if (part := parts[i][b][r])]
            names.append(f"{branch} [{', '.join(turned)}]" if turned else branch)
    return tuple(names)


def explanation(solutions: IKSolutions) -> str:
    """Why a single pose has no solution; '' where it has one."""
    if solutions.count:
        return ""
    while solutions.step is not None and not solutions.step.parent.count:
        solutions = solutions.step.parent
    step = solutions.step
    if step is None:
        at = solutions.redundancy
        return str(solutions.arm.explain(solutions.poses, None if at is None else float(at)))
    found = "1 solution reaches" if step.parent.count == 1 else f"{step.parent.count} solutions reach"
    if step.how != "collision":
        return f"{found} the pose, none inside the joint limits; {_out_of_limits(step.parent, step.amount)}"
    inside = " inside the joint limits" if {"limits", "turns"} & set(step.parent.filters) else ""
    near = f" or comes within {step.amount:g} m of one" if step.amount else ""
    return f"{found} the pose{inside}, and every one is in collision{near}"


def table(solutions: IKSolutions, degrees: bool = False) -> str:
    """The solutions of a single pose, a line each; a batch in one sentence."""
    name = solutions.arm.name
    how = f" ({', '.join(solutions.filters)})" if solutions.filters else ""
    if solutions.shape:
        count = solutions.count
        return f"{name}: {count.size} poses, {np.count_nonzero(count)} of them solved, {count.sum()} solutions{how}"
    if not solutions.count:
        return f"{name}: no solution{how}: {explanation(solutions)}"
    kinds = solutions.arm.chain.joint_types
    angle = "deg" if degrees else "rad"
    scale = np.array([np.rad2deg(1.0) if degrees and kind != "prismatic" else 1.0 for kind in kinds])
    rows = [["#", "branch", *(f"q{i + 1} [{'m' if k == 'prismatic' else angle}]" for i, k in enumerate(kinds)), ""]]
    shown = list(solutions)
    for one in shown[:_MOST_ROWS]:
        values = [f"{x:.{2 if s != 1.0 else 4}f}" for x, s in zip(one.q * scale, scale, strict=True)]
        flag = f"singular: {one.singular.name}".lower() if one.singular else ""
        rows.append([str(one.index), one.branch, *values, flag])
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [f"{name}: {len(shown)} solution{'s' if len(shown) != 1 else ''}{how}"]
    for row in rows:
        cells = [cell.ljust(w) if i in (1, len(row) - 1) else cell.rjust(w)
                 for i, (cell, w) in enumerate(zip(row, widths, strict=True))]  # fmt: skip
        lines.append("  ".join(cells).rstrip())
    if len(shown) > _MOST_ROWS:
        lines.append(f"... and {len(shown) - _MOST_ROWS} more")
    return "\n".join(lines)


def _image(joint: int, rank: int, least: float, most: float) -> str:
    """One joint's part of a column's name."""
    if least == most:
        return f"q{joint + 1}{360 * int(least):+d}°" if least else ""
    # A first image that differs between the poses is still the first one: the branch itself.
    return f"q{joint + 1} image {rank + 1}" if rank else ""


def _out_of_limits(solutions: IKSolutions, tol: float) -> str:
    """The solution that is least far outside the limits, and its joints that are."""
    arm = solutions.arm
    turning = arm.chain.image_turns * ("turns" not in solutions.filters)
    image, out = limits.excess(solutions.to_array(), arm.limits, turning, tol)
    best = int(np.argmin(np.abs(out).max(axis=-1)))
    parts = []
    for i in np.flatnonzero(out[best]):
        unit = "rad" if solutions.rotary[i] else "m"
        side, limit = ("upper", arm.limits[i, 1]) if out[best, i] > 0.0 else ("lower", arm.limits[i, 0])
        margin = f", with a margin of {-tol:g} {unit}" if tol < 0.0 else ""
        parts.append(
            f"{arm.joint_names[i]!r} at {image[best, i]:.4f} {unit}, {abs(out[best, i]):.4g} {unit} beyond its "
            f"{side} limit of {limit:.4f} {unit}{margin}"
        )
    return f"the closest, {list(solutions)[best].branch}, has {' and '.join(parts)}"
