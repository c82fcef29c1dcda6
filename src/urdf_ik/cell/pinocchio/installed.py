"""Pinocchio, or the error that says how to install it."""

from __future__ import annotations

from urdf_ik.cell.pinocchio import missing as without_pinocchio

try:
    import pinocchio as pin
except ModuleNotFoundError:
    raise without_pinocchio.needed("comparisons with the reference") from None

__all__ = ["pin"]
