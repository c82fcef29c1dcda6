"""What general arms prove of their solutions, against complex kinematics in extended precision."""

from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from arms_general import crx_like, hc10_like, irb140_like, jaco_like, manseur_doty, unstructured
from cases import Case, described, nearest
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.errors import ArgumentError
from urdf_ik.ik.solutions import Proof

Array = NDArray[np.float64]
Long = NDArray[np.clongdouble]

MAKERS = {
    "random": lambda: unstructured(2),
    "manseur_doty": manseur_doty,
    "crx": crx_like,
    "hc10": hc10_like,
    "irb140": irb140_like,
    "jaco": jaco_like,
}


@lru_cache
def named(name: str) -> Case:
    """Load one of the arms."""
    return described(MAKERS[name]())


def rotation(axis: Array, angle: np.clongdouble) -> Long:
    """(3, 3) Rodrigues' formula, of a complex angle."""
    x, y, z = axis.astype(np.longdouble)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], np.clongdouble)
    return np.asarray(np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * (K @ K))


def tip(chain: Any, q: Long) -> tuple[Long, Long, Long]:
    """Rotation, position and geometric Jacobian (6, 6) of the tip at complex q (6,), in extended precision."""
    R, p = np.eye(3, dtype=np.clongdouble), chain.P[0].astype(np.clongdouble)
    axes, points = [], []
    for k in range(6):
        axes.append(R @ chain.H[k])
        points.append(p)
        R = R @ rotation(chain.H[k] / np.linalg.norm(chain.H[k].astype(np.longdouble)), q[k])
        p = p + R @ chain.P[k + 1]
    R = R @ chain.R_tip
    J = np.stack([np.concatenate([np.cross(a, p - b), a]) for a, b in zip(axes, points, strict=True)], axis=1)
    return R, p, J


def polished(chain: Any, target: Array, q: NDArray[np.complex128]) -> Long:
    """Newton's method on errors in extended precision: the root near q (6,)."""
    x = q.astype(np.clongdouble)
    for _ in range(4):
        R, p, J = tip(chain, x)
        E = target[:3, :3] @ R.T
        error = np.concatenate(
            [target[:3, 3] - p, 0.5 * np.array([E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]])]
        )
        x = x + np.linalg.solve(J.astype(np.complex128), error.astype(np.complex128))
    return x


def proofs(case: Case, Q: Array) -> list[tuple[Array, Any, Proof]]:
    """Target, solutions and proof of each pose."""
    found = []
    for target in case.arm.fk(Q):
        s = case.arm.ik(target)
        proof = s.proof
        assert proof is not None
        assert proof.status == s.status
        found.append((target, s, proof))
    return found


def apart(a: NDArray[np.complex128], b: NDArray[np.complex128]) -> float:
    """The greatest difference of two joint vectors in a joint, whole turns aside."""
    d = a - b
    turned = d.real - 2.0 * np.pi * np.round(d.real / (2.0 * np.pi))
    return float(np.abs(turned + 1j * d.imag).max())


@pytest.mark.parametrize("name", MAKERS)
def test_random_poses_are_proven_complete(name: str) -> None:
    """All sixteen complex solutions of at least 95 of 100 random poses are certified, most one by one."""
    case = named(name)
    s = case.arm.ik(case.arm.fk(np.random.default_rng(1).uniform(-np.pi, np.pi, (100, 6))))
    assert s.certain.sum() >= 95
    assert (s.status == "complete").sum() >= 90


@pytest.mark.parametrize("name", MAKERS)
def test_each_ball_holds_a_root_of_extended_precision(name: str) -> None:
    """Newton's method in 80 bits stays within the inner radius; balls are disjoint, and conjugates are there."""
    case = named(name)
    for target, _, proof in proofs(case, np.random.default_rng(2).uniform(-np.pi, np.pi, (4, 6))):
        if proof.status != "complete":
            continue
        assert proof.counted == proof.expected == len(proof.roots) == 16
        for k, root in enumerate(proof.roots):
            assert apart(polished(case.arm.chain, target, root).astype(np.complex128), root) <= proof.inner[k]
            assert (np.abs(root.imag).max() > proof.inner[k]) == (not proof.real[k])
            assert proof.real[k] or min(apart(root.conj(), other) for other in proof.roots) < 1e-14
        for k in range(16):
            for j in range(k):
                assert apart(proof.roots[k], proof.roots[j]) > proof.inner[k] + proof.inner[j]


