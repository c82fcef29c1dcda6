"""Where an arm's tip can be: the exact region of planar arms, a map of the solutions of any other.

>>> import urdf_ik
>>> from urdf_ik import workspace
>>> region = workspace.planar(urdf_ik.load("planar_2r"))
>>> found = workspace.compute(urdf_ik.load("zyyzyz_6r"), voxel=0.5, orientations=20)
>>> len(found.branch_shares()), found.slice("z", 1.0).axes
(8, ('x', 'y'))

A map holds the answers of ``arm.ik`` for every voxel's centre in every orientation sampled: it says what is true of
these poses, and nothing of what lies between them.
"""

from __future__ import annotations

from urdf_ik.workspace.arcs import Arc, Region
from urdf_ik.workspace.building import CHUNK, MAX_SAMPLES, compute
from urdf_ik.workspace.grid import Grid
from urdf_ik.workspace.maps import VALUES, About, BranchShare, MapSlice, WorkspaceMap, read
from urdf_ik.workspace.regions import ELBOWS, PlanarWorkspace, planar

__all__ = [
    "CHUNK",
    "ELBOWS",
    "MAX_SAMPLES",
    "VALUES",
    "About",
    "Arc",
    "BranchShare",
    "Grid",
    "MapSlice",
    "PlanarWorkspace",
    "Region",
    "WorkspaceMap",
    "compute",
    "planar",
    "read",
]
