#!/usr/bin/env python3
"""Derivatives of every solution: against Pinocchio, against differences of the solver, and what they cost.

    python benchmarks/derivatives.py FOLDER [--poses N] [--seed S]     # every arm of a folder of URDFs
    python benchmarks/derivatives.py --cost [--repeats R]              # the time of ik and of dq_dT in a batch

Solutions of N random poses an arm count where Pinocchio's Jacobian (of the URDF file itself) is regular: its smallest
singular value, lengths as shares of the arm's size, above 0.02, with redundancy parameters held too. ``inverse``:
|J X - 1| / |J||X|, J Pinocchio's; with fewer than six joints |X J - 1|. ``difference``: central differences of ik
itself over three steps, extrapolated (Richardson), by random twists, relative to |X|.
"""

import argparse
import gc
import sys
import time
import warnings
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import UrdfIkError

REGULAR, STEP = 0.02, 0.02


def shifted(T: Any, twist: Any, steps: Any) -> Any:
    """Targets (m, B, 4, 4): poses (m, 4, 4) moved by a twist in base axes at their origins, each by its step (m, B)."""
    out = np.repeat(T[:, None], steps.shape[1], axis=1)
    out[..., :3, 3] += steps[..., None] * twist[:3]
    turns = urdf_ik.pose(np.zeros((*steps.shape, 3)), rotvec=steps[..., None] * twist[3:])
    out[..., :3, :3] = turns[..., :3, :3] @ out[..., :3, :3]
    return out


def beside(arm: Any, found: Any, q: Any) -> Any:
    """The solutions (m, B, n) nearest to joint vectors (m, B, n), each among those (m, B, B, n) of its own target.

    One step of Newton's method more than the solver takes makes their error that of rounding.
    """
    gaps = found.q - q[:, :, None]
    gaps = np.where(arm.chain.prismatic, gaps, (gaps + np.pi) % (2.0 * np.pi) - np.pi)
    size = np.abs(gaps).max(axis=-1)
    best = np.where(np.isnan(size), np.inf, size).argmin(axis=-1)[..., None, None]
    near = q + np.take_along_axis(gaps, best, axis=2)[:, :, 0]
    lost = np.isnan(near)
    reached = arm.fk(np.where(lost, 0.0, near))
    turn = found.poses[..., :3, :3] @ np.swapaxes(reached[..., :3, :3], -1, -2)
    spin = 0.5 * (turn - np.swapaxes(turn, -1, -2))[..., [2, 0, 1], [1, 2, 0]]
    off = np.concatenate([found.poses[..., :3, 3] - reached[..., :3, 3], spin], axis=-1)
    X = np.take_along_axis(found.dq_dT(), best[..., None], axis=2)[:, :, 0]
    return near + (X @ off[..., None])[..., 0]


def measured(arm: Any, poses: int, rng: np.random.Generator) -> tuple[int, float, float]:
    """Number of regular solutions, and the greatest relative errors against Pinocchio and against differences."""
    limits = np.clip(arm.limits, -np.pi, np.pi)
    q = rng.uniform(limits[:, 0], limits[:, 1], (poses, arm.dof))
    T = arm.fk(q)
    at: dict[str, Any] = {"redundancy": arm.redundancy_of(q)} if arm.solver.parameters else {}
    s = arm.ik(T, **at)
    X, slides, size = s.dq_dT(), arm.chain.prismatic, arm.chain.size
    good = s.valid & ~np.isnan(X).any(axis=(-2, -1))
    J = Reference(arm.model, arm.base, arm.tip).jacobian(s.q[good])
    share, own = np.where(np.arange(6) < 3, 1.0 / size, 1.0), np.where(slides, size, 1.0)
    scaled = J * share[:, None] * own
    least = np.linalg.svd(scaled, compute_uv=False)[:, -1]
    # Where the parameter is held, the inverse of the whole system may be large at a regular Jacobian.
    Y = X[good] / own[:, None] / share
    length = np.linalg.norm(Y, axis=(-2, -1))
    regular = (least > REGULAR) & (length < np.sqrt(6.0) / REGULAR)
    if not regular.any():
        return 0, 0.0, 0.0
    product = scaled @ Y if arm.dof >= 6 else Y @ scaled
    off = np.abs(product - np.eye(product.shape[-1])).max(axis=(-2, -1))
    off /= np.linalg.norm(scaled, axis=(-2, -1)) * length
    steady = np.zeros(s.valid.shape, np.bool_)
    steady[good] = regular
    reference = np.abs(X).max(axis=(-2, -1))
    # An inverse of length L changes by a share of L^2 h within a step h.
    steps = np.where(steady, STEP / np.where(steady, np.linalg.norm(X, axis=(-2, -1)), 1.0) ** 2, 0.0)
    if at:
        at = {"redundancy": np.broadcast_to(at["redundancy"][:, None], (*steps.shape, *at["redundancy"].shape[1:]))}
    worst = 0.0
    for _ in range(2):
        motion = rng.normal(size=min(arm.dof, 6))
        ends = []
        for share_of_step in (1.0, 0.5, 0.25):
            near = []
            for h in (-share_of_step * steps, share_of_step * steps):
                # With fewer joints only twists that the arm can follow, from the joints that made the pose.
                to = arm.fk(q[:, None] + h[..., None] * motion) if arm.dof < 6 else shifted(T, motion, h)
                near.append(beside(arm, arm.ik(to, **at), s.q))
            ends.append((near[1] - near[0]) / np.where(steady, 2.0 * share_of_step * steps, 1.0)[..., None])
        finer = [(4.0 * ends[k + 1] - ends[k]) / 3.0 for k in (0, 1)]
        change = (16.0 * finer[1] - finer[0]) / 15.0
        twist = motion if arm.dof >= 6 else (arm.jacobian(q) @ motion)[:, None]
        ours = (X @ twist[..., None] if arm.dof < 6 else X @ twist).reshape(change.shape)
        error = np.abs(change - ours).max(axis=-1) / reference
        worst = max(worst, float(np.where(steady, error, 0.0).max()))
    return int(regular.sum()), float(off[regular].max()), worst


