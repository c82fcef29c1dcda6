#!/usr/bin/env python3
"""Other solvers held to all solutions: ``urdf-ik judge`` for every solver and arm, as one table.

    python benchmarks/judged.py [-n N] [--seed S ...] [--arm NAME[:TIP] ...] [--solver SPEC ...]

A cell holds wrong / missing / doubled, summed over the seeds; the rules are those of ``urdf_ik.verify.judge``.
"""

from __future__ import annotations

import argparse
import sys

from adapters import solver_of

import urdf_ik
from urdf_ik.verify import judge
from urdf_ik.verify.judging import Kind

SOLVERS = ("eaik", "ik-geo", "py-opw", "ssik", "ssik-built", "roboticstoolbox:python", "roboticstoolbox:c")
ARMS = ("ur5", "puma_560", "zyyzyz_6r")


def row(arm: urdf_ik.Arm, spec: str, n: int, seeds: list[int]) -> str | None:
    """A solver's row; None where it does not take the arm, with the reason on standard error."""
    try:
        solve = solver_of(spec, arm)
    except urdf_ik.UrdfIkError as error:
        print(f"{spec}, {arm.name}: {error}", file=sys.stderr)
        return None
    found = [judge(arm, solve, n=n, seed=seed) for seed in seeds]
    kinds: list[list[Kind]] = list(zip(*(each.kinds for each in found), strict=True))  # type: ignore[arg-type]
    cells = [" / ".join(str(sum(getattr(kind, fault) for kind in each)) for fault in ("wrong", "missing", "doubled"))
             for each in kinds]  # fmt: skip
    expected, failed, further = (
        sum(getattr(kind, count) for each in kinds for kind in each) for count in ("expected", "failed", "further")
    )
    if failed or further:
        print(f"{spec}, {arm.name}: {failed} failed, {further} that urdf-ik lacks", file=sys.stderr)
    return f"| {found[0].solver} | {arm.name} | {expected} | {' | '.join(cells)} |"


def main(arguments: list[str] | None = None) -> int:
    """Judge and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, default=50, help="poses of each kind and seed (default 50)")
    parser.add_argument("--seed", type=int, nargs="+", default=[0], help="seeds (default 0)")
    parser.add_argument("--arm", nargs="+", default=ARMS, metavar="NAME[:TIP]")
    parser.add_argument("--solver", nargs="+", default=SOLVERS, metavar="SPEC")
    options = parser.parse_args(arguments)
    print("| solver | arm | solutions | random | round | tool down | beside a singularity | at one |")
    print("|---|---|---:|---|---|---|---|---|")
    for name in options.arm:
        place, _, tip = name.partition(":")
        arm = urdf_ik.load(place, tip=tip or None)
        for spec in options.solver:
            if (line := row(arm, spec, options.n, options.seed)) is not None:
                print(line, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
