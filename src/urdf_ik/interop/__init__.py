"""Arms and solutions in other programs: ROS messages, pink, viser and rerun; derivatives in torch and jax."""

from __future__ import annotations

from urdf_ik.interop import other_programs
from urdf_ik.interop.other_programs import *  # noqa: F403

__all__ = []
__all__ += other_programs.__all__


def __dir__() -> list[str]:
    return __all__
