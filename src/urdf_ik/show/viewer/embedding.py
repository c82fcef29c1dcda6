"""The viewer's page outside the viewer: in a notebook, as a picture in its place, as a file."""

from html import escape

import numpy as np

from urdf_ik.ik.solutions.tables import stick_picture
from urdf_ik.show.viewer.arm_and_gizmo import colours as bytes_of_colours
from urdf_ik.show.viewer.state import State
from urdf_ik.support.palette import colours

_LEGEND = (
    "position:fixed;left:1em;bottom:1em;z-index:9;margin:0;padding:.6em .9em;border-radius:.4em;list-style:none;"
    "font:13px/1.5 sans-serif;pointer-events:none;"
)


def embedded(url: str, height: int, picture: str) -> str:
    """The page at ``url`` as an element of another page; the picture is shown where the address does not answer.

    A browser shows what an <object> holds where it cannot load the object itself: in an exported notebook, or one whose
    kernel has ended.
    """
    size = f'width="100%" height="{height}" style="border:0"'
    return f'<object type="text/html" data="{escape(url)}" {size}>{picture}</object>'


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


def with_names(page: str, state: State, dark: bool = False) -> str:
    """The HTML ``page`` of a scene with a list of its solutions in their colours; the arm's own is marked."""
    shades = bytes_of_colours(max(len(state.arm.structure.branches), 1), dark)
    lines = []
    for k, ghost in enumerate(state.ghosts):
        red, green, blue = shades[ghost.column]
        here = " (the arm)" if k == state.chosen else ""
        marks = f" ({'; '.join(ghost.marks)})" if ghost.marks else ""
        dot = f'<span style="color:rgb({red},{green},{blue})">&#9679;</span>'
        lines.append(f"<li>{dot} {escape(ghost.branch + marks + here)}</li>")
    text, ground = ("#eee", "rgba(0,0,0,.6)") if dark else ("#222", "rgba(255,255,255,.8)")
    title = f"<li><b>{escape(state.arm.name)}</b></li>"
    legend = f'<ul id="branches" style="{_LEGEND}color:{text};background:{ground}">{title}{"".join(lines)}</ul>'
    head, end, tail = page.rpartition("</body>")
    return f"{head}{legend}{end}{tail}" if end else page + legend
