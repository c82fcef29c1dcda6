"""Threads, forks, bad input, unusual arrays, memory."""

import threading

import numpy as np
import pinocchio as pin
import pytest
from cases import Case, from_catalogue, member
from numpy.typing import NDArray

from urdf_ik import ArgumentError, PoseError, UrdfIkError

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


def entry(place: tuple[int, int], value: float) -> Array:
    """A pose, the identity, with one other entry."""
    out = np.eye(4)
    out[place] = value
    return out


NO_POSES: dict[str, Array] = {
    "NaN in the position": entry((0, 3), np.nan),
    "minus infinity in the rotation": entry((0, 0), -np.inf),
    "NaN in the last row": entry((3, 0), np.nan),
    "last row not 0 0 0 1": entry((3, 1), 1.0),
    "last row scaled": entry((3, 3), 2.0),
    "reflection": np.diag([1.0, 1.0, -1.0, 1.0]),
    "point reflection": np.diag([-1.0, -1.0, -1.0, 1.0]),
    "slightly scaled rotation": np.diag([1.001, 1.001, 1.001, 1.0]),
    "sheared rotation": entry((0, 1), 0.1),
    "zero rotation": np.diag([0.0, 0.0, 0.0, 1.0]),
}


@pytest.mark.parametrize("problem", NO_POSES)
@pytest.mark.parametrize("name", ["zyyzyz_6r", "ur5"])
def test_invalid_poses_are_refused(name: str, problem: str) -> None:
    """NaN, infinities, reflections, scaled or sheared rotations raise PoseError, in a batch with the first index."""
    case = arm_of(name)
    poses = poses_of(case, 6)
    bad = NO_POSES[problem]
    with pytest.raises(PoseError) as single:
        case.arm.ik(bad)
    assert single.value.index is None
    assert isinstance(single.value, UrdfIkError)
    poses[2], poses[4] = bad, bad
    for threads in (1, 2):
        with pytest.raises(PoseError) as stack:
            case.arm.ik(poses, threads=threads)
        assert stack.value.index == (2,)
    with pytest.raises(PoseError) as shaped:
        case.arm.ik(poses.reshape(2, 3, 4, 4))
    assert shaped.value.index == (0, 2)


@pytest.mark.parametrize(
    "q", [np.zeros(5), np.zeros((6, 5)), np.zeros(()), np.r_[np.zeros(5), np.nan], np.full(6, np.inf)]
)
def test_bad_joint_vectors_are_refused(q: Array) -> None:
    """fk, jacobian and the reference of ik want six finite numbers."""
    arm = arm_of("ur5").arm
    for call in (arm.fk, arm.jacobian, lambda x: arm.ik(np.eye(4), q_ref=x)):
        with pytest.raises(ArgumentError):
            call(q)


@pytest.mark.parametrize("name", ARMS)
def test_empty_batch(name: str) -> None:
    """A batch of no poses gives no solutions, in arrays of the matching shapes."""
    arm = arm_of(name).arm
    branches = len(arm.structure.branches)
    for shape in ((0,), (0, 3), (2, 0)):
        solutions = arm.ik(np.empty((*shape, 4, 4)))
        assert solutions.q.shape == (*shape, branches, 6)
        assert solutions.valid.shape == solutions.singular.shape == (*shape, branches)
        for reference in (np.zeros(6), np.empty((*shape, 6))):
            assert arm.ik_nearest(np.empty((*shape, 4, 4)), reference).q.shape == (*shape, 1, 6)
    assert arm.fk(np.empty((0, 6))).shape == (0, 4, 4)
    assert arm.jacobian(np.empty((0, 6))).shape == (0, 6, 6)


@pytest.mark.parametrize("name", ARMS)
def test_unusual_arrays(name: str) -> None:
    """Views, Fortran order, strides, read-only and other types give the same answers; inputs stay unchanged."""
    case = arm_of(name)
    poses = poses_of(case, 24)
    expected = case.arm.ik(poses).q
    read_only = poses.copy()
    read_only.setflags(write=False)
    padded = np.zeros((24, 5, 6))
    padded[:, :4, 1:5] = poses
    spread = np.zeros((48, 4, 4))
    spread[::2] = poses
    variants = {
        "as it is": poses,
        "read only": read_only,
        "Fortran order": np.asfortranarray(poses),
        "each transposed twice": np.ascontiguousarray(poses.swapaxes(1, 2)).swapaxes(1, 2),
        "window": padded[:, :4, 1:5],
        "every second": spread[::2],
        "backwards": poses[::-1].copy()[::-1],
        "big endian": poses.astype(">f8"),
        "extended": poses.astype(np.longdouble),
        "unaligned": np.frombuffer(b"x" + poses.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(24, 4, 4),
        "lists": poses.tolist(),
        "list of arrays": list(poses),
        "list of SE3": [pin.SE3(t) for t in poses],
    }
    for what, variant in variants.items():
        before = np.array([t.homogeneous if isinstance(t, pin.SE3) else t for t in variant])
        np.testing.assert_allclose(case.arm.ik(variant).q, expected, atol=1e-13, equal_nan=True, err_msg=what)
        after = np.array([t.homogeneous if isinstance(t, pin.SE3) else t for t in variant])
        np.testing.assert_array_equal(before, after, err_msg=what)
        one = case.arm.ik(variant[5]).q
        np.testing.assert_allclose(one, expected[5], atol=1e-12, equal_nan=True, err_msg=what)
