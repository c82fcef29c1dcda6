"""The chain between two links of a URDF, and the velocity limits of its joints."""

import numpy as np
from numpy.typing import NDArray

from urdf_ik.errors import UnsupportedArm
from urdf_ik.kinematics.chain.mimic import coupled, follows
from urdf_ik.kinematics.chain.serial import Chain, Follower, TreeJoint
from urdf_ik.model.urdf import MOVABLE, Joint, UrdfModel
from urdf_ik.support.tolerances import LARGEST


def from_urdf(model: UrdfModel, base: str | None = None, tip: str | None = None) -> Chain:
    """The chain from ``base`` to ``tip``: a :class:`urdf_ik.kinematics.chain.CoupledChain` where joints mimic others.

    Args:
        model: the URDF.
        base: base link; default: the root.
        tip: tip link; default: the end of the only movable chain below the base.
    """
    base, tip = model.resolve_chain(base, tip)
    model.require_sound(base, tip)
    movable: list[Joint] = []
    H: list[NDArray[np.float64]] = []
    points: list[NDArray[np.float64]] = [np.zeros(3)]
    frame, link = np.eye(4), base
    for joint in model.path_between(base, tip):
        upwards = joint.child == link
        link = joint.parent if upwards else joint.child
        if not upwards:
            frame = frame @ joint.origin
        if joint.type != "fixed":
            _require_supported(model, joint)
            direction = frame[:3, :3] @ joint.axis
            movable.append(joint)
            H.append((-1.0 if upwards else 1.0) * direction / np.linalg.norm(direction))
            points.append(frame[:3, 3].copy())
        if upwards:
            frame = frame @ np.linalg.inv(joint.origin)
    points.append(frame[:3, 3].copy())
    rows = [model.driver(joint) for joint in movable]
    names = tuple(dict.fromkeys(driver.name for driver, multiplier, _ in rows if follows(multiplier)))
    limits = [(-np.inf, np.inf) if joint.type == "continuous" else (joint.lower, joint.upper) for joint in movable]
    chain = Chain(
        base=base,
        tip=tip,
        joint_names=tuple(joint.name for joint in movable),
        joint_types=tuple(joint.type for joint in movable),
        H=np.array(H, dtype=np.float64).reshape(-1, 3),
        P=np.diff(np.array(points), axis=0),
        R_tip=np.ascontiguousarray(frame[:3, :3]),
        limits=np.array(limits, dtype=np.float64).reshape(-1, 2),
        tree=_tree(model, names),
        root=model.root,
        followers=tuple(_follower(model, joint) for joint in movable if joint.mimic is not None),
    )
    return coupled(model, chain, movable) if chain.followers else chain


def _require_supported(model: UrdfModel, joint: Joint) -> None:
    if joint.type not in MOVABLE:
        raise UnsupportedArm(
            f"{model.source}: joint {joint.name!r} of the chain is {joint.type}; only fixed, "
            f"{', '.join(MOVABLE)} joints can be solved; begin behind it with base={joint.child!r}, or end "
            f"before it with tip={joint.parent!r}"
        )


def _follower(model: UrdfModel, joint: Joint) -> Follower:
    driver, multiplier, offset = model.driver(joint)
    return Follower(joint.name, driver.name, multiplier, offset)


def _tree(model: UrdfModel, names: tuple[str, ...]) -> tuple[TreeJoint, ...]:
    """Every joint of the URDF, parents before children."""
    out: list[TreeJoint] = []
    waiting = [model.root]
    while waiting:
        for joint in model.children(waiting.pop()):
            driver, multiplier, offset = model.driver(joint)
            moves = joint.type in MOVABLE
            column = names.index(driver.name) if moves and driver.name in names else None
            out.append(
                TreeJoint(
                    parent=joint.parent,
                    child=joint.child,
                    origin=joint.origin,
                    axis=np.ascontiguousarray(joint.axis, dtype=np.float64),
                    prismatic=joint.type == "prismatic",
                    column=column,
                    multiplier=multiplier,
                    offset=offset if moves else 0.0,
                    driver=driver.name if moves else "",
                    name=joint.name,
                    rpy=joint.rpy,
                    axis_length=joint.axis_length,
                )
            )
            waiting.append(joint.child)
    return tuple(out)


def velocity_limits(model: UrdfModel, chain: Chain, rate: str = "velocity") -> NDArray[np.float64]:
    """(n,) rad/s or m/s, greatest speed of each joint of a chain of the URDF; infinite where the URDF gives no speed.

    ``rate``: 'velocity', 'acceleration' (per s^2) or 'jerk' (per s^3); the last two are of URDF 1.2.

    A speed of zero counts as not given: files have it where nobody filled it in, and the joint could not move. So do
    one below 1e-15, which is zero by rounding, and one beyond 1e15, which programs write for none. A joint of the chain
    that mimics another narrows its speed as it does its limits.
    """
    speeds = dict.fromkeys(chain.joint_names, np.inf)
    followers = {follower.name for follower in chain.followers}
    for joint in model.joints:
        driver, multiplier, _ = model.driver(joint)
        speed = getattr(joint, rate) if joint.name == driver.name or joint.name in followers else None
        if speed is None or not 1.0 / LARGEST <= speed <= LARGEST:
            continue
        if multiplier and joint.type in MOVABLE and driver.name in speeds:
            speeds[driver.name] = min(speeds[driver.name], speed / abs(multiplier))
    limits = np.array([speeds[name] for name in chain.joint_names], dtype=np.float64)
    limits.setflags(write=False)
    return limits
