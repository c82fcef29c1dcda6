"""``urdf_ik.torch.ik``: every branch as a differentiable function of torch, by both modes, of any order up to two."""

from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError
from urdf_ik.interop.differentiable import Answers, Branches, Differentiable, differentiable
from urdf_ik.interop.newton import step
from urdf_ik.support import extras


def geometry(arm: Arm) -> Any:
    """The numbers (p,) of an arm's URDF as a tensor, in the order of ``written(arm.chain).parameters``.

    Raises:
        MissingPackage: torch is not installed.

    Example:
        >>> import urdf_ik
        >>> urdf_ik.torch.geometry(urdf_ik.load("planar_2r")).shape  # doctest: +SKIP
        torch.Size([26])
    """
    return _torch().tensor(Differentiable(arm, "nan").geometry.values.copy())


def ik(arm: Arm, T: Any, *, geometry: Any = None, redundancy: Any = None, at_folds: str = "raise") -> Branches:
    """Every solution of poses, with derivatives by the poses, the URDF's numbers and the redundancy parameters.

    The solutions are those of :meth:`urdf_ik.Arm.ik`. Two steps of Newton's method with the inverse at the solution,
    which change nothing, carry the derivatives: they are exact up to the second order (implicit function theorem).
    Works under ``torch.func`` (``grad``, ``jvp``, ``vmap``, ``jacrev``).

    Args:
        arm: the arm.
        T: (..., 4, 4) tensor of poses [m], float64. Its entries may change one by one: what counts is the nearest pose.
        geometry: (p,) tensor of the URDF's numbers, see :func:`geometry`; default: as written.
        redundancy: (...) tensor or numbers, (..., k) of k parameters; default: the arm's.
        at_folds: 'raise': a singular solution is refused in words; 'nan': its derivative is NaN; 'clip': its derivative
            is that of damped least squares.

    Returns:
        q (..., B, n), NaN where there is no solution, and valid (..., B): ``q[valid]`` has derivatives. Columns are the
        arm's branches, in their order.

    Raises:
        MissingPackage: torch is not installed.
        PoseError: an invalid pose.
        ArgumentError: a solution is singular, or an argument does not fit.
        UnsupportedArm: the arm, or the arm with these numbers, has no such branches.

    Example:
        >>> import torch  # doctest: +SKIP
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> T = torch.tensor(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]), requires_grad=True)  # doctest: +SKIP
        >>> urdf_ik.torch.ik(arm, T).q.sum().backward()  # doctest: +SKIP
    """
    torch = _torch()
    function = differentiable(arm, at_folds)
    numbers = torch.as_tensor(function.geometry.values.copy()) if geometry is None else geometry
    if numbers.dim() != 1:
        raise ArgumentError(f"geometry of shape {tuple(numbers.shape)} given; one row of numbers is needed")
    at = None if redundancy is None else torch.as_tensor(redundancy, dtype=torch.float64)
    still = [each.detach() for each in (T, numbers, at) if each is not None]
    ranks = (T.dim() - 2,) if at is None else (T.dim() - 2, at.dim() - (function.count > 1))
    start = Answers(*_solve().apply(function, ranks, *still))

    def constant(numbers: Any) -> Any:
        return torch.as_tensor(np.array(numbers), dtype=torch.float64)

    values = constant(function.defaults) if at is None else at if function.count > 1 else at[..., None]
    q = step(torch, constant, lambda each: each.detach(), function, start, T, numbers, values)
    return Branches(torch.where(start.valid[..., None], q, torch.nan), start.valid)


@cache
def _solve() -> Any:
    """The solver as a function of torch without a derivative."""
    torch = _torch()

    function: Any = torch.autograd.Function

    class Solve(function):  # type: ignore[misc]
        @staticmethod
        def forward(function: Differentiable, ranks: tuple[int, ...], *arrays: Any) -> tuple[Any, ...]:
            found = function.mapped(ranks, *(each.cpu().numpy() for each in arrays))
            return tuple(torch.as_tensor(each) for each in found)

        @staticmethod
        def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
            ctx.mark_non_differentiable(*output)

        @staticmethod
        def vmap(info: Any, dims: Any, function: Differentiable, ranks: tuple[int, ...], *arrays: Any) -> Any:
            first = (
                each[None] if dim is None else each.movedim(dim, 0) for each, dim in zip(arrays, dims[2:], strict=True)
            )
            return Solve.apply(function, ranks, *first), (0, 0, 0)

    return Solve


def _torch() -> Any:
    try:
        return import_module("torch")
    except ImportError:
        raise extras.missing("urdf_ik.torch needs torch", "torch") from None