@pytest.mark.parametrize("name", MAKERS)
def test_the_real_roots_are_the_solutions(name: str) -> None:
    """A complete answer has its real roots and no others."""
    case = named(name)
    for _, s, proof in proofs(case, np.random.default_rng(3).uniform(-np.pi, np.pi, (10, 6))):
        if proof.status == "complete":
            real, q = proof.roots[proof.real].real, s.to_array()
            assert len(real) == len(q) == s.count
            assert all(nearest(q, each) < 1e-12 for each in real)


def test_a_pose_out_of_reach_is_proven_unreachable() -> None:
    """Sixteen certified solutions, none of them real: the empty answer is complete."""
    case = named("random")
    target = case.arm.fk(np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]))
    target[:3, 3] *= 1.01 * case.arm.chain.size / np.linalg.norm(target[:3, 3])
    s = case.arm.ik(target)
    assert s.count == 0
    assert s.status == "complete"
    assert s.proof.counted == 16 and not s.proof.real.any()


@pytest.mark.parametrize("quarters", [(-1, -1, 2, 2, 2, 1), (-1, 1, 2, 0, 0, 2), (0, 1, 0, 2, 2, 0)])
def test_a_cusp_stands_for_three(quarters: tuple[int, ...]) -> None:
    """Three roots fall together; beside the pose three of sixteen leave by the cube root of how far it was moved."""
    case, q = named("irb140"), 0.5 * np.pi * np.array(quarters)
    T = case.arm.fk(q)
    s = case.arm.ik(T)
    assert s.status == "clustered"
    weakest = [np.linalg.svd(case.arm.jacobian(each), compute_uv=False)[-1] for each in s.to_array()]
    centre = s.to_array()[int(np.argmin(weakest))]
    U, weak, _ = np.linalg.svd(case.arm.jacobian(centre))
    assert weak[-1] < 1e-9
    away = []
    for moved in (1e-6, 8e-6):
        beside = T.copy()
        beside[:3, 3] += moved * U[:3, -1]
        beside[:3, :3] = (
            rotation(U[3:, -1] / np.linalg.norm(U[3:, -1]), np.clongdouble(moved * np.linalg.norm(U[3:, -1]))).real
            @ T[:3, :3]
        )
        proof = case.arm.ik(beside).proof
        assert proof.counted == len(proof.roots) == 16
        near = [apart(each, centre) for each in proof.roots if apart(each, centre) < 0.2]
        assert len(near) == 3
        away.append(np.mean(near))
    assert away[1] == pytest.approx(2.0 * away[0], rel=0.05)


# Next to this joint vector of the CRX-10iA/L four of eight solutions lie near double roots.
CRX = np.array([-1.08268, 3.03032, -1.54045, 1.89192, -2.88890, -1.66743])


@pytest.mark.parametrize("off", [0.0, *(s * 10.0**-k for k in range(3, 8) for s in (1, -1))])
def test_crx_beside_a_singular_vector_has_all_or_says_so(off: float) -> None:
    """A certain answer contains the planted joint vector and has eight solutions."""
    case = named("crx")
    q = CRX + np.array([0.0, 0.0, off, 0.0, 0.0, 0.0])
    s = case.arm.ik(case.arm.fk(q))
    assert not s.certain or nearest(s.to_array(), q) < 1e-5


def test_closed_forms_have_no_such_proof() -> None:
    """Closed forms prove otherwise, and a batch has one proof a pose."""
    arm = urdf_ik.load("puma_560")
    s = arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]))
    assert s.proof is None
    with pytest.raises(ArgumentError, match="take one"):
        _ = arm.ik(s.poses[None]).proof
