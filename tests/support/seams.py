"""A straight seam before the bundled arm, and the plan along it with a box on the way of every branch."""

import numpy as np
from command import oracle

import urdf_ik
from urdf_ik import Arm, Box, Plan, World

START = (0.5, -0.7, -1.4, -1.8, 0.8, 1.6)


def seam(length: float = 1.0, count: int = 30) -> np.ndarray:
    """A straight line along y (count, 4, 4) from the tip at ``START``, by Pinocchio."""
    start = oracle().pose(np.array(START))
    end = start.copy()
    end[1, 3] += length
    return urdf_ik.line(start, end, count)


def blocked_plan(arm: Arm) -> Plan:
    """The plan that ``follow`` gives for the seam with a box at its middle waypoint."""
    T, world = seam(), World()
    world.add("box", Box(0.1), urdf_ik.pose(T[len(T) // 2, :3, 3] + [0.0, 0.0, -0.05]))
    plan = arm.follow(T, world=world)
    assert not plan.found
    return plan
