"""What ``urdf-ik workspace`` prints: the exact region of a planar arm, or a map's sums and shares."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from urdf_ik.cli import console, tables
from urdf_ik.cli.progress import Progress
from urdf_ik.maps import workspaces
from urdf_ik.support import files

if TYPE_CHECKING:
    from urdf_ik.arm import Arm
    from urdf_ik.cli.chunked.places import Places
    from urdf_ik.cli.console import Angles


def run(arm: Arm, angles: Angles, output: Path | None, places: Places, as_json: bool, options: dict[str, Any]) -> None:
    """Print the exact region of two turning joints, or compute a map, print its sums and save it.

    Any other arm gets a map, and so does one for which an option of ``urdf_ik.maps.workspace``, a file or a store asks
    for it; None stands for an option that was not given.

    Raises:
        typer.BadParameter: places that cannot be.
        ArgumentError: ``output`` is a folder, or there is no folder for it.
        ArgumentError: options of which no map can be made, or a file that cannot be written.
        JobError: a store that cannot be gone on with, or cannot be written.
        JobError: a scheduler or workers that cannot do the work.
    """
    if output is not None:
        files.writable(output)
    if output is not None and places.store is not None:
        raise console.usage("a map goes into a file or into a store: give --output or --store", "--store")
    places.check()
    given = {name: value for name, value in options.items() if value is not None and value is not False}
    asked = bool(given) or output is not None or places.store is not None
    if arm.dof == 2 and arm.solver.control.plane is not None and not arm.chain.prismatic.any() and not asked:
        region = workspaces.planar(arm)
        console.write(_region_json(region) if as_json else _region_text(region, angles), None)
        return
    found: workspaces.WorkspaceMap | workspaces.StoredMap
    with places.client() as client, Progress("solving poses", "solving") as progress:
        if places.store is not None:
            found = workspaces.workspace(arm, **given, store=places.store, client=client, progress=progress.tick)
        else:
            found = workspaces.workspace(arm, **given, output=output, progress=progress.tick)
    console.write(_map_json(found) if as_json else _map_text(found, output or places.store), None)


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


def _map_text(found: workspaces.WorkspaceMap | workspaces.StoredMap, place: Path | None) -> str:
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


def _map_json(found: workspaces.WorkspaceMap | workspaces.StoredMap) -> str:
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
