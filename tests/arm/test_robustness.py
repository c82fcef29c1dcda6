"""Threads at once, and arrays of unusual layouts."""

import threading

import numpy as np
import pytest
from cases import Case, from_catalogue, member
from numpy.typing import NDArray

Array = NDArray[np.float64]
ARMS = ("zyyzyz_6r", "ur5", "wrist, general")


def arm_of(name: str) -> Case:
    """A family with eight columns, the UR's, and one that goes through the quartic."""
    return from_catalogue(name) if name in ("zyyzyz_6r", "ur5") else member(name, 1)


def poses_of(case: Case, m: int, seed: int = 1) -> Array:
    """Reachable poses (m, 4, 4), singular ones among them."""
    rng = np.random.default_rng(seed)
    q = case.oracle.draw(rng, m)
    q[::7, 4] = 0.0
    return case.oracle.poses(q)


def same(a: tuple[Array, ...], b: tuple[Array, ...]) -> bool:
    """Bit for bit the same answers."""
    return all(np.array_equal(x, y, equal_nan=x.dtype.kind == "f") for x, y in zip(a, b, strict=True))


@pytest.mark.parametrize("name", ARMS)
def test_eight_threads_at_once(name: str) -> None:
    """Eight threads that solve single poses and batches on one arm at the same time get what one thread gets."""
    case = arm_of(name)
    poses = poses_of(case, 120)

    def work(threads: int) -> tuple[Array, ...]:
        batch = case.arm.ik(poses, threads=threads)
        singles = [case.arm.ik(t) for t in poses]
        return batch.q, batch.valid, batch.singular, np.array([s.q for s in singles]), case.arm.fk(np.zeros((50, 6)))

    expected = work(1)
    results: dict[int, list[tuple[Array, ...]]] = {}
    start = threading.Barrier(8)

    def run(index: int) -> None:
        start.wait()
        results[index] = [work(1 + (index + repetition) % 2) for repetition in range(3)]

    workers = [threading.Thread(target=run, args=(i,)) for i in range(8)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert sorted(results) == list(range(8))
    assert all(same(answer, expected) for answers in results.values() for answer in answers)


@pytest.mark.parametrize("name", ARMS)
def test_unusual_arrays(name: str) -> None:
    """Views, Fortran order, strides and another byte order give the same answers; inputs stay unchanged."""
    case = arm_of(name)
    poses = poses_of(case, 24)
    expected = case.arm.ik(poses).q
    padded = np.zeros((24, 5, 6))
    padded[:, :4, 1:5] = poses
    variants = {
        "Fortran order": np.asfortranarray(poses),
        "each transposed twice": np.ascontiguousarray(poses.swapaxes(1, 2)).swapaxes(1, 2),
        "window": padded[:, :4, 1:5],
        "backwards": poses[::-1].copy()[::-1],
        "big endian": poses.astype(">f8"),
        "unaligned": np.frombuffer(b"x" + poses.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(24, 4, 4),
    }
    for what, variant in variants.items():
        np.testing.assert_allclose(case.arm.ik(variant).q, expected, atol=1e-13, equal_nan=True, err_msg=what)
        np.testing.assert_allclose(case.arm.ik(variant[5]).q, expected[5], atol=1e-12, equal_nan=True, err_msg=what)
        np.testing.assert_array_equal(variant, poses, err_msg=what)
