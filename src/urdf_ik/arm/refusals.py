"""Why an arm cannot be solved, and what would help."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf_ik.chain import CoupledChain, dependent_joints, kinds_of
from urdf_ik.errors import UnsupportedArm
from urdf_ik.families import coupled

if TYPE_CHECKING:
    from urdf_ik.chain import Chain
    from urdf_ik.structure import Structure


def unsupported(name: str, chain: Chain, structure: Structure) -> UnsupportedArm:
    """The error for an arm without a solver."""
    if isinstance(chain, CoupledChain):
        return UnsupportedArm(
            f"{name}: {coupled.why_not(chain)}; joints that mimic others: "
            f"{', '.join(map(str, chain.followers))}; independent: {', '.join(chain.joint_names)}"
        )
    if chain.n == 0:
        return UnsupportedArm(f"{name}: no joint moves between {chain.base!r} and {chain.tip!r}")
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
    held = ", ".join(f"{name!r}: 0.0" for name in chain.joint_names[: chain.n - 7])
    return UnsupportedArm(
        f"{name}: {chain.n} joints from {chain.base!r} to {chain.tip!r} ({', '.join(chain.joint_names)}); at "
        f"most seven are solved: hold {chain.n - 7} or more of them, each at a value [rad or m], as in "
        f"urdf_ik.load(..., locked={{{held}}})"
    )
