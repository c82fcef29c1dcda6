"""A batch shared among plain Python threads; the kernels release the interpreter's lock."""

from __future__ import annotations

import threading
from collections.abc import Callable

from urdf_ik._kernels.layout import BLOCK


def in_shares(solve: Callable[[slice], int], m: int, threads: int) -> int:
    """Let ``solve`` work through ``m`` poses, in shares of whole blocks.

    Every pose is then solved by the same instructions, however many threads there are.

    Args:
        solve: solves the poses of a slice; index in it of the first bad pose, or -1.
        m: number of poses.
        threads: number of threads, this one included.

    Returns:
        Index of the first bad pose, or -1.
    """
    if threads <= 1 or m < 2 * BLOCK * threads:
        return solve(slice(0, m))
    bad = [-1] * threads
    failed: list[BaseException] = []
    edges = [BLOCK * (k * (m // BLOCK) // threads) for k in range(threads)] + [m]

    def share(k: int) -> None:
        try:
            found = solve(slice(edges[k], edges[k + 1]))
        except BaseException as error:  # a thread would swallow it, and leave its share unsolved
            failed.append(error)
            return
        bad[k] = edges[k] + found if found >= 0 else -1

    helpers = [threading.Thread(target=share, args=(k,)) for k in range(1, threads)]
    for helper in helpers:
        helper.start()
    share(0)
    for helper in helpers:
        helper.join()
    if failed:
        raise failed[0]
    return min((index for index in bad if index >= 0), default=-1)
