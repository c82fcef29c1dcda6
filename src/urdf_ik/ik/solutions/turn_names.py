"""Names of the images of a solution 2 pi apart, such as 'elbow up [q1+360°, q6-360°]'."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from urdf_ik.typing import Array


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
