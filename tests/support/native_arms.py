"""Programs in C++ and C that solve compiled arms, built against the library beside the core."""

import json
import os
import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
from core_steps import FOLDER
from numpy.typing import NDArray

import urdf_ik
from urdf_ik import IKSolutions, _core
from urdf_ik.cmake import core

Array = NDArray[np.float64]

PROGRAMS = Path(__file__).resolve().parents[1] / "export" / "native"
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Werror")


def compiler(kind: str) -> str:
    """The C++ or C compiler: that of the environment, or of the system."""
    return os.environ.get(kind, {"CXX": "c++", "CC": "cc"}[kind])


@cache
def built(name: str) -> Path:
    """A program of ``tests/export/native``, linked with the library for C++ and C."""
    out = Path(mkdtemp(prefix="urdf_ik_")) / Path(name).stem
    include = f"-I{core() / 'library'}"
    if name.endswith(".c"):
        part = out.with_suffix(".o")
        run(compiler("CC"), "-std=c11", "-O1", *WARNINGS, include, "-c", str(PROGRAMS / name), "-o", str(part))
    else:
        part = PROGRAMS / name
    run(compiler("CXX"), "-std=c++20", "-O1", *WARNINGS, include, str(part), "-o", str(out),
        str(FOLDER / "liburdf_ik_library.a"))  # fmt: skip
    return out


def run(*command: str, given: bytes = b"", **env: str) -> subprocess.CompletedProcess[bytes]:
    """Run a program that must succeed."""
    env = {**os.environ, **env}
    done = subprocess.run(command, input=given, capture_output=True, timeout=600, check=False, env=env)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stderr.decode()}"
    return done


def refusal(file: Path, program: str = "solve.cpp") -> str:
    """What a program says of a file that it does not take."""
    done = subprocess.run([built(program), file], input=b"", capture_output=True, timeout=60, check=False)
    assert done.returncode == 1
    return done.stderr.decode()


@dataclass(frozen=True)
class Native:
    """What the C++ library answers to m poses; see ``native/solve.cpp``.

    Attributes:
        q: (m, B, n) joint vectors.
        flags: (m, B).
        status: (m,) as numbers.
        column: (m,) the column nearest to zero, or -1.
        nearest: (m, n) its image.
        pose: (m, 4, 4) of the first solution.
        J: (m, 6, n) its Jacobian.
        free: (m, p) its redundancy parameters.
        count: (m,) of its images inside the limits, -1 without a solution.
        images: (m, 4, n) the first of them.
        allocations: how many were made while solving.
    """

    q: Array
    flags: NDArray[np.uint8]
    status: NDArray[np.int64]
    column: NDArray[np.int64]
    nearest: Array
    pose: Array
    J: Array
    free: Array
    count: NDArray[np.int64]
    images: Array
    allocations: int


def solved(file: Path, T: Array, values: Array | None = None, q_ref: Array | None = None) -> Native:
    """The answers of the C++ library, at the instruction set in use, to poses (m, 4, 4)."""
    document = json.loads(file.read_text())
    m, n, B, p = len(T), len(document["joints"]), len(document["branches"]), len(document["parameters"])
    given = [np.array([m, values is not None, q_ref is not None], np.int64), np.ascontiguousarray(T)]
    given += [np.ascontiguousarray(each) for each in (values, q_ref) if each is not None]
    data = b"".join(each.tobytes() for each in given)
    done = run(str(built("solve.cpp")), str(file), given=data, URDF_IK_ISA=_core.isa())
    shapes = [(m, B, n), (m, 3), (m, n), (m, 4, 4), (m, 6, n), (m, p), (m, 4, n), (m, B)]
    arrays, at = [], 0
    for k, shape in enumerate(shapes):
        kind = np.dtype({1: np.int64, 7: np.uint8}.get(k, np.float64))
        count = int(np.prod(shape))
        arrays.append(np.frombuffer(done.stdout, kind, count, at).reshape(shape))
        at += count * kind.itemsize
    assert at == len(done.stdout)
    q, numbers, nearest, pose, J, free, images, flags = arrays
    return Native(
        q=q, flags=flags, status=numbers[:, 0], column=numbers[:, 1], nearest=nearest, pose=pose, J=J, free=free,
        count=numbers[:, 2], images=images, allocations=int(done.stderr.split()[0]),
    )  # fmt: skip


def flags_of(s: IKSolutions) -> NDArray[np.uint8]:
    """The flags (m, B) of Python's answer as C has them: validity, singularities, and the status in the first."""
    flags = s.valid.astype(np.uint8) | (np.where(s.valid, s.singular, 0).astype(np.uint8) << 1)
    status = {"complete": 0, "incomplete": 32, "clustered": 64, "continuum": 96}
    flags[:, 0] |= np.array([status[each] for each in s.status], np.uint8)
    return np.asarray(flags)


def targets(arm: urdf_ik.Arm, seed: int = 1, count: int = 40) -> tuple[Array, Array | None]:
    """Poses (m, 4, 4), random, round and singular, and values (m, p) of what they leave free."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-3.0, 3.0, (count, arm.dof))
    q[:, [kind == "prismatic" for kind in arm.chain.joint_types]] *= 0.1
    q[::4] = np.round(q[::4] / (np.pi / 4)) * (np.pi / 4)
    q[0] = 0.0
    T = arm.fk(q)
    return T, None if arm.redundancy is None else np.asarray(arm.solver.redundant_member.value_of(q, T))


def expected(arm: urdf_ik.Arm, T: Array, values: Array | None) -> urdf_ik.IKSolutions:
    """Python's answer to targets."""
    if values is None:
        return arm.ik(T)
    return arm.ik(T, redundancy=values[:, 0] if values.shape[1] == 1 else values)
