"""Names of solutions where geometry gives none: the sign of the Jacobian's determinant, and a number.

The determinant cannot change its sign on a motion that crosses no singularity, so the sign is a name that lasts: such a
motion never joins solutions of two signs, in whatever pose. Without joint limits a pose has as many regular solutions
of one sign as of the other: the signs sum to the degree of the map from joint vectors to poses, which is 0, since poses
out of reach have no solution. The number after the sign orders one pose's solutions and says nothing about another
pose; along a path :func:`urdf_ik.paths.planned_motion.followed` keeps it.
"""

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics.chain.redundancy import LOCKED_JOINT
from urdf_ik.kinematics.chain.serial import filled
from urdf_ik.typing import Array

_LOCAL = ("solution ", "further ", "position ")
# Rows of the Jacobian by the task; there is a determinant where as many joints move.
_ROWS = {"pose": 6, "position": 3}
_SIGNS = np.array(["", "determinant +, ", "determinant -, "], dtype=np.object_)


@cache
def local(branches: tuple[str, ...]) -> bool:
    """Whether some of the names are only numbers."""
    return any(name.startswith(_LOCAL) for name in branches)


def signed(names: NDArray[np.object_], q: Array, singular: NDArray[np.uint8], solver: Solver) -> NDArray[np.object_]:
    """Names (..., B) of solutions (..., B, n), the local ones with the determinant's sign before the number.

    Without a sign stay: names that geometry gives, singular solutions, places without one, and all where a pose does
    not take as many joints as it has numbers.
    """
    if (signs := determinant_signs(solver, q)) is None:
        return names
    numbered = np.frompyfunc(lambda name: name.startswith(_LOCAL), 1, 1)(names).astype(bool)
    return np.asarray(_SIGNS[np.where(numbered & (singular == 0), signs, 0)] + names)


def square(solver: Solver) -> list[int] | None:
    """The joints that move, where the task has as many numbers: only there is a determinant. None elsewhere."""
    held = {each.joint for each in solver.parameters if each.kind == LOCKED_JOINT}
    moving = [k for k, name in enumerate(solver.joint_names) if name not in held]
    others = len(solver.parameters) > len(held)
    return None if others or len(moving) != _ROWS.get(solver.task) else moving


def determinant_signs(solver: Solver, q: Array) -> NDArray[np.int8] | None:
    """(...) 1 or -1, the sign of the Jacobian's determinant at joint vectors (..., n); 0 for rows of NaN.

    The Jacobian is that of the task: of a pose, or of the position of three joints. Joints whose values are redundancy
    parameters are left out. None where the task has another number of rows than joints are left, or is another one.
    """
    if (moving := square(solver)) is None:
        return None
    whole, gone = filled(q)
    J = np.array(solver.chain.jacobian(whole))[..., : len(moving), moving]
    J[..., :3, :] /= solver.chain.size
    signs = np.where(gone, 0, np.sign(np.linalg.det(J)))
    return np.asarray(signs, dtype=np.int8)


def is_local(name: Any) -> bool:
    """Whether a name of one solution ends in a number that only its own pose explains."""
    return str(name).removeprefix(_SIGNS[1]).removeprefix(_SIGNS[2]).startswith(_LOCAL)


def short(branch: str) -> str:
    """'shoulder front, elbow up' as 'front, up'; a name that is a number stays."""
    return branch if is_local(branch) else ", ".join(part.split(" ")[-1] for part in branch.split(", "))


def sign_in_words(sign: int) -> str:
    """The beginning of a name: 'determinant +, ', 'determinant -, ', or '' for 0."""
    return str(_SIGNS[sign])


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


def _image(joint: int, rank: int, least: float, most: float) -> str:
    """One joint's part of a column's name."""
    if least == most:
        return f"q{joint + 1}{360 * int(least):+d}°" if least else ""
    # A first image that differs between the poses is still the first one: the branch itself.
    return f"q{joint + 1} image {rank + 1}" if rank else ""
