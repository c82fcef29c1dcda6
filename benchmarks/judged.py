#!/usr/bin/env python3
"""Other solvers held to all solutions: ``urdf_ik.verify.judge`` for every solver and arm, as one table.

    python benchmarks/judged.py [-n N] [--seed S ...] [--arm NAME[:TIP] ...] [--peer NAME ...]

A cell holds wrong / missing / doubled, summed over the seeds.
"""

import argparse
import sys

from peers import PEERS, Unavailable

import urdf_ik
from urdf_ik.verify import judge
from urdf_ik.verify.judging import Kind

ARMS = ("ur5", "puma_560", "zyyzyz_6r")


def row(arm: urdf_ik.Arm, kind: str, n: int, seeds: list[int]) -> str | None:
    """A solver's row; None where it does not take the arm, with the reason on standard error."""
    try:
        peer = PEERS[kind](arm)
    except Unavailable as error:
        print(f"{kind}, {arm.name}: {error}", file=sys.stderr)
        return None
    found = [judge(arm, peer.claims, n=n, seed=seed, name=peer.name) for seed in seeds]
    parts: list[list[Kind]] = list(zip(*(each.kinds for each in found), strict=True))  # type: ignore[arg-type]
    cells = [" / ".join(str(sum(getattr(kind, fault) for kind in each)) for fault in ("wrong", "missing", "doubled"))
             for each in parts]  # fmt: skip
    expected, failed, further = (
        sum(getattr(part, count) for each in parts for part in each) for count in ("expected", "failed", "further")
    )
    if failed or further:
        print(f"{kind}, {arm.name}: {failed} failed, {further} that urdf-ik lacks", file=sys.stderr)
    return f"| {found[0].solver} | {arm.name} | {expected} | {' | '.join(cells)} |"


def main(arguments: list[str] | None = None) -> int:
    """Judge and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, default=50, help="poses of each kind and seed (default 50)")
    parser.add_argument("--seed", type=int, nargs="+", default=[0], help="seeds (default 0)")
    parser.add_argument("--arm", nargs="+", default=ARMS, metavar="NAME[:TIP]")
    parser.add_argument(
        "--peer", nargs="+", choices=tuple(PEERS), default=[kind for kind in PEERS if kind != "urdf-ik"]
    )
    options = parser.parse_args(arguments)
    print("| solver | arm | solutions | random | round | tool down | beside a singularity | at one |")
    print("|---|---|---:|---|---|---|---|---|")
    for name in options.arm:
        place, _, tip = name.partition(":")
        arm = urdf_ik.load(place, tip=tip or None)
        for kind in options.peer:
            if (line := row(arm, kind, options.n, options.seed)) is not None:
                print(line, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
