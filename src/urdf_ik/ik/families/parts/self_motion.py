"""SelfMotion: the compiled core's curves of joint vectors that hold a pose, as an object that can be pickled."""

from __future__ import annotations

from typing import Any

from urdf_ik import _core


class SelfMotion(_core.SelfMotion):
    """The core's curves, with the values that they were made from: a copy is made from the same values."""

    def __init__(self, values: dict[str, Any]) -> None:
        super().__init__(values)
        self._values = values

    def __reduce__(self) -> tuple[type[SelfMotion], tuple[dict[str, Any]]]:
        return type(self), (self._values,)
