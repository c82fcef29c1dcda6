"""For launch files: a group's kinematics parameters, with the arm compiled from robot_description."""

from __future__ import annotations

import urdf_ik

PLUGIN = "urdf_ik_moveit/Plugin"


def kinematics(robot_description: str, group: str, base: str, tip: str, timeout: float = 0.05) -> dict[str, object]:
    """Parameters for MoveIt's nodes.

    Args:
        robot_description: the text of the URDF, as MoveIt's nodes get it.
        group: the planning group in the SRDF.
        base: the chain's first link.
        tip: its last link.
        timeout: of a search [s].

    Raises:
        urdf_ik.errors.UrdfIkError: the URDF is wrong, or no solver takes the chain.
    """
    compiled = urdf_ik.compile(urdf_ik.load(robot_description, base=base, tip=tip))
    settings = {"kinematics_solver": PLUGIN, "kinematics_solver_timeout": timeout, "compiled_arm": compiled}
    return {"robot_description_kinematics": {group: settings}}
