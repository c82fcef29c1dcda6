"""Options of the commands whose work is in chunks, each declared once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Option

from urdf_ik.cli.options import OBSTACLES, POSES_IN_A_FILE
from urdf_ik.support.inputs import MOST_THREADS

# Where the work is kept, and who does it.
Store = Annotated[
    Path | None,
    Option("--store", metavar="FOLDER", help="Make it on the disk, in this folder; run again, it goes on."),
]
Workers = Annotated[
    int | None, Option("--workers", min=1, help="Processes on this machine that fill the store (urdf-ik[scale]).")
]
Scheduler = Annotated[
    str | None,
    Option("--scheduler", metavar="ADDRESS", help="Dask scheduler whose workers fill the store, as tcp://HOST:PORT."),
]
Threads = Annotated[int, Option("--threads", min=1, max=MOST_THREADS, help="Threads that solve.")]

# Base positions.
Targets = Annotated[
    str,
    Option(
        "--targets",
        "-t",
        metavar="FILE",
        help=f"Poses of the tip in the cell: {POSES_IN_A_FILE}",
    ),
]
BaseBounds = Annotated[
    str,
    Option(
        "--bounds",
        metavar="X0,Y0,Z0,X1,Y1,Z1",
        help="Box of the base's positions in the cell [m]; equal numbers for an axis are one position on it.",
    ),
]
Step = Annotated[float, Option("--step", metavar="M", help="From one position to the next [m].")]
Headings = Annotated[int, Option("--turns", metavar="N", min=1, help="Headings of the base at each position.")]
Mount = Annotated[
    str | None, Option("--mount", metavar="R,P,Y", help="Orientation of the base at heading 0, of one that hangs.")
]
AlongPath = Annotated[bool, Option("--path", help="The targets are the waypoints of a path to be followed.")]
CellOfBase = Annotated[
    Path | None,
    Option("--world", metavar="FILE", help=f"{OBSTACLES} cell."),
]
LookForContacts = Annotated[
    bool | None,
    Option(
        "--collisions/--no-collisions",
        help="Count only what is free of contacts, or don't ask. Default: where there is a world.",
        show_default=False,
    ),
]
BestPlaces = Annotated[int, Option("--places", metavar="N", min=1, help="Number of best places to print.")]
Drawn = Annotated[Path | None, Option("--picture", metavar="FILE", help="Draw the map: PNG, SVG or PDF.")]
Score = Annotated[str, Option("--show", metavar="SCORE", help="Score to draw: reached, branches, margin, ...")]

# Samples.
SampleCount = Annotated[int, Option("-n", "--samples", min=1, help="Number of samples.")]
SampleStore = Annotated[
    Path,
    Option("--store", metavar="FOLDER", help="Where they go: NAME.zarr or NAME.parquet; run again, it goes on."),
]
SampleContacts = Annotated[
    bool | None,
    Option(
        "--collisions/--no-collisions",
        help="Say of each sample whether links touch, or not. Default: where the URDF has collision shapes.",
        show_default=False,
    ),
]
