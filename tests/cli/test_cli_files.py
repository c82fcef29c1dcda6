"""Files that the urdf-ik command reads: poses and joint vectors in every documented form."""

import io
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from command import ARM, TYPED, Q, call, comma, oracle, strict_json, succeed
from numpy.typing import NDArray
from oracle import angle_distance

Array = NDArray[np.float64]


@pytest.mark.parametrize("kind", ["json", "csv", "npz"])
def test_fk_feeds_ik(kind: str) -> None:
    """The output of fk in every data format is input for ``ik --poses -``, which finds the joint vector again."""
    poses = call("fk", ARM, "--q", TYPED, "--q", comma(np.array(Q) / 2), "-f", kind).stdout_bytes
    answer = strict_json(succeed("ik", ARM, "--poses", "-", "-f", "json", given=poses))["poses"]
    for k, pose in enumerate(answer):
        found = np.array([one["q"] for one in pose["solutions"]])
        assert angle_distance(found, np.array(Q) / (k + 1)).min() < 1e-9


def _text(rows: Array) -> bytes:
    return "\n".join(",".join(map(repr, row)) for row in rows.tolist()).encode() + b"\n"


def _numpy(write: Callable[..., None], *alone: Array, **arrays: Array) -> bytes:
    out = io.BytesIO()
    write(out, *alone, **arrays)
    return out.getvalue()


POSE_FILES: dict[str, Callable[[Array, Array], bytes]] = {
    "npy (N, 16)": lambda T, _: _numpy(np.save, T.reshape(-1, 16)),
    "npy (N, 7)": lambda _, p: _numpy(np.save, p),
    "csv 16": lambda T, _: _text(T.reshape(-1, 16)),
    "csv 7": lambda _, p: _text(p),
}


@pytest.mark.parametrize("kind", POSE_FILES)
def test_poses_are_read_in_every_documented_form(kind: str) -> None:
    """The same poses, as matrices or with quaternions, in any format, are read as the same."""
    poses = oracle().poses(np.array([Q, np.array(Q) / 2, np.zeros(6)]))
    quats = np.array([pin.SE3ToXYZQUAT(pin.SE3(pose)) for pose in poses])
    content = POSE_FILES[kind](poses, quats)
    text = succeed("ik", ARM, "--no-check", "--poses", "-", "-f", "json", given=content)
    got = np.array([pose["pose"] for pose in strict_json(text)["poses"]])
    assert np.abs(got - poses).max() < 1e-12


def test_joint_vectors_are_read_in_every_documented_form(tmp_path: Path) -> None:
    """npy, npz, JSON and CSV, with and without a header, give Pinocchio's poses."""
    q = np.random.default_rng(1).uniform(-1.0, 1.0, (3, 6))
    names = [f"joint_{i}" for i in range(6, 0, -1)]
    contents = [
        _numpy(np.save, q),
        _numpy(np.savez, q=q, other=q[0]),
        json.dumps(q.tolist()).encode(),
        json.dumps({"q": q.tolist()}).encode(),
        _text(q),
        ",".join(names).encode() + b"\n" + _text(q[:, ::-1]),
    ]
    for content in contents:
        file = tmp_path / "vectors"
        file.write_bytes(content)
        poses = strict_json(succeed("fk", ARM, "--q", str(file), "-f", "json"))["poses"]
        assert np.abs(np.array([pose["pose"] for pose in poses]) - oracle().poses(q)).max() < 1e-12
