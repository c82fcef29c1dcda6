"""The strip under a redundancy parameter's slider: the intervals of each branch, with the cause of each end."""

from __future__ import annotations

from html import escape

import numpy as np

from urdf_ik.ik.redundancy import Intervals
from urdf_ik.ik.redundancy.intervals import ENDS, Bar, bars
from urdf_ik.show.viewer.state import State

# The line at the present value.
_HERE = "#d55e00"
_WIDTH, _ROW, _BAR = 300.0, 14.0, 8.0
# Greys at a limit and far from all limits.
_LIGHT, _DARK = 205, 60
# Most pieces of one shade in a bar: finer ones could not be told apart.
_SHADES = 24


def drawn(state: State) -> str:
    """The strip of a state as HTML: the value across, a row a branch; '' where there are no intervals to show."""
    found = state.intervals
    if found is None or not len(found) or state.redundancy is None:
        return ""
    names, every = bars(found)
    low, high = _ends(found)
    height = _ROW * len(names)
    parts = [part for bar in every for part in _bar(bar, low, high)]
    here = _across(float(np.atleast_1d(state.redundancy)[0]), low, high)
    parts.append(
        f'<line x1="{here:.2f}" x2="{here:.2f}" y1="0" y2="{height:g}" stroke="{_HERE}" stroke-dasharray="3 2"/>'
    )
    causes = [cause for cause in ENDS if any(end == cause for bar in every for _, end in bar.ends)]
    entries = [f'<span style="color:{ENDS[cause][0]}">&#9608;</span> {ENDS[cause][1]}' for cause in causes]
    legend = " &middot; ".join(entries)
    return (
        f'<div style="padding:0 1em;font-size:0.7em"><svg viewBox="0 0 {_WIDTH:g} {height:g}" width="100%" '
        'style="background:#fff" shape-rendering="crispEdges" role="img" '
        f'aria-label="Values at which each branch has solutions">{"".join(parts)}'
        f"</svg><div>{legend}</div></div>"
    )


def _ends(found: Intervals) -> tuple[float, float]:
    """Least and greatest value across [rad or m]."""
    if found.parameter.round:
        return -np.pi, np.pi
    low, high = found.parameter.range
    if np.isfinite(high - low):
        return low, high
    return min(each.low for each in found), max(each.high for each in found)


def _across(value: float, low: float, high: float) -> float:
    return _WIDTH * min(max((value - low) / max(high - low, 1e-12), 0.0), 1.0)


def _bar(bar: Bar, low: float, high: float) -> list[str]:
    """A bar, with its branch and ends as the words that stand beside the pointer."""
    top = _ROW * bar.row
    words = f"{bar.interval.branch}: from {bar.interval.low:.3f} ({bar.interval.ends[0]}) to "
    words += f"{bar.interval.high:.3f} ({bar.interval.ends[1]})"
    parts = [f"<g><title>{escape(words)}</title>"]
    cuts = np.unique(np.linspace(0, len(bar.margin), min(_SHADES, len(bar.margin)) + 1).astype(int))
    for a, b in zip(cuts[:-1], cuts[1:], strict=True):
        x, to = _across(bar.value[a], low, high), _across(bar.value[b], low, high)
        shade = round(_LIGHT + (_DARK - _LIGHT) * float(bar.margin[a:b].mean()))
        width = max(to - x, 0.3)
        parts.append(
            f'<rect x="{x:.2f}" y="{top + 0.5 * (_ROW - _BAR):g}" width="{width:.2f}" height="{_BAR:g}" '
            f'fill="rgb({shade},{shade},{shade})"/>'
        )
    for at, cause in bar.ends:
        if low - 1e-9 <= at <= high + 1e-9:
            x = _across(at, low, high)
            parts.append(
                f'<line x1="{x:.2f}" x2="{x:.2f}" y1="{top + 1:g}" y2="{top + _ROW - 1:g}" '
                f'stroke="{ENDS[cause][0]}" stroke-width="2"/>'
            )
    return [*parts, "</g>"]
