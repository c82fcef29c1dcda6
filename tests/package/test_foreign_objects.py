"""Arguments of another kind than a function takes: refused by an error of this package, which says what is valid."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import urdf_ik
from urdf_ik import (
    UrdfIkError,
    interop,
)
from urdf_ik.arm import with_positioner
from urdf_ik.ik import (
    cuspidality,
)
from urdf_ik.kinematics import (
    structure,
    velocity,
)
from urdf_ik.maps import (
    placements,
    workspaces,
)
from urdf_ik.show import (
    plot,
)
from urdf_ik.verify import (
    comparison,
    completeness,
    crosscheck,
)

TWO, SIX, SEVEN = (urdf_ik.load(name) for name in ("planar_2r", "zyyzyz_6r", "srs_7r"))
Q6, Q7 = np.array([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]), np.array([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1])
T2, T6, T7 = TWO.fk([0.2, 0.4]), SIX.fk(Q6), SEVEN.fk(Q7)
LINE = urdf_ik.line(T6, T6, 2)
INTERVALS = SEVEN.intervals(T7)
MAP = workspaces.workspace(TWO, 0.2, 2)
TABLE = urdf_ik.DHTable.from_chain(urdf_ik.load("puma_560").chain)
PLACES = urdf_ik.maps.placement(TWO, T2, bounds=[[-0.1, -0.1, 0], [0.1, 0.1, 0]], step=0.1)
STATE = (SIX.joint_names, Q6)



def zero(x: Any) -> Any:
    """What None, which is the default, stands for here."""
    return 0 if x is None else x


# What takes an object of one kind, or a name, a number or a truth value.
TAKES: dict[str, Callable[[Any], Any]] = {
    "plot.arm": plot.arm, "plot.branches": plot.branches, "plot.limits": plot.limits, "plot.path": plot.path,
    "plot.intervals": plot.intervals, "plot.workspace_slice": plot.workspace_slice,
    "plot.placements": plot.placements, "plot.planar_workspace": plot.planar_workspace, "plot.sliders": plot.sliders,
    "intervals in rad": lambda x: plot.intervals(INTERVALS, degrees=x),
    "regions and a posture": lambda x: plot.planar_workspace(workspaces.planar(TWO), x),
    "save": lambda x: plot.save(x, "x.png"), "cuspidal": cuspidality.is_cuspidal,
    "change": cuspidality.nonsingular_change, "analyse": structure.analyse,
    "manipulability": lambda x: velocity.manipulability(x, Q6),
    "condition number": lambda x: velocity.condition_number(x, Q6), "deviation": TABLE.deviation,
    "table in degrees": lambda x: TABLE.to_json(degrees=x),
    "snap": lambda x: urdf_ik.DHTable.from_chain(SIX.chain, snap=x), "boundary": workspaces.boundary,
    "opened": workspaces.opened, "placements.opened": placements.opened,
    "read waypoints": urdf_ik.read_waypoints, "look up": MAP.look_up, "values": MAP.values,
    "look up what": lambda x: MAP.look_up([[0.1, 0.1]], zero(x)), "slice": lambda x: MAP.slice(what=x),
    "places": MAP.grid.places, "best places": PLACES.places, "base": PLACES.base, "scores": PLACES.values,
    "interval": INTERVALS.samples, "best of intervals": INTERVALS.best, "nearest of intervals": INTERVALS.nearest,
    "within limits": lambda x: SEVEN.intervals(T7, x), "locked": SIX.with_locked,
    "positioner": lambda x: with_positioner(SIX, x, np.eye(4)), "axis": SIX.with_free_axis,
    "reconfigure": lambda x: SIX.follow(LINE, reconfigure=x), "collisions": lambda x: SIX.follow(LINE, collisions=x),
    "region": lambda x: SEVEN.ik_nearest(T7, Q7, region=zero(x)), "Region": urdf_ik.Region,
    "cone": lambda x: urdf_ik.Region(cone=x), "pairs": SIX.cell.collisions.checking,
    "package folders": lambda x: urdf_ik.Mesh("x.stl", package_dirs=zero(x)),
    "arguments of a xacro": lambda x: urdf_ik.load("a.xacro", xacro_args=zero(x)),
    "chain": lambda x: urdf_ik.load("<robot/>" if x is None else SIX.model.xml, chain=x),
    "redundancy": lambda x: urdf_ik.load("srs_7r", redundancy=zero(x)),
    "mesh roots": lambda x: urdf_ik.load("ur5", mesh_roots=zero(x)),
    "placement": lambda x: urdf_ik.maps.placement(x, T2, bounds=[[0, 0, 0], [1, 1, 0]], step=1.0),
    "step": lambda x: urdf_ik.maps.placement(TWO, T2, bounds=[[0, 0, 0], [1, 1, 0]], step=x),
    "bounds": lambda x: urdf_ik.maps.placement(TWO, T2, bounds=x, step=1.0),
    "mount": lambda x: urdf_ik.maps.placement(TWO, T2, bounds=[[0, 0, 0], [1, 1, 0]], step=1.0, mount=zero(x)),
    "margin of a map": lambda x: workspaces.workspace(TWO, 0.2, 2, margin=x),
    "output": lambda x: workspaces.workspace(TWO, 0.2, 2, output=zero(x)), "compare": lambda x: urdf_ik.compare(TWO, x),
    "ways": lambda x: completeness.compare(x, 1), "poses": lambda x: completeness.compare(SIX, x),
    "replay": lambda x: completeness.replay(SIX, 2, 0, x), "crosscheck": lambda x: crosscheck.check(x, 1),
    "crosscheck replay": lambda x: crosscheck.replay(SIX, 0, x),
    "joint state": lambda x: interop.to_joint_state(x, Q6, STATE[0]),
    "names": lambda x: interop.from_joint_state(SIX, x, Q6),
    "positions": lambda x: interop.from_joint_state(SIX, STATE[0], x),
    "scene": lambda x: interop.add_to_viser(x, SIX),
    "progress": lambda x: comparison.compare(TWO, TWO, 1, progress=zero(x)),
}  # fmt: skip


# Where these are no foreign kinds.
MAY = {"mesh roots": ("text",), "output": ("text",), "progress": ("a class",), "package folders": ("text", "a path")}


class Odd:
    """What cannot be written, and is no array."""

    def __init__(self, *_: Any) -> None:
        pass

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise RuntimeError("no array")

    def __repr__(self) -> str:
        raise RuntimeError("no text")


FOREIGN: dict[str, Callable[[], Any]] = {
    "nothing": lambda: None, "text": lambda: "\x9b31m", "a number": lambda: 1e308, "a huge integer": lambda: 10**400,
    "an imaginary number": lambda: 1j, "an array": lambda: np.full((3, 4, 5), np.nan),
    "texts": lambda: np.array([["x"]]), "an empty array": lambda: np.zeros((0, 6)),
    "a list around itself": lambda: _around(), "a file": lambda: io.BytesIO(b"zz"), "a class": lambda: Odd,
    "an odd object": Odd, "a path": lambda: Path("a\0b"), "a generator": lambda: (k for k in (1, 2)),
    "a long range": lambda: range(10**15),
}  # fmt: skip


def _around() -> list[Any]:
    inner: list[Any] = []
    inner.append(inner)
    return inner


@pytest.mark.parametrize("what", TAKES)
@pytest.mark.parametrize("kind", FOREIGN)
def test_objects_of_other_kinds_are_refused(
    what: str, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In words, without an order to the terminal; or they are taken, as None may be."""
    monkeypatch.chdir(tmp_path)
    given = FOREIGN[kind]()
    try:
        TAKES[what](given)
    except UrdfIkError as refused:
        assert len(str(refused)) < 2500
        assert "\x9b" not in str(refused)
    else:
        assert kind in MAY.get(what, ("nothing", "an empty array"))


