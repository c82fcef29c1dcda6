"""Workspaces: the exact region that a planar arm's tip reaches, and maps of the solutions of any arm.

>>> import urdf_ik
>>> from urdf_ik.maps import workspaces
>>> region = workspaces.planar(urdf_ik.load("planar_2r"))
>>> found = workspaces.workspace(urdf_ik.load("zyyzyz_6r"), voxel=0.5, orientations=20)
>>> len(found.branch_shares()), found.slice("z", 1.0).axes
(8, ('x', 'y'))

A map larger than memory is written to a store, ``workspace(..., store="map.zarr")``, by this process or by the workers
of a Dask cluster.

A map holds the answers of ``arm.ik`` for every voxel's centre in every sampled orientation. It says nothing about the
poses between them.
"""

from __future__ import annotations

from urdf_ik.maps.workspaces.arcs import Arc, Region
from urdf_ik.maps.workspaces.creation import CHUNK, MAX_SAMPLES, workspace
from urdf_ik.maps.workspaces.grid import Grid
from urdf_ik.maps.workspaces.planar_regions import ELBOWS, PlanarWorkspace, planar
from urdf_ik.maps.workspaces.store.combination import Differences, cut, differences, join
from urdf_ik.maps.workspaces.store.stored_map import StoredMap, opened
from urdf_ik.maps.workspaces.surface import Surface, boundary
from urdf_ik.maps.workspaces.totals import BranchShare, Totals
from urdf_ik.maps.workspaces.workspace_map import VALUES, About, MapSlice, WorkspaceMap, read

__all__ = [
    "About",
    "Arc",
    "BranchShare",
    "CHUNK",
    "Differences",
    "ELBOWS",
    "Grid",
    "MAX_SAMPLES",
    "MapSlice",
    "PlanarWorkspace",
    "Region",
    "StoredMap",
    "Surface",
    "Totals",
    "VALUES",
    "WorkspaceMap",
    "boundary",
    "cut",
    "differences",
    "join",
    "opened",
    "planar",
    "read",
    "workspace",
]
