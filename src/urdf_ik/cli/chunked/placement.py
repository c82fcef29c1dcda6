"""What ``urdf-ik placement`` prints: the best base positions of a grid."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.cli import console, tables
from urdf_ik.cli.progress import Progress
from urdf_ik.errors import ArgumentError
from urdf_ik.maps import placements
from urdf_ik.model.poses import to_rpy
from urdf_ik.show import plot
from urdf_ik.support.text import quoted

if TYPE_CHECKING:
    from urdf_ik.arm import Arm
    from urdf_ik.cli.chunked.places import Places
    from urdf_ik.cli.console import Angles


def run(
    arm: Arm,
    angles: Angles,
    targets: str,
    options: dict[str, Any],
    places: Places,
    *,
    count: int,
    picture: Path | None,
    score: str,
    as_json: bool,
) -> None:
    """Score base positions, print the ``count`` best ones, and draw the map.

    Raises:
        typer.BadParameter: places that cannot be, or a score that is not held.
        ArgumentError: a file without poses.
        ArgumentError: options of which no map can be made.
        JobError: a store that cannot be gone on with, or cannot be written.
        JobError: a scheduler or workers that cannot do the work.
        ArgumentError: a picture that cannot be written.
    """
    places.check()
    if score not in placements.SHOWN:
        raise console.usage(f"no score is called {quoted(score)}; there are {', '.join(placements.SHOWN)}", "--show")
    if picture is not None and picture.suffix.lower() not in plot.SUFFIXES:
        raise ArgumentError(f"{picture}: pictures are written as {', '.join(plot.SUFFIXES)}; name the file so")
    poses = console.read_poses(targets, "--targets")
    with places.client() as client, Progress("scoring positions", "solving") as progress:
        found = placements.placement(
            arm, poses, **options, store=places.store, client=client, progress=progress.tick
        )  # fmt: skip
    if picture is not None:
        plot.save(plot.placements(found, score), picture)
    console.write(_json(found, count) if as_json else _text(found, angles, count, picture), None)


def _text(found: placements.PlacementMap, angles: Angles, count: int, picture: Path | None) -> str:
    whole = int((found.reached == len(found.targets)).sum())
    counts = " x ".join(map(str, found.reached.shape[:3]))
    lines = [
        f"{found.about['robot']}: {found.about['base']} to {found.about['tip']}, {len(found.targets)} targets",
        f"{counts} positions, {len(found.headings)} heading{'s' * (len(found.headings) > 1)} at each; "
        f"all targets are reached from {whole} of {found.reached.size}",
    ]
    if found.followed is not None:
        lines.append(f"the path is followed from {int(found.followed.sum())} of them")
    if picture is not None:
        lines.append(f"picture written to {picture}")
    upright = bool(np.array_equal(found.mount, np.eye(3)))  # or roll and pitch are worth a column
    header = [
        "x [m]",
        "y [m]",
        "z [m]",
        *[f"{name} [{angles.unit}]" for name in ("roll", "pitch", "yaw")[2 * upright :]],
    ]
    header += ["reached", "branches", "margin"]
    header += ["clear [m]"] * (found.clearance is not None) + ["followed", "cost"] * (found.followed is not None)
    rows = []
    for place in found.places(count):
        turned = angles.angle(np.asarray(to_rpy(place.pose)))
        row = [tables.number(float(value), 3) for value in (*place.pose[:3, 3], *turned[2 * upright :])]
        row += [str(place.reached), str(place.branches), _known(place.margin)]
        row += [_known(place.clearance)] * (found.clearance is not None)
        row += ["yes" if place.followed else "no", _known(place.cost)] * (place.followed is not None)
        rows.append(row)
    return tables.render(*lines, "", tables.grid(header, rows))


def _known(value: float) -> str:
    return "-" if np.isnan(value) else tables.number(value, 3)


def _json(found: placements.PlacementMap, count: int) -> str:
    return console.json_text(
        {
            **found.about,
            "reached_all": int((found.reached == len(found.targets)).sum()),
            "places": [place._asdict() for place in found.places(count)],
        }
    )
