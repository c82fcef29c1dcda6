"""Pictures of a calibration's report, as SVG: errors before and after, changes with their standard deviations."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from urdf_ik.calibration.changes import Change
from urdf_ik.typing import Array

STYLE = "body{font-family:sans-serif;margin:2em;max-width:70em}td,th{padding:0 .6em;text-align:left}svg{display:block}"
_WIDTH, _HEIGHT, _EDGE = 720, 220, 48
_BEFORE, _AFTER = "#d55e00", "#0072b2"


def residuals(before: Array, after: Array, kind: str) -> str:
    """Errors of each measurement before and after, on a logarithmic scale: lengths, and rotations where measured."""
    parts = [("position error [mm]" if kind in ("pose", "position") else "error [mm]", slice(0, 3), 1e3)]
    if kind == "pose":
        parts.append(("rotation error [deg]", slice(3, 6), 180.0 / np.pi))
    return "".join(
        _points(title, *(np.linalg.norm(each[:, rows], axis=1) * unit for each in (before, after)))
        for title, rows, unit in parts
    )


def _points(title: str, before: Array, after: Array) -> str:
    every = np.concatenate([before, after])
    least = max(float(every[every > 0.0].min(initial=1.0)), 1e-9)
    low, high = np.floor(np.log10(least)), np.ceil(np.log10(max(float(every.max()), 10.0 * least)))
    step = (_WIDTH - 2 * _EDGE) / max(len(before), 1)

    def height(value: float) -> float:
        share = (np.log10(max(value, least)) - low) / max(high - low, 1.0)
        return float(_HEIGHT - _EDGE - share * (_HEIGHT - 2 * _EDGE))

    marks = "".join(
        f'<circle cx="{_EDGE + (k + 0.5) * step:.1f}" cy="{height(value):.1f}" r="2.5" fill="{colour}"/>'
        for values, colour in ((before, _BEFORE), (after, _AFTER))
        for k, value in enumerate(values)
    )
    lines = "".join(
        f'<path d="M{_EDGE} {height(10.0**p):.1f}H{_WIDTH - _EDGE}" stroke="#ddd"/>'
        f'<text x="{_EDGE - 6}" y="{height(10.0**p) + 4:.1f}" font-size="11" text-anchor="end">{10.0**p:g}</text>'
        for p in np.arange(low, high + 1.0)
    )
    key = (
        f'<text x="{_EDGE}" y="20" font-size="13">{escape(title)} of each measurement: '
        f'<tspan fill="{_BEFORE}">before</tspan>, <tspan fill="{_AFTER}">after</tspan></text>'
    )
    return f'<svg width="{_WIDTH}" height="{_HEIGHT}" role="img" aria-label="{escape(title)}">{lines}{marks}{key}</svg>'


def changes(fitted: Sequence[Change]) -> str:
    """Changes of lengths and of angles with bars of two standard deviations; hollow where only a sum is told."""
    parts = []
    for title, fields, unit in (
        ("change [mm]", ("xyz",), 1e3),
        ("change [deg]", ("rpy", "offset"), 180.0 / np.pi),
        ("change of an axis", ("axis",), 1.0),
    ):
        rows = [each for each in fitted if each.parameter.field in fields]
        if rows:
            parts.append(_bars(title, rows, unit))
    return "".join(parts)


def _bars(title: str, rows: Sequence[Change], unit: float) -> str:
    widest = max(max((abs(each.change) + 2.0 * each.deviation) * unit for each in rows), 1e-12)
    middle, half, line = 0.62 * _WIDTH, 0.34 * _WIDTH, 16
    drawn = [f'<text x="0" y="14" font-size="13">{escape(title)}, with two standard deviations</text>']
    for k, each in enumerate(rows):
        y = 30 + line * k
        x, spread = (middle + half * value * unit / widest for value in (each.change, 2.0 * each.deviation))
        spread -= middle
        fill = _AFTER if each.told else "#fff"
        drawn.append(
            f'<text x="{middle - half - 8:.1f}" y="{y + 4}" font-size="11" text-anchor="end">'
            f'{escape(str(each.parameter))}</text><path d="M{x - spread:.1f} {y}H{x + spread:.1f}" stroke="{_BEFORE}"/>'
            f'<circle cx="{x:.1f}" cy="{y}" r="4" fill="{fill}" stroke="{_AFTER}"><title>{each.change * unit:+.5g} +- '
            f"{2.0 * each.deviation * unit:.3g}</title></circle>"
        )
    bottom = 30 + line * len(rows)
    axis = f'<line x1="{middle}" x2="{middle}" y1="22" y2="{bottom}" stroke="#888"/>'
    opening = f'<svg width="{_WIDTH}" height="{bottom + 12}" role="img" aria-label="{escape(title)}">'
    return f"{opening}{axis}{''.join(drawn)}</svg>"
