"""Draws `path.png`, the seam of notebook 10 with its clamp in the way: `python docs/path_picture.py`."""

from pathlib import Path

import numpy as np

import urdf_ik
from urdf_ik import Box, Cylinder, World, pose
from urdf_ik.show import plot


def main() -> None:
    """Follow the seam, which is not found, and draw what each branch does along it."""
    neck = (Cylinder(0.02, 0.22), pose([0.0, 0.0, 0.11]))
    arm = urdf_ik.load("zyyzyz_6r").with_tool(pose([0.0, 0.0, 0.25]), [neck], name="torch")
    x, y, z = 1.5, 0.0, 0.55
    down, turned = [np.pi, 0.0, 0.0], [np.pi, 0.0, 0.5 * np.pi]
    corners = pose([x, y - 0.5, z], rpy=down), pose([x, y + 0.5, z], rpy=down), pose([x - 0.5, y + 0.5, z], rpy=turned)
    world = World()
    world.add("table", Box((1.0, 1.6, 0.06)), pose([x - 0.2, y, z - 0.05]))
    world.add("clamp", Cylinder(0.04, 0.9), pose([x - 0.25, y + 0.25, z + 0.43]))
    plan = arm.follow(urdf_ik.polyline(corners, 0.02, blend=0.1), world=world, margin=0.01)
    plot.save(plot.path(plan), Path(__file__).with_name("path.png"))


if __name__ == "__main__":
    main()
