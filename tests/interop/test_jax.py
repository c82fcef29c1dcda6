"""``urdf_ik.jax.ik`` against jax's own numerical derivatives and against the package's."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik.errors import ArgumentError
from urdf_ik.interop.differentiable import Differentiable

jax = pytest.importorskip("jax", reason="jax is not installed: pip install 'urdf-ik[jax]'")

pytestmark = pytest.mark.slow
SIX = urdf_ik.load("zyyzyz_6r")
T = SIX.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])


@pytest.fixture(autouse=True)
def double() -> Iterator[None]:
    """64 bits while a test runs."""
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", before)


def test_check_grads_of_both_modes_and_both_orders() -> None:
    """Entries of the pose change one by one."""
    from jax.test_util import check_grads

    check_grads(lambda T: urdf_ik.jax.ik(SIX, T).q, (T,), order=2, eps=1e-6, atol=1e-3, rtol=1e-3)


def test_jit_vmap_and_the_urdf() -> None:
    """Under jit and vmap the values are those of ik, the derivatives those of dq_dT and dq_dgeometry."""
    s = SIX.ik(np.stack([T, T]))
    found = jax.jit(jax.vmap(lambda T: urdf_ik.jax.ik(SIX, T)))(np.stack([T, T]))
    np.testing.assert_allclose(found.q, s.q, atol=1e-12)
    np.testing.assert_array_equal(found.valid, s.valid)
    J = jax.jit(jax.jacfwd(lambda T: urdf_ik.jax.ik(SIX, T).q))(T)
    np.testing.assert_allclose(J[..., :3, 3], s.dq_dT()[0, ..., :3], atol=1e-9)
    G = jax.jacrev(lambda g: urdf_ik.jax.ik(SIX, T, geometry=g).q)(urdf_ik.jax.geometry(SIX))
    np.testing.assert_allclose(G, s.dq_dgeometry()[0], atol=1e-9)


def test_vmap_is_one_call_for_all_poses(monkeypatch: pytest.MonkeyPatch) -> None:
    """Poses, angles and geometries under vmap, one of them or together, nested, beside a batch: those of each."""
    arm = SIX.with_free_axis("z")
    poses = arm.fk(np.random.default_rng(0).uniform(-1.0, 1.0, (3, 2, 6)))
    angles, numbers = np.array([0.1, 0.2, 0.3]), urdf_ik.jax.geometry(arm)

    def ik(T: Any, at: Any, g: Any = None) -> Any:
        return urdf_ik.jax.ik(arm, T, redundancy=at, geometry=g).q

    expected = np.stack([ik(T, at) for T, at in zip(poses, angles, strict=True)])
    calls: list[int] = []
    answers = Differentiable.answers
    monkeypatch.setattr(Differentiable, "answers", lambda *given: calls.append(1) or answers(*given))
    np.testing.assert_array_equal(jax.vmap(ik)(poses, angles), expected)
    np.testing.assert_array_equal(jax.vmap(jax.vmap(ik, (0, None)))(poses, angles), expected)
    np.testing.assert_array_equal(jax.vmap(ik, (None, 0))(poses[0], angles)[0], expected[0])
    np.testing.assert_array_equal(jax.vmap(ik, (0, None))(poses[:, 0], angles)[1, 1], ik(poses[1, 0], 0.2))
    assert len(calls) == 5
    several = numbers + np.array([[0.0], [1e-4]])
    found = jax.vmap(ik, (None, None, 0))(poses[0], 0.1, several)
    np.testing.assert_array_equal(found[0], expected[0])
    np.testing.assert_array_equal(found[1], ik(poses[0], 0.1, several[1]))


def test_single_precision_is_refused_in_words() -> None:
    """The error says which setting is needed."""
    jax.config.update("jax_enable_x64", False)
    with pytest.raises(ArgumentError, match="jax_enable_x64"):
        urdf_ik.jax.ik(SIX, T)
