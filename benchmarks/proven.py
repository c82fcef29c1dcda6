#!/usr/bin/env python3
"""How often an answer is proven, by arm and by kind of pose: the shares of each status.

    python benchmarks/proven.py SET ... [--poses N] [--seed S] [--only NAME ...] [--all | --check] [--md]

SET is a folder with index.csv (name, base_link, tip_link) and urdf/. Arms whose six joints turn are asked; --all asks
those of other kinds too. Kinds of pose:

    random   joint vectors over the whole torus
    near     1e-4 rad, in a random direction, from a joint vector at which the Jacobian's determinant changes its sign
    round    each joint at a multiple of 90 degrees
    down     the tool's z axis down and its x axis along an axis of the base, where a random joint vector reaches

A cell holds the per cent of complete / clustered / continuum / incomplete; with --check the answers, complete or
clustered, that an independent check accepts / leaves open / refuses, which takes half a second a pose.
"""

import argparse
import csv
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import urdf_ik
import urdf_ik.verify

STATUSES = ("complete", "clustered", "continuum", "incomplete")
KINDS = ("random", "near", "round", "down")
OFF = 1e-4  # rad from a singularity


def main() -> None:
    """Print a line for each arm, then the shares over all of them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sets", nargs="+", type=Path)
    parser.add_argument("--poses", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="*", help="names of arms")
    parser.add_argument("--kinds", nargs="*", default=list(KINDS), choices=KINDS)
    parser.add_argument("--all", action="store_true", help="arms of other kinds than six turning joints too")
    parser.add_argument("--check", action="store_true", help="check the proofs (needs python-flint)")
    parser.add_argument("--md", action="store_true", help="print a table for the docs")
    options = parser.parse_args()
    bar = " | " if options.md else "  "
    edge = "|" if options.md else ""
    print(f"{edge} {'arm':<28}{bar}{bar.join(f'{kind:<21}' for kind in options.kinds)} {edge}")
    if options.md:
        print(f"|---|{'---|' * len(options.kinds)}")
    ask = _checked if options.check else _shares
    sums = {kind: np.zeros(3 if options.check else len(STATUSES)) for kind in options.kinds}
    for name, arm in _arms(options.sets, options.only, options.all):
        cells = []
        for kind in options.kinds:
            rng = np.random.default_rng([options.seed, KINDS.index(kind)])
            counts = ask(arm, _poses(arm, kind, options.poses, rng))
            sums[kind] += counts
            cells.append(_cell(counts))
        print(f"{edge} {name:<28}{bar}{bar.join(cells)} {edge}", flush=True)
    print(f"{edge} {'all':<28}{bar}{bar.join(_cell(counts) for counts in sums.values())} {edge}")


def _arms(sets: list[Path], only: list[str] | None, every: bool) -> Iterator[tuple[str, urdf_ik.Arm]]:
    for folder in sets:
        with (folder / "index.csv").open() as rows:
            for row in csv.DictReader(rows):
                if only and row["name"] not in only:
                    continue
                try:
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore")
                        file = folder / "urdf" / f"{row['name']}.urdf"
                        arm = urdf_ik.load(str(file), base=row["base_link"] or None, tip=row["tip_link"] or None)
                    arm.ik(arm.fk(np.zeros(arm.dof)))
                except urdf_ik.UrdfIkError:
                    continue
                if every or str(arm.structure).startswith("6 joints (RRRRRR)"):
                    yield row["name"], arm


def _shares(arm: urdf_ik.Arm, T: np.ndarray) -> np.ndarray:
    """How many poses have each status."""
    status = np.asarray(arm.ik(T).status)
    return np.array([np.count_nonzero(status == each) for each in STATUSES], dtype=float)


def _checked(arm: urdf_ik.Arm, T: np.ndarray) -> np.ndarray:
    """How many claims are accepted, open and refused."""
    report = urdf_ik.verify.check_proof(arm, arm.ik(T))
    return np.array([report.accepted, len(report.open), len(report.refused)], dtype=float)


def _cell(counts: np.ndarray) -> str:
    numbers = [f"{100.0 * n / counts.sum():.1f}" if len(counts) == len(STATUSES) else f"{n:.0f}" for n in counts]
    return " / ".join(numbers).ljust(21)


def _poses(arm: urdf_ik.Arm, kind: str, n: int, rng: np.random.Generator) -> np.ndarray:
    if kind == "round":
        return np.asarray(arm.fk(rng.integers(-1, 3, (n, arm.dof)) * (np.pi / 2)))
    q = rng.uniform(-np.pi, np.pi, (n, arm.dof))
    if kind == "near" and arm.dof == 6:
        d = rng.normal(size=(n, 6))
        q = _singular(arm, n, rng) + OFF * d / np.linalg.norm(d, axis=1, keepdims=True)
    T = np.array(arm.fk(q))
    if kind == "down":
        turn = rng.integers(4, size=n) * (np.pi / 2)
        x = np.stack([np.cos(turn).round(), np.sin(turn).round(), np.zeros(n)], 1)
        z = np.array([0.0, 0.0, -1.0])
        T[:, :3, :3] = np.stack([x, np.cross(z, x), np.broadcast_to(z, (n, 3))], 2)
    return T


def _singular(arm: urdf_ik.Arm, n: int, rng: np.random.Generator) -> np.ndarray:
    """Joint vectors (n, 6) at which the determinant changes its sign along one joint, by bisection."""
    found: list[np.ndarray] = []
    values = np.linspace(-np.pi, np.pi, 65)
    for _ in range(50 * n):
        if len(found) == n:
            break
        joint = int(rng.integers(1, 5))
        line = np.tile(rng.uniform(-np.pi, np.pi, 6), (65, 1))
        line[:, joint] = values
        sign = np.sign(np.linalg.det(arm.jacobian(line)))
        at = np.flatnonzero(sign[:-1] * sign[1:] < 0)
        if not len(at):
            continue
        k = int(rng.choice(at))
        low, high = line[k].copy(), line[k + 1].copy()
        for _ in range(60):
            middle = (low + high) / 2
            if np.sign(np.linalg.det(arm.jacobian(middle[None])))[0] == sign[k]:
                low = middle
            else:
                high = middle
        found.append(low)
    while len(found) < n:  # an arm that is singular nowhere, or everywhere
        found.append(rng.uniform(-np.pi, np.pi, 6))
    return np.array(found)


if __name__ == "__main__":
    main()
