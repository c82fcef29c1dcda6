"""Threads, forks, bad input, unusual arrays, memory."""

import os
import pickle
import select
import signal
import threading
import warnings
from collections.abc import Callable

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


@pytest.mark.parametrize("name", ARMS)
def test_forked_process(name: str) -> None:
    """A process that was forked after use, threads included, answers like its parent."""
    case = arm_of(name)
    poses = poses_of(case, 5000)
    expected = case.arm.ik(poses, threads=2)
    receive, send = os.pipe()
    with warnings.catch_warnings():
        # Forking beside other threads is what is tested; Python 3.12 and later warn about it.
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        status = 1
        try:
            answers = [case.arm.ik(poses, threads=n) for n in (1, 2)]
            alone = case.arm.ik(poses[0])
            agree = all(
                same((a.q, a.valid, a.singular), (expected.q, expected.valid, expected.singular)) for a in answers
            )
            os.write(send, pickle.dumps((agree, alone.q)))
            status = 0
        finally:
            os._exit(status)
    os.close(send)
    try:
        ready, _, _ = select.select([receive], [], [], 60.0)
        if not ready:
            os.kill(child, signal.SIGKILL)
        assert ready, "the forked process hangs"
        with os.fdopen(receive, "rb", closefd=False) as stream:
            answer = stream.read()
    finally:
        os.close(receive)
        _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == 0
    agree, alone = pickle.loads(answer)
    assert agree
    np.testing.assert_array_equal(alone, case.arm.ik(poses[0]).q)


def test_same_input_same_output() -> None:
    """Asking twice gives the same bits, and a later answer does not overwrite an earlier one."""
    for name in ARMS:
        case = arm_of(name)
        poses = poses_of(case, 30)
        first = case.arm.ik(poses[0])
        kept = first.q.copy(), first.valid.copy(), first.singular.copy()
        for pose in poses[1:]:
            case.arm.ik(pose)
        case.arm.ik(poses)
        again = case.arm.ik(poses[0])
        assert same((first.q, first.valid, first.singular), kept)
        assert same((again.q, again.valid, again.singular), kept)


def _with(entry: tuple[int, int], value: float) -> Callable[[Array], Array]:
    """Set one entry of a pose."""

    def change(pose: Array) -> Array:
        out = pose.copy()
        out[entry] = value
        return out

    return change


def _times(matrix: Array) -> Callable[[Array], Array]:
    """Multiply a pose by a matrix from the right."""
    return lambda pose: pose @ matrix


NO_POSES: dict[str, Callable[[Array], Array]] = {
    "NaN in the position": _with((0, 3), np.nan),
    "NaN in the rotation": _with((1, 2), np.nan),
    "infinite position": _with((2, 3), np.inf),
    "minus infinity in the rotation": _with((0, 0), -np.inf),
    "NaN in the last row": _with((3, 0), np.nan),
    "last row not 0 0 0 1": _with((3, 1), 1.0),
    "last row scaled": _with((3, 3), 2.0),
    "reflection": _times(np.diag([1.0, 1.0, -1.0, 1.0])),
    "point reflection": _times(np.diag([-1.0, -1.0, -1.0, 1.0])),
    "scaled rotation": _times(np.diag([1.1, 1.1, 1.1, 1.0])),
    "slightly scaled rotation": _times(np.diag([1.001, 1.001, 1.001, 1.0])),
    "sheared rotation": _times(np.array([[1.0, 0.1, 0, 0], [0, 1.0, 0, 0], [0, 0, 1.0, 0], [0, 0, 0, 1.0]])),
    "zero rotation": _times(np.diag([0.0, 0.0, 0.0, 1.0])),
}


@pytest.mark.parametrize("problem", NO_POSES)
@pytest.mark.parametrize("name", ["zyyzyz_6r", "ur5"])
def test_invalid_poses_are_refused(name: str, problem: str) -> None:
    """NaN, infinities, reflections, scaled or sheared rotations raise PoseError, in a batch with the first index."""
    case = arm_of(name)
    poses = poses_of(case, 6)
    bad = NO_POSES[problem](poses[0])
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


def test_single_precision_and_integers() -> None:
    """Poses whose entries any number type holds exactly give the same answers in every type."""
    case = arm_of("zyyzyz_6r")
    pose = np.array([[0, 0, 1, 1], [0, 1, 0, 1], [-1, 0, 0, 2], [0, 0, 0, 1]])
    expected = case.arm.ik(pose.astype(np.float64))
    assert expected.valid.any()
    for kind in (np.float32, np.float16, np.longdouble, np.int64, np.int32):
        np.testing.assert_array_equal(case.arm.ik(pose.astype(kind)).q, expected.q)
