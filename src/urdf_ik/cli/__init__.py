"""The ``urdf-ik`` command, see ``app`` for its parts."""

from __future__ import annotations

from urdf_ik.cli.application import main
from urdf_ik.cli.chunked import program as _chunked  # noqa: F401  its commands are listed after the others
from urdf_ik.cli.commands import compare as _compare  # noqa: F401
from urdf_ik.cli.commands import freeze as _freeze  # noqa: F401
from urdf_ik.cli.commands import judge as _judge  # noqa: F401
from urdf_ik.cli.commands import verify as _verify  # noqa: F401
from urdf_ik.cli.program import app

__all__ = ["app", "main"]
