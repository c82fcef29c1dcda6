"""The ``urdf-ik`` command: its options, a function for each command, and text for terminals."""

from typing import TYPE_CHECKING

from urdf_ik.support.lazy import attributes

if TYPE_CHECKING:
    from urdf_ik.cli.program import app

__all__ = ["app", "main"]

__getattr__ = attributes(__name__, {"app": "program"})


def main() -> None:
    """Entry point of the ``urdf-ik`` command."""
    try:
        from urdf_ik.cli.program import run

        run()
    except KeyboardInterrupt:  # during the imports, which take most of the time of a short command
        raise SystemExit(130) from None
