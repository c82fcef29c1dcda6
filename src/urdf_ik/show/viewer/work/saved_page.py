"""The saved page: viser's scene, with the names of the branches in their colours over it."""

from __future__ import annotations

from html import escape

from urdf_ik.show.viewer.arm_and_gizmo import colours
from urdf_ik.show.viewer.state import State

_STYLE = (
    "position:fixed;left:1em;bottom:1em;z-index:9;margin:0;padding:.6em .9em;border-radius:.4em;list-style:none;"
    "font:13px/1.5 sans-serif;pointer-events:none;"
)


def with_names(page: str, state: State, dark: bool = False) -> str:
    """The page with a list of the solutions that it shows, each in its colour, and where the arm stands marked.

    Args:
        page: HTML of the scene.
        state: what the scene shows.
        dark: whether it is light on dark.
    """
    shades = colours(max(len(state.arm.structure.branches), 1), dark)
    shown = [ghost for k, ghost in enumerate(state.ghosts) if k == state.chosen or ghost in state.drawn]
    lines = []
    for ghost in (*shown, *state.pinned):
        red, green, blue = shades[ghost.column]
        here = " (the arm)" if state.chosen is not None and ghost is state.ghosts[state.chosen] else ""
        here = " (pinned)" if ghost in state.pinned else here
        marks = f" ({'; '.join(ghost.marks)})" if ghost.marks else ""
        dot = f'<span style="color:rgb({red},{green},{blue})">&#9679;</span>'
        lines.append(f"<li>{dot} {escape(ghost.branch + marks + here)}</li>")
    text, ground = ("#eee", "rgba(0,0,0,.6)") if dark else ("#222", "rgba(255,255,255,.8)")
    title = f"<li><b>{escape(state.arm.name)}</b></li>"
    legend = f'<ul id="branches" style="{_STYLE}color:{text};background:{ground}">{title}{"".join(lines)}</ul>'
    head, end, tail = page.rpartition("</body>")
    return f"{head}{legend}{end}{tail}" if end else page + legend
