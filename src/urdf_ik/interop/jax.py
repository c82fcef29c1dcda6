"""``urdf_ik.jax.ik``: every branch as a differentiable function of jax, under ``jit`` and ``vmap`` too."""

from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError
from urdf_ik.interop.differentiable import KEPT, Answers, Branches, Differentiable, differentiable
from urdf_ik.interop.newton import step
from urdf_ik.support import extras


def geometry(arm: Arm) -> Any:
    """The numbers (p,) of an arm's URDF as an array, in the order of ``written(arm.chain).parameters``.

    Raises:
        MissingPackage: jax is not installed.
        ArgumentError: jax computes with 32 bits.

    Example:
        >>> import urdf_ik
        >>> urdf_ik.jax.geometry(urdf_ik.load("planar_2r")).shape  # doctest: +SKIP
        (26,)
    """
    return _jax().numpy.asarray(Differentiable(arm, "nan").geometry.values)


def ik(arm: Arm, T: Any, *, geometry: Any = None, redundancy: Any = None, at_folds: str = "raise") -> Branches:
    """Every solution of poses with derivatives: :func:`urdf_ik.torch.ik` for jax.

    jax calls :meth:`urdf_ik.Arm.ik` back. Works under ``jit``, ``vmap``, ``grad``, ``jvp``, ``jacfwd`` and ``jacrev``.

    Raises:
        MissingPackage: jax is not installed.
        ArgumentError: jax computes with 32 bits, a solution is singular, or an argument does not fit.
        PoseError: an invalid pose. Under ``jit`` jax raises its own error with this message.
        UnsupportedArm: the arm, or the arm with these numbers, has no such branches.

    Example:
        >>> import jax  # doctest: +SKIP
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> T = arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
        >>> jax.jacfwd(lambda T: urdf_ik.jax.ik(arm, T).q)(T).shape  # doctest: +SKIP
        (8, 6, 4, 4)
    """
    jnp = _jax().numpy
    T = jnp.asarray(T, dtype=jnp.float64)
    at = () if redundancy is None else (jnp.asarray(redundancy, dtype=jnp.float64),)
    function = differentiable(arm, at_folds)
    numbers = jnp.asarray(function.geometry.values) if geometry is None else jnp.asarray(geometry, dtype=jnp.float64)
    if numbers.ndim != 1:
        raise ArgumentError(f"geometry of shape {numbers.shape} given; one row of numbers is needed")
    return Branches(*_compiled(arm, at_folds)(T, numbers, *at))


@lru_cache(maxsize=KEPT)
def _compiled(arm: Arm, at_folds: str) -> Any:
    """The function of poses, numbers and redundancy parameters, compiled once for each shape."""
    jax = _jax()
    jnp = jax.numpy
    function = differentiable(arm, at_folds)
    n, k, rows = arm.dof, function.count, len(function.held)

    def answers(T: Any, numbers: Any, *at: Any) -> Answers:
        batch = T.shape[:-2]
        ranks = (T.ndim - 2, *(values.ndim - (k > 1) for values in at))

        def solved(*arrays: Any) -> Answers:
            return function.mapped(ranks, *map(np.asarray, arrays))

        if at:
            batch = jnp.broadcast_shapes(batch, at[0].shape[: at[0].ndim - (k > 1)])
        shape = (*batch, function.branches)
        like = Answers(
            jax.ShapeDtypeStruct((*shape, n), jnp.float64),
            jax.ShapeDtypeStruct((*shape, n, 6 + rows), jnp.float64),
            jax.ShapeDtypeStruct(shape, jnp.bool_),
        )
        still = [jax.lax.stop_gradient(each) for each in (T, numbers, *at)]
        return Answers(*jax.pure_callback(solved, like, *still, vmap_method="expand_dims"))

    @jax.custom_jvp  # type: ignore[untyped-decorator]
    def joints(start: Answers, T: Any, numbers: Any, *at: Any) -> Any:
        return start.q

    @joints.defjvp  # type: ignore[untyped-decorator]
    def followed(primals: Any, tangents: Any) -> Any:
        start, *moving = primals

        def stepped(T: Any, numbers: Any, *at: Any) -> Any:
            values = jnp.asarray(function.defaults) if not at else at[0] if k > 1 else at[0][..., None]
            return step(jnp, jnp.asarray, jax.lax.stop_gradient, function, start, T, numbers, values)

        return jax.jvp(stepped, tuple(moving), tuple(tangents[1:]))

    def branches(T: Any, numbers: Any, *at: Any) -> tuple[Any, Any]:
        start = answers(T, numbers, *at)
        return jnp.where(start.valid[..., None], joints(start, T, numbers, *at), jnp.nan), start.valid

    return jax.jit(branches)


def _jax() -> Any:
    try:
        jax: Any = import_module("jax")
    except ImportError:
        raise extras.missing("urdf_ik.jax needs jax", "jax") from None
    if not jax.config.jax_enable_x64:
        raise ArgumentError(
            "jax computes with 32 bits, which is too few for poses of 1e-9; call "
            "jax.config.update('jax_enable_x64', True) first"
        )
    return jax
