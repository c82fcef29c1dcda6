"""The allowed-collision table: the pairs that must not touch, those that may, and the reasons."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from urdf_ik.cell.coal_check import ArmShapes, CoalCheck, ShapePair
from urdf_ik.errors import ArgumentError, listed
from urdf_ik.support.text import aligned, nearest, quoted

Pair = tuple[str, str]

RIGID, ADJACENT, SRDF, ALWAYS_COLLIDE, USER = "rigid", "adjacent", "srdf", "always", "allowed"
"""Reasons why a pair is allowed to touch: no movable joint between its links, exactly one, a line in the SRDF,
contact in (nearly) all sampled joint vectors, or a call of ``CollisionModel.allow``."""


@dataclass(frozen=True)
class Table:
    """The pairs that a check includes, and those that it skips; ``print(table)`` shows one pair a line.

    Attributes:
        allowed: pairs that may touch, to the reason.
        checked: pairs that must not touch.
    """

    allowed: Mapping[Pair, str]
    checked: tuple[Pair, ...]

    def __str__(self) -> str:
        rows = [[*pair, "checked"] for pair in self.checked]
        rows += [[*pair, "allowed" if why == USER else f"allowed: {why}"] for pair, why in self.allowed.items()]
        return "\n".join(line.rstrip() for line in aligned([["first", "second", ""], *rows], left=(0, 1, 2)))


def among_links(arm: ArmShapes, rank: Mapping[str, int], excused: set[Pair]) -> tuple[dict[Pair, str], list[ShapePair]]:
    """Pairs of links that may touch by the URDF or an SRDF, to the reason; the other pairs of shapes."""
    shapes, parents = arm.geometry.geometryObjects, arm.reference.pin_model.parents
    allowed: dict[Pair, str] = {}
    others: list[ShapePair] = []
    for j in range(len(shapes)):
        for i in range(j):
            if arm.links[i] == arm.links[j]:
                continue
            pair = ordered(arm.links[i], arm.links[j], rank)
            a, b = shapes[i].parentJoint, shapes[j].parentJoint
            if a == b:
                allowed[pair] = RIGID
            elif parents[a] == b or parents[b] == a:
                allowed[pair] = ADJACENT
            elif pair in excused:
                allowed[pair] = SRDF
            others.append(ShapePair(pair, i, j))
    return allowed, others


def always_colliding(check: CoalCheck, share: float, samples: int, seed: int) -> set[Pair]:
    """Pairs of links that touch in at least this share of random joint vectors."""
    lower, upper = check.arm.reference.ranges.T
    Q = np.random.default_rng(seed).uniform(lower, upper, (samples, len(lower)))
    tolerated = round((1.0 - share) * samples)
    watched = {pair.names for pair in check.pairs}
    for hulls in (True, False):  # the meshes of few pairs need to be read
        free = dict.fromkeys(watched, 0)
        for q in Q:
            if not watched:
                break
            placing = check.arm.place(q)
            touching: set[Pair] = set()
            for k, pair in enumerate(check.pairs):
                if pair.names in watched and pair.names not in touching and check.touches(placing, k, hulls=hulls):
                    touching.add(pair.names)
            for names in watched - touching:
                free[names] += 1
            watched = {names for names in watched if free[names] <= tolerated}
    return watched


def with_obstacles(arm: ArmShapes, names: Sequence[str]) -> tuple[dict[Pair, str], list[Pair]]:
    """Pairs that may touch because the link cannot move against the base; and all pairs of a link and an obstacle."""
    moves = dict(zip(arm.links, arm.bodies.moves.tolist(), strict=True))
    pairs = [(link, name) for link in moves for name in names]
    return {pair: RIGID for pair in pairs if not moves[pair[0]]}, pairs


def exceptions(
    arm: ArmShapes, changes: Mapping[Pair, bool], links: Collection[str]
) -> tuple[list[tuple[int, str]], list[tuple[int, str]]]:
    """How a user's changes differ from "every shape that moves is checked against every obstacle".

    Returns:
        Pairs of a shape that moves and an obstacle that may touch; of one that does not move and one that must not.
    """
    excepted: list[tuple[int, str]] = []
    added: list[tuple[int, str]] = []
    for (link, obstacle), must_not in changes.items():
        if obstacle not in links:
            for i, moves in enumerate(arm.bodies.moves.tolist()):
                if arm.links[i] == link and moves != must_not:
                    (excepted if moves else added).append((i, obstacle))
    return excepted, added


def made(
    allowed: Mapping[Pair, str], pairs: Collection[Pair], changes: Mapping[Pair, bool], rank: Mapping[str, int]
) -> Table:
    """The table after a user's changes.

    Args:
        allowed: pairs that may touch, to the reason.
        pairs: all pairs.
        changes: pairs that a user changed, to whether they must not touch.
        rank: every link and then every obstacle, to its place.
    """
    reasons = {pair: why for pair, why in allowed.items() if not changes.get(pair, False)}
    there = set(pairs)
    reasons |= {pair: reasons.get(pair, USER) for pair, may in changes.items() if not may and pair in there}

    def place(pair: Pair) -> tuple[int, int]:
        return rank[pair[0]], rank[pair[1]]

    return Table(
        {pair: reasons[pair] for pair in sorted(reasons, key=place)},
        tuple(sorted((pair for pair in there if pair not in reasons), key=place)),
    )


def ordered(a: str, b: str, rank: Mapping[str, int]) -> Pair:
    """A pair in the order of the names."""
    return (a, b) if rank[a] < rank[b] else (b, a)


def named(a: str, b: str, rank: Mapping[str, int], shaped: Sequence[str]) -> Pair:
    """A pair that a user names.

    Args:
        a: a link, or an obstacle.
        b: another one.
        rank: every link and then every obstacle, to its place.
        shaped: those that have a shape.
    """
    for name in (a, b):
        if name not in rank:
            close = nearest(name, rank) or list(rank)
            raise ArgumentError(f"there is no link or obstacle {quoted(name)}; there are: {listed(close)}")
        if name not in shaped:
            raise ArgumentError(f"link {quoted(name)} has no collision shape; links with one: {', '.join(shaped)}")
    if a == b:
        raise ArgumentError(f"{quoted(a)} and itself given; a pair is of two links, or of a link and an obstacle")
    return ordered(a, b, rank)
