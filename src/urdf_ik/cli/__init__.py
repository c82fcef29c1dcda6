"""The ``urdf-ik`` command: its options, one file for each command, and text for terminals."""

from __future__ import annotations

from typing import TYPE_CHECKING

from urdf_ik.support.lazy import attributes

if TYPE_CHECKING:
    from urdf_ik.cli.program import app

__all__ = ["app", "main"]

__getattr__ = attributes(__name__, {"app": "program"})


def main() -> None:
    """Entry point of the ``urdf-ik`` command."""
    from urdf_ik.cli.interrupts import guarded

    guarded(_run)  # the imports, too: they take most of the time of a short command


def _run() -> None:
    from urdf_ik.cli.program import run

    run()
