"""Workspaces, base placements and data sets of an arm, and the engine that computes them on Dask."""

from __future__ import annotations

from urdf_ik.support.lazy import attributes

__all__ = ["dataset", "placement", "workspace"]

__getattr__ = attributes(
    __name__,
    {"dataset": "datasets.creation", "placement": "placements.creation", "workspace": "workspaces.creation"},
)
