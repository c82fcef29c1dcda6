"""Arms of every family, solved in a process of its own for each instruction set; see test_core_levels."""

from collections.abc import Iterator
from pathlib import Path

import arms
import arms_closed_forms
import arms_few
import arms_general
import arms_seven
import numpy as np
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.model import catalogue

Array = NDArray[np.float64]


def every_arm() -> Iterator[tuple[str, urdf_ik.Arm]]:
    """By name, the bundled arms, and a random member of each family with oblique axes."""
    for name in catalogue.BUNDLED:
        yield name, urdf_ik.load(name)
    described = [arms.random_arm(kind, 0) for kind in arms.KINDS]
    described += [arms.random_arm(kind, 0, kinds=arms_closed_forms.KINDS) for kind in arms_closed_forms.KINDS]
    described += [arms_seven.random_seven(kind, 0) for kind in arms_seven.SEVEN]
    described += [arms_general.unstructured(0), arms_general.calibrated_ur(), arms_general.rounded_industrial()]
    for arm in described:
        yield arm.name, urdf_ik.load(arm.urdf, base="base", tip="tool")
    for build in arms_few.BUILDS_OF_ALL:
        yield build, arms_few.few(build).arm


def random_targets(arm: urdf_ik.Arm, m: int, seed: int) -> tuple[Array, Array]:
    """Poses (m, 4, 4) that the arm reaches, and what they leave free (m,), anywhere for an arm without limits."""
    rng = np.random.default_rng(seed)
    low, high = np.clip(np.nan_to_num(arm.limits, posinf=np.pi, neginf=-np.pi), -np.pi, np.pi).T
    q = rng.uniform(low, high, (m, arm.dof))
    return arm.fk(q), np.zeros(m) if arm.redundancy is None else arm.redundancy_of(q)


def solve(arm: urdf_ik.Arm, T: Array, free: Array, **how: int) -> tuple[Array, NDArray[np.uint8]]:
    """Joint vectors and flags, the redundancy parameter given where the arm has one."""
    s = arm.ik(T, **how) if arm.redundancy is None else arm.ik(T, redundancy=free, **how)
    return s.q, s.valid.astype(np.uint8) | s.singular.astype(np.uint8) << 1


def weakest(arm: urdf_ik.Arm, q: Array) -> Array:
    """Smallest singular values (...) of the Jacobian at joint vectors (..., n), lengths as shares of the arm's size."""
    size = arm.chain.size
    J = arm.jacobian(np.nan_to_num(q)) / np.array([size] * 3 + [1.0] * 3)[:, None]
    return np.linalg.svd(J * np.where(arm.chain.prismatic, size, 1.0), compute_uv=False)[..., min(6, arm.dof) - 1]


def solve_all(answers: str, targets: str, m: str) -> None:
    """Solve targets of every arm, made unless the file has them, and write what came out."""
    made = dict(np.load(targets)) if Path(targets).is_file() else {}
    found: dict[str, object] = {}
    for seed, (name, arm) in enumerate(every_arm()):
        if f"{name}/T" not in made:
            made[f"{name}/T"], made[f"{name}/free"] = random_targets(arm, int(m), seed)
        T, free = made[f"{name}/T"], made[f"{name}/free"]
        q, flags = solve(arm, T, free)
        found[f"{name}/q"], found[f"{name}/flags"], found[f"{name}/again"] = q, flags, ""
        found[f"{name}/weakest"] = weakest(arm, q)
        single = [solve(arm, *each) for each in zip(T, free, strict=True)]
        others = {
            "three threads": solve(arm, T, free, threads=3),
            "one by one": tuple(map(np.array, zip(*single, strict=True))),
            "another place": tuple(a[-7:] for a in solve(arm, np.roll(T, -7, axis=0), np.roll(free, -7))),
        }
        for how, (again, marks) in others.items():
            a, b = (q[:7], flags[:7]) if how == "another place" else (q, flags)
            differ = [i for i in range(len(a)) if a[i].tobytes() != again[i].tobytes() or (b[i] != marks[i]).any()]
            if differ:
                found[f"{name}/again"] = f"{name}: {how}, {len(differ)} poses of {len(a)}, such as {differ[:3]}"
    np.savez(targets, **made)
    np.savez(answers, **found)
