"""The ``urdf-ik`` command, see ``app`` for its parts."""

from __future__ import annotations

from urdf_ik.cli.application import app, main

__all__ = ["app", "main"]
