"""The region that the tip reaches: exact for a planar arm, a map for any other.

Two turning joints in a plane: the exact regions of both elbows, bounded by arcs. Any other arm: a map of voxels x
orientations, with the number of solutions, how many are within limits, and the share that each branch covers.
`urdf-ik plot --map` draws it. With --store it is computed on the disk, block by block: killed at any moment, the same
command continues where it stopped.

Examples:
    urdf-ik workspace planar_2r --degrees
    urdf-ik workspace zyyzyz_6r --voxel 0.2 --orientations 50 -o map.npz
    urdf-ik workspace zyyzyz_6r --voxel 0.25 --orientations 50 --store map.zarr --workers 2
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar

from typer import Option

from urdf_ik.cli import console, options, tables
from urdf_ik.cli.arm_options import ArmOptions, angles_of, read_world
from urdf_ik.cli.console import Angles
from urdf_ik.cli.options import ReportFormat
from urdf_ik.cli.progress import Progress
from urdf_ik.cli.store_options import StoreOptions
from urdf_ik.maps import workspaces
from urdf_ik.support import files
from urdf_ik.support.text import quoted

_VALUES = ("collision-free", "manipulability", "margin", "clearance")


@dataclass(frozen=True)
class MapOptions:
    """Options of a map that have the names of ``urdf_ik.maps.workspace``'s arguments."""

    GROUP: ClassVar[str] = "Map"
    voxel: Annotated[
        float | None, Option(metavar="M", help="Edge of a voxel [m]. Default: 0.1.", show_default=False)
    ] = None
    orientations: Annotated[
        int | None,
        Option(metavar="N", min=1, help="Number of them at each voxel. Default: 200.", show_default=False),
    ] = None
    bounds: Annotated[
        str | None,
        Option(metavar="X0,Y0,Z0,X1,Y1,Z1", help="Box to look at [m]. Default: the reach of the links."),
    ] = None
    values: Annotated[
        str | None,
        Option(
            metavar="KINDS",
            help="Keep more of each voxel: manipulability, margin, and collision-free, clearance (slow); with commas.",
        ),
    ] = None
    threads: options.Threads = 1

    def given(self) -> dict[str, Any]:
        """The options that differ from their defaults.

        Raises:
            typer.BadParameter: an unknown value, or a box that is none.
        """
        out = {name: value for name, value in asdict(self).items() if value != getattr(MapOptions, name)}
        for kind in out.pop("values", "").replace(",", " ").split():
            if kind not in _VALUES:
                raise console.usage(f"no value is called {quoted(kind)}; there are {', '.join(_VALUES)}", "--values")
            out[kind.replace("-", "_")] = True
        return out if self.bounds is None else out | {"bounds": console.box(self.bounds, "--bounds").tolist()}


def command(
    *,
    map: MapOptions,  # noqa: A002  the group of its options
    world: options.World = None,
    work: StoreOptions,
    chosen: ArmOptions,
    degrees: options.Degrees = False,
    printed_as: options.TextFormat = ReportFormat.TABLE,
    output: Annotated[
        Path | None,
        Option("--output", "-o", metavar="FILE", help="Write the map here, as .npz.", rich_help_panel=options.OUTPUT),
    ] = None,
) -> None:
    """Print the exact region of two turning joints; or compute a map, print its sums and save it.

    A planar arm gets a map, too, where an option, a file or a store asks for one.

    Raises:
        typer.BadParameter: options that exclude each other.
        ArgumentError: ``output`` cannot be written, or an option has an invalid value.
        JobError: the store, the scheduler or the workers cannot be used.
    """
    from urdf_ik.maps import workspaces

    arm = chosen.load(degrees)
    as_json = printed_as is ReportFormat.JSON
    given = map.given()
    if world is not None:
        given["world"] = read_world(world, chosen)
    if output is not None:
        files.writable(output)
    if output is not None and work.store is not None:
        raise console.usage("a map goes into a file or into a store: give --output or --store", "--store")
    work.check()
    wants_map = bool(given) or output is not None or work.store is not None
    if arm.dof == 2 and arm.solver.control.plane is not None and not arm.chain.prismatic.any() and not wants_map:
        region = workspaces.planar(arm)
        console.write(_region_json(region) if as_json else _region_text(region, angles_of(arm, degrees)), None)
        return
    with work.client() as client, Progress("solving poses", "solving") as progress:
        if work.store is not None:
            found = workspaces.stored_workspace(arm, work.store, **given, client=client, progress=progress.tick)
        else:
            found = workspaces.workspace(arm, **given, output=output, progress=progress.tick)
    console.write(_map_json(found) if as_json else _map_text(found, output or work.store), None)


