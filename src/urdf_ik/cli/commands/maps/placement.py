"""Find where to put the base: every position of a grid, in every heading, with scores.

The scores are the number of targets that are reached within the limits, the number of branches, the least limit margin
and clearance, and with --path whether the path can be followed. The best places are printed; --output draws the map.
With --store it is computed on the disk and continues after a kill.

Examples:
    urdf-ik placement zyyzyz_6r --poses seam.csv --bounds=-0.5,-0.5,0,0.5,0.5,0 --step 0.25
    urdf-ik placement zyyzyz_6r -p seam.csv --bounds=-0.5,0,0,0.5,0,0 --step 0.5 --path --world cell.urdf
    urdf-ik placement zyyzyz_6r -p seam.csv --bounds=-1,-1,0,1,1,0 --step 0.5 --headings 4 --store bases.zarr
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
from typer import Option

from urdf_ik.arm import Arm
from urdf_ik.cli import console, options, tables
from urdf_ik.cli.arm_options import ArmOptions, angles_of, read_world
from urdf_ik.cli.console import Angles
from urdf_ik.cli.options import ReportFormat
from urdf_ik.cli.progress import Progress
from urdf_ik.cli.store_options import StoreOptions
from urdf_ik.errors import ArgumentError
from urdf_ik.maps import placements
from urdf_ik.support.text import quoted


def command(
    *,
    given: options.PoseOptions,
    bounds: Annotated[
        str,
        Option(
            metavar="X0,Y0,Z0,X1,Y1,Z1",
            help="Box of the base's positions in the cell [m]; equal numbers: one position.",
        ),
    ],
    step: Annotated[float, Option(metavar="M", help="From one position to the next [m].")],
    headings: Annotated[int, Option(metavar="N", min=1, help="Headings of the base at each position.")] = 1,
    mount: Annotated[
        str | None, Option(metavar="R,P,Y", help="Orientation of the base at heading 0, for an arm that hangs.")
    ] = None,
    as_path: Annotated[bool, Option("--path", help="The targets are the waypoints of a path to be followed.")] = False,
    world: options.World = None,
    margin: options.Margin = None,
    collisions: options.Collisions = None,
    places: Annotated[int, Option(metavar="N", min=1, help="Number of best places to print.")] = 5,
    show: Annotated[str, Option(metavar="VALUE", help="Score to draw: reached, branches, margin, ...")] = "reached",
    threads: options.Threads = 1,
    work: StoreOptions,
    chosen: ArmOptions,
    degrees: options.Degrees = False,
    printed_as: options.TextFormat = ReportFormat.TABLE,
    output: Annotated[
        Path | None,
        Option(
            "--output",
            "-o",
            metavar="FILE",
            help="Draw the map: PNG, SVG or PDF.",
            rich_help_panel=options.OUTPUT,
        ),
    ] = None,
) -> None:
    """Score base positions, print the best ones, and draw the map.

    Raises:
        typer.BadParameter: options that exclude each other, or an unknown score.
        ArgumentError: a file without poses, invalid options, or a picture that cannot be written.
        JobError: the store, the scheduler or the workers cannot be used.
    """
    from urdf_ik.cli.solutions import targets
    from urdf_ik.maps import placements
    from urdf_ik.model.poses import pose
    from urdf_ik.show import plot

    chosen.apart_from(given)
    work.check()
    if show not in placements.SHOWN:
        raise console.usage(f"no score is called {quoted(show)}; there are {', '.join(placements.SHOWN)}", "--show")
    if output is not None and output.suffix.lower() not in plot.SUFFIXES:
        raise ArgumentError(f"{output}: pictures are written as {', '.join(plot.SUFFIXES)}; name the file so")
    box = console.box(bounds, "--bounds")
    turned = None
    if mount is not None:
        rpy = console.numbers(mount, "--mount", ("roll", "pitch", "yaw"))
        turned = pose([0.0, 0.0, 0.0], rpy=np.deg2rad(rpy) if degrees else rpy)[:3, :3]
    obstacles = read_world(world, chosen)
    arm = chosen.load(degrees)
    target = targets.required(arm, given, angles_of(arm, degrees), "targets")
    with work.client() as client, Progress("scoring positions", "solving") as progress:
        found = placements.placement(
            arm,
            target.poses,
            bounds=box,
            step=step,
            turns=headings,
            mount=turned,
            path=as_path,
            world=obstacles,
            margin=margin or 0.0,
            collisions=collisions,
            threads=threads,
            store=work.store,
            client=client,
            progress=progress.tick,
        )
    if output is not None:
        plot.save(plot.placements(found, show), output)
    angles = angles_of(arm, degrees)
    console.write(
        _json(found, places) if printed_as is ReportFormat.JSON else _text(found, arm, angles, places, output), None
    )


def _text(found: placements.PlacementMap, arm: Arm, angles: Angles, count: int, picture: Path | None) -> str:
    from urdf_ik.model.poses import to_rpy

    whole = int((found.reached == len(found.targets)).sum())
    counts = " x ".join(map(str, found.reached.shape[:3]))
    lines = [
        f"{found.about['robot']}: {found.about['base']} to {found.about['tip']}, {len(found.targets)} targets",
        f"{counts} positions, {len(found.headings)} heading{'s' * (len(found.headings) > 1)} at each; "
        f"all targets are reached from {whole} of {found.reached.size}",
    ]
    if found.followed is not None:
        lines.append(f"the path is followed from {int(found.followed.sum())} of them")
    if not found.reached.any():
        base = found.places(1)[0].pose
        why = arm.explain(np.linalg.inv(base) @ found.targets[0]) or "it touches something"
        at = ", ".join(tables.number(float(value), 3) for value in base[:3, 3])
        lines += tables.folded("", f"from ({at}) m, target 0: {why}".split(" "), " ")
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
