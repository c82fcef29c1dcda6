"""Why an arm cannot be solved, and what would help."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf_ik.chain import CoupledChain, is_redundant, kinds_of
from urdf_ik.errors import UnsupportedArm
from urdf_ik.families import coupled
from urdf_ik.text import quoted

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
        return UnsupportedArm(f"{name}: no joint moves between {quoted(chain.base)} and {quoted(chain.tip)}")
    if is_redundant(chain) and chain.n <= 6:
        return UnsupportedArm(
            f"{name}: the joints are redundant: at every joint vector some move the tip as others do, so that a pose "
            f"has a continuum of solutions or no solution: joints {', '.join(chain.joint_names)} are "
            f"{kinds_of(chain)}. {structure}"
        )
    if chain.n == 6:
        return UnsupportedArm(
            f"{name}: no solver for two slides three joints apart ({kinds_of(chain)}) without a "
            "spherical wrist at either end; one of them held at a value, as in "
            f"urdf_ik.load(..., locked={{name: 0.0}}), leaves five joints that are solved. {structure}"
        )
    if chain.n <= 7:
        return UnsupportedArm(f"{name}: no solver for this arm yet. {structure}")
    held = ", ".join(f"{quoted(name)}: 0.0" for name in chain.joint_names[: chain.n - 7])
    return UnsupportedArm(
        f"{name}: {chain.n} joints from {chain.base!r} to {chain.tip!r} ({', '.join(chain.joint_names)}); at "
        f"most seven are solved: hold {chain.n - 7} or more of them, each at a value [rad or m], as in "
        f"urdf_ik.load(..., locked={{{held}}})"
    )