def _region_text(region: workspaces.PlanarWorkspace, angles: Angles) -> str:
    areas = [(name, part.area) for name, part in _parts(region).items()]
    total = region.boundary.area
    table = tables.grid(
        ["region", "area [m2]", "share [%]"],
        [[name, f"{area:.6f}", f"{100.0 * area / total:.1f}"] for name, area in areas],
        left=["region"],
    )
    rows = [
        [
            name,
            *(tables.number(float(x), 6) for x in (*arc.centre, arc.radius)),
            *(tables.number(float(angles.angle(x)), 4) for x in (arc.start, arc.start + arc.sweep)),
            arc.name,
        ]
        for name, part in _parts(region).items()
        for arc in part.arcs
    ]
    header = ["arc of", "x [m]", "y [m]", "radius [m]", f"from [{angles.unit}]", f"to [{angles.unit}]", "where"]
    head = f"{region.name}: exact workspace of two turning joints, links {region.lengths[0]:g} and "
    return tables.render(
        f"{head}{region.lengths[1]:g} m",
        "",
        table,
        "",
        tables.grid(header, rows, left=["arc of", "where"]),
    )


def _parts(region: workspaces.PlanarWorkspace) -> dict[str, workspaces.Region]:
    return {"either elbow": region.boundary, **region.regions, "both, two solutions": region.overlap}


def _region_json(region: workspaces.PlanarWorkspace) -> str:
    return console.json_text(
        {
            "robot": region.name,
            "lengths": region.lengths,
            "axes": region.plane.axes,
            "units": {"angle": "rad", "length": "m"},
            "regions": {
                name: {
                    "area": part.area,
                    "arcs": [
                        {"centre": arc.centre, "radius": arc.radius, "start": arc.start, "sweep": arc.sweep}
                        for arc in part.arcs
                    ],
                }
                for name, part in _parts(region).items()
            },
        }
    )


def _map_text(found: workspaces.WorkspaceMap, place: Path | None) -> str:
    about, unit = found.about, "m2" if found.about.task.startswith("planar") else "m3"
    totals, cell = found.totals(), found.about.cell(found.grid.voxel)
    volume, dexterous = totals.reached_voxels * cell, totals.dexterous_voxels * cell
    shape = " x ".join(map(str, found.grid.shape))
    lines = [
        f"{about.robot}: {about.base} to {about.tip}, {about.task}",
        f"{shape} voxels of {found.grid.voxel:g} m, {len(found.samples)} at each: {about.sampled}",
        f"reached: {totals.reached_poses} of {totals.poses} poses, {totals.reached_voxels} of {totals.voxels} voxels",
        f"volume: {volume:.4f} {unit}, in every orientation {dexterous:.4f} {unit}",
    ]
    names = {"solutions": "solutions", "within": "within limits", "free": "free of collision"}
    lines += [f"{names[name]}: {count}" for name, count in totals.solutions.items()]
    if place is not None:
        lines.append(f"map written to {place}")
    rows = [
        [name, f"{100.0 * share.voxels:.1f}", f"{100.0 * share.poses:.1f}"]
        for name, share in totals.branch_shares.items()
    ]
    table = tables.grid(["branch", "voxels [%]", "poses [%]"], rows, left=["branch"])
    return tables.render(*lines, "", table)


def _map_json(found: workspaces.WorkspaceMap) -> str:
    about, totals, cell = found.about, found.totals(), found.about.cell(found.grid.voxel)
    return console.json_text(
        {
            "robot": about.robot,
            "urdf_sha256": about.urdf_sha256,
            "task": about.task,
            "counted": about.counted,
            "grid": found.grid.described(),
            "poses": {"all": totals.poses, "reached": totals.reached_poses},
            "voxels": {"all": totals.voxels, "reached": totals.reached_voxels},
            "volume": totals.reached_voxels * cell,
            "dexterous_volume": totals.dexterous_voxels * cell,
            "branches": {name: share._asdict() for name, share in totals.branch_shares.items()},
        }
    )
