"""The commands whose work is in chunks: maps of the workspace, base positions, and samples."""

from __future__ import annotations

from typing import Any

from urdf_ik.cli import options
from urdf_ik.cli.chosen_arm import ChosenArm, angles_of, on_an_arm
from urdf_ik.cli.chunked import options as chunked
from urdf_ik.cli.chunked.places import Places
from urdf_ik.cli.options import ReportFormat
from urdf_ik.cli.program import app, help_text


@app.command(
    help=help_text(
        "Where the tip can be. Two turning joints in a plane: the exact regions of both elbows, bounded by arcs. Any "
        "other arm: a map of voxels x orientations, with the number of solutions, how many are within limits, and the "
        "share that each branch covers. `urdf-ik plot --map` draws it. With --store it is made on the disk, block by "
        "block: killed at any moment, the same command goes on where it stopped.",
        "urdf-ik workspace planar_2r --degrees",
        "urdf-ik workspace zyyzyz_6r --voxel 0.2 --orientations 50 -o map.npz",
        "urdf-ik workspace zyyzyz_6r --voxel 0.25 --orientations 50 --store map.zarr --workers 2",
    )
)
@on_an_arm
def workspace(
    *,
    voxel: options.Voxel = None,
    orientations: options.Orientations = None,
    bounds: options.Bounds = None,
    collision_free: options.MapFree = False,
    manipulability: options.Manipulability = False,
    margin: options.Margin = False,
    clearance: options.Clearance = False,
    world: options.Cell = None,
    threads: chunked.Threads = 1,
    work: Places,
    chosen: ChosenArm,
    degrees: options.Degrees = False,
    printed_as: options.TextFormat = ReportFormat.TABLE,
    output: options.MapFile = None,
) -> None:
    """Print the region, or the map's sums, and save the map."""
    from urdf_ik.cli import console, paths
    from urdf_ik.cli.chunked import workspace as workspace_command

    arm = chosen.load()
    box = None if bounds is None else console.box(bounds, "--bounds").tolist()
    given: dict[str, Any] = {"voxel": voxel, "orientations": orientations, "bounds": box}
    given |= {"collision_free": collision_free}
    given |= {"manipulability": manipulability, "margin": margin, "threads": None if threads == 1 else threads}
    given |= {"clearance": clearance, "world": paths.cell(world, chosen)}
    workspace_command.run(arm, angles_of(arm, degrees), output, work, printed_as is ReportFormat.JSON, given)


@app.command(
    help=help_text(
        "Where to put the base: every position of a grid, in every heading, scored by how many targets are reached "
        "from there within the limits, by how many branches, at which least limit margin and clearance, and with "
        "--path by whether the path is followed. The best places are printed; --picture draws the map. With --store "
        "it is made on the disk and goes on after a kill.",
        "urdf-ik placement zyyzyz_6r --targets seam.csv --bounds=-0.5,-0.5,0,0.5,0.5,0 --step 0.25",
        "urdf-ik placement zyyzyz_6r -t seam.csv --bounds=-0.5,0,0,0.5,0,0 --step 0.5 --path --world cell.urdf",
        "urdf-ik placement zyyzyz_6r -t seam.csv --bounds=-1,-1,0,1,1,0 --step 0.5 --turns 4 --store bases.zarr",
    )
)
@on_an_arm
def placement(
    *,
    targets: chunked.Targets,
    bounds: chunked.BaseBounds,
    step: chunked.Step,
    turns: chunked.Headings = 1,
    mount: chunked.Mount = None,
    as_path: chunked.AlongPath = False,
    world: chunked.CellOfBase = None,
    margin: options.Apart = None,
    collisions: chunked.LookForContacts = None,
    places: chunked.BestPlaces = 5,
    picture: chunked.Drawn = None,
    show: chunked.Score = "reached",
    threads: chunked.Threads = 1,
    work: Places,
    chosen: ChosenArm,
    degrees: options.Degrees = False,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Print the best places, and draw the map."""
    import numpy as np

    from urdf_ik.cli import console, paths
    from urdf_ik.cli.chunked import placement as placement_command
    from urdf_ik.model.poses import pose

    chosen.without_stdin(targets, "--targets")
    box = console.box(bounds, "--bounds")
    turned = None
    if mount is not None:
        rpy = console.numbers(mount, "--mount", ("roll", "pitch", "yaw"))
        turned = pose([0.0, 0.0, 0.0], rpy=np.deg2rad(rpy) if degrees else rpy)[:3, :3]
    given: dict[str, Any] = {"bounds": box, "step": step, "turns": turns, "mount": turned, "path": as_path}
    given |= {"world": paths.cell(world, chosen), "margin": margin or 0.0, "collisions": collisions, "threads": threads}
    arm = chosen.load()
    placement_command.run(
        arm,
        angles_of(arm, degrees),
        targets,
        given,
        work,
        count=places,
        picture=picture,
        score=show,
        as_json=printed_as is ReportFormat.JSON,
    )


@app.command(
    help=help_text(
        "Samples for learning: joint vectors drawn evenly within the limits, each with its pose, all solutions of it, "
        "the branch that was drawn, the Jacobian's singular values and whether links touch, to Zarr or Parquet. The "
        "bytes are the same for any number of workers, and after any kill.",
        "urdf-ik dataset zyyzyz_6r -n 1000 --store samples.parquet",
        "urdf-ik dataset zyyzyz_6r -n 2000 --seed 7 --no-collisions --store samples.zarr -f json",
    )
)
@on_an_arm
def dataset(
    *,
    n: chunked.SampleCount,
    store: chunked.SampleStore,
    seed: options.Seed = 0,
    world: options.Cell = None,
    collisions: chunked.SampleContacts = None,
    threads: chunked.Threads = 1,
    work: Places,
    chosen: ChosenArm,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Write the samples, and print what the store holds."""
    from urdf_ik.cli import paths
    from urdf_ik.cli.chunked import dataset as dataset_command

    given: dict[str, Any] = {"seed": seed, "world": paths.cell(world, chosen), "collisions": collisions}
    given["threads"] = threads
    dataset_command.run(chosen.load(), n, store, given, work, printed_as is ReportFormat.JSON)
