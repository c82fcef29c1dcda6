#!/usr/bin/env python3
"""A node with the service ~/all_solutions: every solution of a pose, with branches, limits and singularities.

Run it as `ros2 run urdf_ik_ros solutions --ros-args -p robot_description:="$(xacro my_arm.xacro)" -p tip:=tool0`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import urdf_ik
from urdf_ik.errors import UrdfIkError
from urdf_ik.ik.solutions.limits import image_range


def answer(
    arm: urdf_ik.Arm,
    position: Sequence[float],
    quaternion: Sequence[float],
    seed: Sequence[float] = (),
    redundancy: Sequence[float] = (),
) -> dict[str, Any]:
    """The fields of the service's response.

    Args:
        arm: the arm.
        position: x, y, z of the tip in the base [m].
        quaternion: x, y, z, w.
        seed: near which free joints stand [rad, m]; empty: zero.
        redundancy: values of the redundancy parameters; empty: the defaults.
    """
    names = list(arm.joint_names)
    empty = {"joint_names": names, "status": "", "solutions": [], "branches": [], "within_limits": [], "singular": []}
    try:
        T = urdf_ik.pose(position, quat_xyzw=quaternion)
        free = {"redundancy": redundancy[0] if len(redundancy) == 1 else list(redundancy)} if len(redundancy) else {}
        near = {"q_ref": list(seed)} if len(seed) else {}
        found = arm.ik(T, **free, **near)
        rows = found.q[found.valid]
        return {
            "error": "",
            "joint_names": names,
            "status": str(found.status),
            "solutions": [float(value) for value in rows.ravel()],
            "branches": [name for name, held in zip(arm.solver.branches, found.valid, strict=True) if held],
            "within_limits": [_inside(arm, row) for row in rows],
            "singular": [bool(each) for each in found.singular[found.valid]],
        }
    except UrdfIkError as error:
        return {"error": str(error), **empty}


def _inside(arm: urdf_ik.Arm, row: Any) -> bool:
    """Whether an image of a solution stands inside the joint limits."""
    first, last = image_range(row, arm.limits, arm.chain.image_turns)
    return bool((first <= last).all())


def main() -> None:
    """Serve until the node is stopped."""
    import rclpy
    from urdf_ik_ros.srv import AllSolutions

    rclpy.init()
    node = rclpy.create_node("urdf_ik")
    text, base, tip = (node.declare_parameter(name, "").value for name in ("robot_description", "base", "tip"))
    arm = urdf_ik.load(text, base=base or None, tip=tip or None)

    def serve(request: Any, response: Any) -> Any:
        at, turn = request.pose.position, request.pose.orientation
        fields = answer(arm, (at.x, at.y, at.z), (turn.x, turn.y, turn.z, turn.w), request.seed, request.redundancy)
        for name, value in fields.items():
            setattr(response, name, value)
        return response

    node.create_service(AllSolutions, "~/all_solutions", serve)
    rclpy.spin(node)


if __name__ == "__main__":
    main()
