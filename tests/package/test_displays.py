"""What a prompt and a notebook show of an object: at most six lines, and tables in which all text is escaped."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik.verify import judge

ARM = urdf_ik.load("puma_560")
SEVEN = urdf_ik.load("srs_7r")
Q = np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
T = ARM.fk(Q)
AWAY = urdf_ik.pose([9.0, 0.0, 0.0])
HARMFUL = urdf_ik.load(ARM.model.xml.replace(b'name="puma_560"', b'name="&lt;script&gt;"'))
SHOWN: dict[str, tuple[Any, tuple[str, ...]]] = {
    "arm": (ARM, ("joint_1", "revolute")),
    "structure": (ARM.structure, ("axes 4, 5 and 6 meet in a point", "up to 8 solutions")),
    "structure of no family": (urdf_ik.kinematics.structure.analyse(ARM.chain), ("no solver takes it",)),
    "solutions": (ARM.ik(T), ("shoulder", "in limits")),
    "solution": (ARM.ik(T)[0], ("<th>q6</th>",)),
    "intervals": (SEVEN.intervals(SEVEN.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1])), ("because", "limit of joint")),
    "intervals of a batch": (SEVEN.intervals(SEVEN.fk(np.full((2, 7), 0.3))), ("intervals[i] shows one",)),
    "plan": (ARM.follow(urdf_ik.line(T, ARM.fk(Q + 0.01), 8)), ("found", "joints at the waypoints", "manipulability")),
    "no plan": (ARM.follow(urdf_ik.line(T, AWAY, 8)), ("no plan", "before waypoint")),
    "comparison": (urdf_ik.compare(ARM, urdf_ik.load("zyyzyz_6r"), n=5), ("joint_2",)),
    "many": (urdf_ik.compare_many([ARM, HARMFUL], T), ("within limits", "<svg")),
    "verification": (urdf_ik.freeze(ARM).verify(HARMFUL), ("PASSED",)),
    "judgement": (judge(ARM, lambda T: ARM.ik(T).to_array()[1:], n=1), ("missing",)),
    "of an odd name": (HARMFUL, ("&lt;script&gt;",)),
}


@pytest.mark.parametrize("name", SHOWN)
def test_an_object_shows_in_six_lines_and_as_html(name: str) -> None:
    """No line is longer than a wide terminal, the words of the HTML are there, and nothing in it is run."""
    shown, words = SHOWN[name]
    lines = repr(shown).splitlines()
    assert 1 <= len(lines) <= 6 and all(len(line) <= 170 for line in lines)
    page = shown._repr_html_()
    assert all(word in page for word in words), page
    assert "<script>" not in page and page.count("<table>") == page.count("</table>")
