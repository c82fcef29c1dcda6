"""Where an arm's tip can be: the exact region of planar arms, a map of the solutions of any other.

>>> import urdf_ik
>>> from urdf_ik import workspace
>>> region = workspace.planar(urdf_ik.load("planar_2r"))
>>> found = workspace.compute(urdf_ik.load("zyyzyz_6r"), voxel=0.5, orientations=20)
>>> len(found.branch_shares()), found.slice("z", 1.0).axes
(8, ('x', 'y'))

Maps that outgrow memory are made in a store, ``compute(..., store="map.zarr")``, by this process or by the workers of a
Dask cluster; ``urdf_ik.workspace(...)`` is short for ``urdf_ik.workspace.compute(...)``.

A map holds the answers of ``arm.ik`` for every voxel's centre in every orientation sampled: it says what is true of
these poses, and nothing of what lies between them.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

from urdf_ik.workspace.arcs import Arc, Region
from urdf_ik.workspace.building import CHUNK, MAX_SAMPLES, compute
from urdf_ik.workspace.grid import Grid
from urdf_ik.workspace.maps import VALUES, About, MapSlice, WorkspaceMap, read
from urdf_ik.workspace.regions import ELBOWS, PlanarWorkspace, planar
from urdf_ik.workspace.store.combining import Differences, cut, differences, join
from urdf_ik.workspace.store.stored import StoredMap, opened
from urdf_ik.workspace.surface import Surface, boundary
from urdf_ik.workspace.totals import BranchShare, Totals

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
    "compute",
    "cut",
    "differences",
    "join",
    "opened",
    "planar",
    "read",
]


class _Callable(ModuleType):
    """This room, which is also called by its name."""

    def __call__(self, *args: Any, **options: Any) -> WorkspaceMap | StoredMap:
        """See :func:`compute`."""
        found: WorkspaceMap | StoredMap = compute(*args, **options)
        return found


sys.modules[__name__].__class__ = _Callable
