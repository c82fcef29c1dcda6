"""Workspaces and base placements of an arm; large ones in Zarr stores, computed on Dask's workers."""

from urdf_ik.support.lazy import attributes

__all__ = ["placement", "stored_workspace", "workspace"]

__getattr__ = attributes(
    __name__,
    {
        "placement": "placements",
        "stored_workspace": "workspaces.creation",
        "workspace": "workspaces.creation",
    },
)
