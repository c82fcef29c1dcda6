"""Workspaces: the exact region that a planar arm's tip reaches, and maps of the solutions of any arm.

>>> import urdf_ik
>>> from urdf_ik.maps import workspaces
>>> region = workspaces.planar(urdf_ik.load("planar_2r"))
>>> found = workspaces.workspace(urdf_ik.load("zyyzyz_6r"), voxel=0.5, orientations=20)
>>> len(found.totals()["branches"]), found.slice("z", 1.0).axes
(8, ('x', 'y'))

A map larger than memory is written to a store, ``stored_workspace(arm, "map.zarr")``, by this process or by the workers
of a Dask cluster.

A map contains the answers of ``arm.ik`` for every voxel's centre in every sampled orientation, not those between them.
"""

from urdf_ik.maps.grid import Grid
from urdf_ik.maps.workspaces.creation import CHUNK, grid_of, stored_workspace, workspace
from urdf_ik.maps.workspaces.planar_regions import ELBOWS, Arc, PlanarWorkspace, Region, planar
from urdf_ik.maps.workspaces.workspace_map import VALUES, MapSlice, WorkspaceMap, opened, require_map_of

__all__ = [
    "Arc",
    "CHUNK",
    "ELBOWS",
    "Grid",
    "MapSlice",
    "PlanarWorkspace",
    "Region",
    "VALUES",
    "WorkspaceMap",
    "grid_of",
    "opened",
    "planar",
    "require_map_of",
    "stored_workspace",
    "workspace",
]
