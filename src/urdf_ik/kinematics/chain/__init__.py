"""A serial chain from a base link to a tip link, as screw axes at the zero configuration."""

from urdf_ik.kinematics.chain.from_model import from_urdf, velocity_limits
from urdf_ik.kinematics.chain.mimic import CoupledChain
from urdf_ik.kinematics.chain.redundancy import (
    dependent_joints,
    is_redundant,
    kinds_of,
    least_stretches,
    sampled,
    typical_stretch,
)
from urdf_ik.kinematics.chain.serial import Chain, Follower, TreeJoint

__all__ = [
    "Chain",
    "CoupledChain",
    "Follower",
    "TreeJoint",
    "dependent_joints",
    "from_urdf",
    "is_redundant",
    "kinds_of",
    "least_stretches",
    "sampled",
    "typical_stretch",
    "velocity_limits",
]
