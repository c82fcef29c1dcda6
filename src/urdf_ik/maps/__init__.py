"""Workspaces and base placements of an arm, and the stores in which large ones are computed on Dask."""

from __future__ import annotations

from urdf_ik.support.lazy import attributes

__all__ = ["placement", "workspace"]

__getattr__ = attributes(
    __name__,
    {"placement": "placements.creation", "workspace": "workspaces.creation"},
)