def against_pinocchio(folder: Path, poses: int, seed: int) -> int:
    """Every URDF of a folder that loads with its defaults, or as its index says."""
    rng, total, arms, worst = np.random.default_rng(seed), 0, 0, [0.0, 0.0]
    print(f"{'arm':34} {'family':44} solutions  inverse  difference")
    ends = index(folder)
    for path in sorted(folder.glob("**/*.urdf")):
        try:
            arm = urdf_ik.load(path, **ends.get(path.stem, {}))
            arm.solver.require_member()
            count, inverse, difference = measured(arm, poses, rng)
        except UrdfIkError as error:
            print(f"{path.stem[:34]:34} not measured: {str(error).splitlines()[0][:90]}")
            continue
        arms, total = arms + 1, total + count
        worst = [max(worst[0], inverse), max(worst[1], difference)]
        print(
            f"{path.stem[:34]:34} {str(arm.structure.family)[:44]:44} {count:9} {inverse:.1e} {difference:11.1e}",
            flush=True,
        )
    print(f"{arms} arms, {total} regular solutions of {poses} poses each")
    print(f"greatest relative error: inverse {worst[0]:.1e}, difference {worst[1]:.1e}")
    return 0 if max(worst) <= 1e-6 else 1


def index(folder: Path) -> dict[str, dict[str, str]]:
    """Base and tip of each arm, from an index.csv in the folder or above it."""
    import csv

    found = next((at for at in (folder / "index.csv", folder.parent / "index.csv") if at.exists()), None)
    if found is None:
        return {}
    rows = csv.DictReader(found.read_text().splitlines())
    return {row["name"]: {"base": row["base_link"], "tip": row["tip_link"]} for row in rows if row["tip_link"]}


def cost(repeats: int) -> int:
    """Least processor time of many repeats, ik and dq_dT of the same batch in turn."""
    gc.disable()
    print(f"{'arm':16} {'family':36} poses     ik  dq_dT [us a pose]  (ik + dq_dT) / ik")
    for name in ("planar_2r", "scara_rrpr", "zyyzyz_6r", "ur5", "dh_6r", "panda", "srs_7r"):
        arm = urdf_ik.load(name)
        poses = 1000 if name != "dh_6r" else 200
        T = arm.fk(np.random.default_rng(0).uniform(-1.5, 1.5, (poses, arm.dof)))
        answer, least = arm.ik(T), [np.inf, np.inf]
        for _ in range(repeats):
            for k, work in enumerate((partial(arm.ik, T), answer.dq_dT)):
                start = time.process_time()
                work()
                least[k] = min(least[k], time.process_time() - start)
        ik, derivative = (each / poses * 1e6 for each in least)
        family = str(arm.structure.family)[:36]
        print(f"{name:16} {family:36} {poses:5} {ik:6.3f} {derivative:6.3f} {'':12} {(ik + derivative) / ik:.2f}")
    return 0


def main() -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("--poses", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cost", action="store_true")
    parser.add_argument("--repeats", type=int, default=30)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    if options.cost:
        return cost(options.repeats)
    if options.folder is None:
        parser.error("a folder of URDFs is needed, or --cost")
    return against_pinocchio(options.folder, options.poses, options.seed)


if __name__ == "__main__":
    sys.exit(main())
