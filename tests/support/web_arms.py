"""The npm module under Node: what it answers for a compiled arm."""

import json
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from urdf_ik.export.page import WEB

Array = NDArray[np.float64]

NODE = shutil.which("node")
PROGRAMS = Path(__file__).resolve().parents[1] / "export" / "web"
NO_WASM = None if (WEB / "urdf_ik.wasm").is_file() else "WebAssembly is not tested: make wasm builds it"
needs_node = pytest.mark.skipif(
    NODE is None or NO_WASM is not None, reason=NO_WASM or "the npm module is not tested: apt install nodejs"
)


@dataclass(frozen=True)
class Answers:
    """What the npm module answers to m poses; see ``web/answers.mjs``.

    Attributes:
        q: (m, B, n) joint vectors, NaN where there is none.
        pose: (m, 4, 4) of the first solution, NaN where there is none.
        valid: (m, B).
        singular: (m, B).
        status: (m,), as ``IKSolutions.status``.
        branches: B names.
    """

    q: Array
    pose: Array
    valid: NDArray[np.bool_]
    singular: NDArray[np.bool_]
    status: list[str]
    branches: list[str]


def answers(file: Path, T: Array, values: Array | None = None) -> Answers:
    """The answers to poses (m, 4, 4) at redundancy parameters (m, p)."""
    m = len(T)
    given = np.concatenate([[m, values is not None], np.ravel(T), [] if values is None else np.ravel(values)])
    command = [str(NODE), str(PROGRAMS / "answers.mjs"), str(WEB / "urdf_ik.js"), str(file)]
    done = subprocess.run(command, input=given.tobytes(), capture_output=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr.decode()
    head, data = done.stdout.split(b"\n", 1)
    names = json.loads(head)
    n, B = len(names["joints"]), len(names["branches"])
    sizes = [m * B * n, 16 * m]
    q, pose = (np.frombuffer(data, count=size, offset=8 * at) for size, at in zip(sizes, (0, sizes[0]), strict=True))
    flags = np.frombuffer(data, np.uint8, offset=8 * sum(sizes))
    info, words = flags[: m * B].reshape(m, B), ("complete", "incomplete", "clustered", "continuum")
    return Answers(
        q.reshape(m, B, n),
        pose.reshape(m, 4, 4),
        info > 0,
        info == 3,
        [words[k] for k in flags[m * B :]],
        names["branches"],
    )


def refusal(file: Path) -> str:
    """What the module says of a file that it does not take."""
    command = [str(NODE), str(PROGRAMS / "answers.mjs"), str(WEB / "urdf_ik.js"), str(file)]
    done = subprocess.run(command, input=b"", capture_output=True, timeout=60, check=False)
    assert done.returncode == 1
    return done.stderr.decode()
