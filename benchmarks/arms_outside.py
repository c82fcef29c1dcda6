"""The arms and poses of comparisons outside Python: of a folder of URDFs, or those of this repository."""

import csv
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.errors import UrdfIkError
from urdf_ik.model import catalogue

Array = NDArray[np.float64]

ROOT = Path(__file__).resolve().parents[1]
GENERAL = str(ROOT / "benchmarks" / "urdf" / "kinova_j2n6s300.urdf")


def own_arms() -> Iterator[tuple[str, urdf_ik.Arm]]:
    """The bundled arms and those of the benchmarks."""
    files = sorted((ROOT / "benchmarks" / "urdf").glob("*.urdf"))
    yield from _loaded(
        [*((name, name, {}) for name in catalogue.BUNDLED), *((each.stem, str(each), {}) for each in files)]
    )


def arms_of(folder: Path) -> Iterator[tuple[str, urdf_ik.Arm]]:
    """Every arm of a folder that loads and has a solver; the others are named on stderr.

    With an index.csv these are its rows, urdf/NAME.urdf from base_link to tip_link; otherwise every URDF by itself.
    """
    index = folder / "index.csv"
    if not index.is_file():
        yield from _loaded((file.stem, str(file), {}) for file in sorted(folder.rglob("*.urdf")))
        return
    with open(index, newline="") as file:
        rows = list(csv.DictReader(file))
    yield from _loaded(
        (each["name"], f"{folder}/urdf/{each['name']}.urdf", {"base": each["base_link"], "tip": each["tip_link"]})
        for each in rows
    )


def _loaded(sources: Iterable[tuple[str, str, dict[str, str]]]) -> Iterator[tuple[str, urdf_ik.Arm]]:
    for name, source, ends in sources:
        try:
            arm = urdf_ik.load(source, **ends)
            arm.solver.require_member()
            yield name, arm
        except (UrdfIkError, OSError) as error:
            print(f"{name}: {str(error).splitlines()[0]}", file=sys.stderr)


def poses_of(arm: urdf_ik.Arm, many: int) -> Array:
    """Poses (many, 4, 4): random ones, round ones, and ones at singular joint vectors."""
    rng = np.random.default_rng(7)
    q = rng.uniform(-3.0, 3.0, (many, arm.dof))
    q[1::3] = np.round(q[1::3] / (np.pi / 4)) * (np.pi / 4)
    q[:, [kind == "prismatic" for kind in arm.chain.joint_types]] *= 0.1
    q[2::3] = singular(arm, q[2::3])
    return arm.fk(q)


def singular(arm: urdf_ik.Arm, q: Array) -> Array:
    """Joint vectors (m, n), one joint of each moved to where the least singular value of the Jacobian is least."""
    rows, centre, half = np.arange(len(q)), np.zeros(len(q)), np.pi
    joint = (1 + rows % max(1, arm.dof - 1)) % arm.dof
    for _ in range(10):
        places = centre[:, None] + half * np.linspace(-1.0, 1.0, 17)
        many = np.repeat(q[:, None], 17, axis=1)
        many[rows, :, joint] = places
        values = np.linalg.svd(arm.jacobian(many), compute_uv=False)[..., -1]
        centre, half = places[rows, values.argmin(axis=1)], half / 8
    moved = q.copy()
    moved[rows, joint] = centre
    return moved
