"""Names of arms, and where their URDFs lie: in this package, in example-robot-data, or in robot_descriptions."""

from __future__ import annotations

from urdf_ik.catalogue.entries import BUNDLED, EXAMPLE_ROBOT_DATA, Entry, is_here, names, resolve

__all__ = ["BUNDLED", "EXAMPLE_ROBOT_DATA", "Entry", "is_here", "names", "resolve"]
