"""The viewer's page inside a notebook, and what stands in its place where no viewer runs."""

from __future__ import annotations

from html import escape
from typing import NamedTuple

import numpy as np

from urdf_ik.ik.solutions.tables import stick_picture
from urdf_ik.show.viewer.state import State
from urdf_ik.support.palette import colours


class Embedded(NamedTuple):
    """The page as an element of another page.

    Attributes:
        url: its address.
        height: of the element [pixels].
        picture: what a browser shows where the address does not answer: in an exported notebook, or one whose kernel
            has ended.
    """

    url: str
    height: int
    picture: str

    def _repr_html_(self) -> str:
        # A browser shows what an object holds where it cannot load the object itself.
        return (
            f'<object type="text/html" data="{escape(self.url)}" width="100%" height="{self.height}" style="border:0">'
            f"{self.picture}</object>"
        )


def picture(state: State) -> str:
    """The arm and every solution of its target as stick figures, and what they are."""
    arm = state.arm
    figures = np.array([*(ghost.q for ghost in state.ghosts), state.q])
    shades = [*colours(len(state.ghosts)), (0.0, 0.0, 0.0)]
    count = len(state.ghosts)
    words = f"{arm.name}: {count} solution{'' if count == 1 else 's'} of the target, and the arm in black"
    return (
        f"<figure>{stick_picture(arm.chain, figures, shades)}"
        f"<figcaption>{escape(words)}. The page itself needs the viewer to run.</figcaption></figure>"
    )
