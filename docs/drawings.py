"""Draws the arms of the explanation pages: each family's axes, by the library's own pictures.

Run by hand, `python docs/drawings.py FOLDER` writes them there.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import urdf_ik
from urdf_ik.show import plot
from urdf_ik.support import palette

_ROW = tuple[float, float, float, float]
_R = np.pi / 2.0


@dataclass(frozen=True)
class Drawing:
    """An arm of a family, in a posture in which its axes can be told apart.

    Attributes:
        arm: what `load` takes, or rows alpha, a, d, theta of a modified Denavit-Hartenberg table.
        q: the posture [rad or m].
        marked: joints, counted from 1, whose axes make the family.
    """

    arm: str | tuple[_ROW, ...]
    q: tuple[float, ...]
    marked: tuple[int, ...]
    joint_types: str = ""

    def load(self, name: str) -> urdf_ik.Arm:
        """The arm."""
        if isinstance(self.arm, str):
            return urdf_ik.load(self.arm)
        kinds = self.joint_types or "R" * len(self.arm)
        limits = [(-1.0, 1.0) if kind == "P" else (-np.pi, np.pi) for kind in kinds]
        table = urdf_ik.DHTable.from_array(
            self.arm, "modified", joint_types=kinds, limits=limits, name=name.replace("-", "_")
        )
        return urdf_ik.load(table.to_urdf())


DRAWINGS = {
    "spherical-wrist": Drawing("zyyzyz_6r", (0.4, 0.5, 0.9, 0.3, 0.7, 0.0), (4, 5, 6)),
    "three-parallel": Drawing(
        ((0, 0, 0.3, 0), (_R, 0, 0, 0), (0, 0.5, 0, 0), (0, 0.4, 0.15, 0), (_R, 0, 0.12, 0), (-_R, 0, 0.1, 0)),
        (0.4, 0.9, -1.2, 0.6, 0.8, 0.0),
        (2, 3, 4),
    ),
    "parallel-shoulder": Drawing(
        ((0, 0, 0.3, 0), (0, 0.4, 0.05, 0), (0, 0.35, 0, 0), (_R, 0.1, 0.1, 0), (_R, 0, 0.2, 0), (_R, 0, 0.1, 0)),
        (0.4, 0.7, -0.9, 0.5, 0.8, 0.0),
        (1, 2, 3),
    ),
    "spherical-middle": Drawing(
        ((0, 0, 0.2, 0), (_R, 0.4, 0, 0), (_R, 0, 0, 0), (-_R, 0, 0, 0), (_R, 0.4, 0.1, 0), (_R, 0, 0.2, 0)),
        (0.4, 0.7, 0.9, 0.5, 0.8, 0.0),
        (2, 3, 4),
    ),
    "general-6r": Drawing(
        ((0, 0, 0.3, 0), (1.2, 0.1, 0.1, 0), (0.6, 0.4, 0.1, 0), (1.3, 0, 0.3, 0), (-1.1, 0.1, 0, 0), (1.4, 0.1, 0, 0)),
        (0.4, 0.9, -1.2, 0.6, 0.8, 0.0),
        (1, 2, 3, 4, 5, 6),
    ),
    "slides": Drawing("stanford_rrprrr", (0.4, 0.9, 0.5, 0.6, 0.8, 0.0), (3,)),
    "few-joints": Drawing("scara_rrpr", (0.5, 0.9, 0.05, 0.3), (1, 2, 4)),
    "five-joints": Drawing(
        ((0, 0, 0.2, 0), (_R, 0, 0, 0), (0, 0.4, 0, 0), (0, 0.35, 0, 0), (_R, 0, 0.15, 0)),
        (0.4, 0.9, -1.2, 0.6, 0.0),
        (2, 3, 4),
    ),
    "srs": Drawing("srs_7r", (0.3, 0.6, 0.4, 1.2, 0.3, 0.7, 0.0), (1, 2, 3, 5, 6, 7)),
    "joint-given": Drawing(
        (
            (0, 0, 0.33, 0), (-_R, 0, 0, 0), (_R, 0, 0.32, 0), (_R, 0.08, 0, 0),
            (-_R, -0.08, 0.38, 0), (_R, 0, 0, 0), (_R, 0.09, 0.1, 0),
        ),
        (0.3, 0.5, 0.4, -1.6, 0.3, 1.7, 0.0),
        (7,),
    ),
}  # fmt: skip


def write(folder: Path) -> None:
    """Draw every arm as SVG into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, drawing in DRAWINGS.items():
        plot.save(axes_of(drawing.load(name), np.array(drawing.q), drawing.marked), str(folder / f"{name}.svg"))
    fold(folder / "fold.svg")


def axes_of(arm: urdf_ik.Arm, q: np.ndarray, marked: tuple[int, ...]) -> Figure:
    """The stick figure of an arm with its joint axes, those that make its family in blue and thick."""
    figure = plot.arm(arm, q, shapes=False)
    (axes,) = figure.axes
    reach = 0.16 * arm.chain.size
    poses = arm.link_poses(q)
    blue, grey = palette.colours(1)[0], "0.55"
    joints = [joint for joint in arm.model.path_between(arm.base, arm.tip) if joint.type != "fixed"]
    for number, joint in enumerate(joints, start=1):
        pose = poses[joint.child]
        along = reach * (pose[:3, :3] @ joint.axis)
        ends = np.stack([pose[:3, 3] - along, pose[:3, 3] + along])
        shown = number in marked
        axes.plot(
            *ends.T, color=blue if shown else grey, linewidth=2.5 if shown else 1.2, linestyle="-" if shown else "--"
        )
        axes.text(*ends[1], str(number), color=blue if shown else grey, fontsize=11, fontweight="bold")
    axes.set_title("")
    return figure


def fold(file: Path) -> None:
    """The two elbows of a two-link arm as the target moves out of reach: two roots of one margin that meet."""
    from matplotlib.figure import Figure

    arm = urdf_ik.load("planar_2r_unit")
    distances = np.linspace(1.6, 2.0, 400)
    answer = arm.ik(np.stack([distances, np.zeros_like(distances)], axis=-1), task="planar position")
    figure = Figure(figsize=(5.5, 3.2), layout="constrained")
    axes = figure.add_subplot()
    for column, colour in enumerate(palette.colours(2)):
        axes.plot(distances, answer.q[:, column, 1], color=colour, label=answer.branches[column], linewidth=2)
    axes.set_xlabel("distance of the target from the shoulder [m]")
    axes.set_ylabel("elbow angle [rad]")
    axes.axvline(2.0, color="0.6", linestyle="--", linewidth=1)
    axes.legend()
    figure.savefig(file)


if __name__ == "__main__":
    write(Path(sys.argv[1]))
