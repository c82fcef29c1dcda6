"""Why an arm cannot be solved, and what would help."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf_ik.chain import CoupledChain, dependent_joints, kinds_of
from urdf_ik.errors import ArgumentError, ChainError, UnsupportedArm
from urdf_ik.families import coupled
from urdf_ik.families.registry import MOST_JOINTS
from urdf_ik.text import quoted

if TYPE_CHECKING:
    from urdf_ik.chain import Chain
    from urdf_ik.structure import Structure


def check_given(name: str, chain: Chain, given: tuple[str, ...]) -> None:
    """That joints may be the redundancy parameters of an arm.

    Raises:
        ChainError: one is no joint of the chain; the error lists those that are.
        ArgumentError: the same joint twice, or more of them than a pose leaves free.
        UnsupportedArm: joints mimic others.
    """
    if not given:
        return
    if unknown := [each for each in given if each not in chain.joint_names]:
        raise ChainError(
            f"{unknown[0]!r} cannot be the redundancy parameter: it is not among the movable joints from "
            f"{chain.base!r} to {chain.tip!r}",
            chain.joint_names,
        )
    if len(set(given)) < len(given):
        raise ArgumentError(f"redundancy={given!r} given; each joint can be named once")
    if isinstance(chain, CoupledChain):
        raise UnsupportedArm(f"{name}: joints mimic others, and none of them can be the redundancy parameter")
    if len(given) > max(chain.n - 6, 0):
        raise ArgumentError(
            f"{name}: redundancy={given!r} given, and its {chain.n} joints leave {max(chain.n - 6, 0)} values free"
        )


def unsupported(name: str, chain: Chain, structure: Structure) -> UnsupportedArm:
    """The error for an arm without a solver."""
    if isinstance(chain, CoupledChain):
        return UnsupportedArm(
            f"{name}: {coupled.why_not(chain)}; joints that mimic others: "
            f"{', '.join(map(str, chain.followers))}; independent: {', '.join(chain.joint_names)}"
        )
    if chain.n == 0:
        return UnsupportedArm(f"{name}: no joint moves between {quoted(chain.base)} and {quoted(chain.tip)}")
    same = dependent_joints(chain)
    if same:
        return UnsupportedArm(
            f"{name}: the joints are redundant, and a pose has a continuum of solutions or none: at every joint vector "
            f"each of {', '.join(same)} moves the tip as the others of these do together. Hold one of them at a value "
            f"[rad or m], as in urdf_ik.load(..., locked={{{same[-1]!r}: 0.0}}). {structure}"
        )
    if chain.n == 6:
        return UnsupportedArm(
            f"{name}: no solver for two slides three joints apart ({kinds_of(chain)}) without a "
            "spherical wrist at either end; one of them held at a value, as in "
            f"urdf_ik.load(..., locked={{name: 0.0}}), leaves five joints that are solved. {structure}"
        )
    if chain.n <= 7:
        return UnsupportedArm(f"{name}: no solver for this arm yet. {structure}")
    if chain.n <= MOST_JOINTS:
        return UnsupportedArm(f"{name}: no solver for any six of its {chain.n} joints, the others held. {structure}")
    held = ", ".join(f"{quoted(name)}: 0.0" for name in chain.joint_names[: chain.n - MOST_JOINTS])
    return UnsupportedArm(
        f"{name}: {chain.n} joints from {chain.base!r} to {chain.tip!r} ({', '.join(chain.joint_names)}); at "
        f"most {MOST_JOINTS} are solved: hold {chain.n - MOST_JOINTS} or more of them, each at a value [rad or m], as "
        f"in urdf_ik.load(..., locked={{{held}}})"
    )
