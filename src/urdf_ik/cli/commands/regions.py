"""The commands ``workspace`` and ``placement``: where the tip reaches, and where the base should stand."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from urdf_ik.arm import Arm
from urdf_ik.cli import console, options, tables
from urdf_ik.cli.arm_options import ArmOptions, read_world
from urdf_ik.cli.console import Angles, Progress, usage
from urdf_ik.cli.options import PoseOptions, ReportFormat
from urdf_ik.errors import ArgumentError
from urdf_ik.maps import placements, workspaces
from urdf_ik.support import files
from urdf_ik.typing import Array

_VALUES = ("collision-free", "manipulability", "margin", "clearance")


@dataclass(frozen=True)
class _StoreOptions(options.Record):
    """The folder that keeps long work and the workers that do it, as typed.

    Options:
        store (FOLDER): Keep the work there; the same command continues it.
        workers (N): Processes that fill the store (urdf-ik[scale]).
        scheduler (ADDRESS): Dask scheduler of other workers, as tcp://HOST:PORT.
    """

    GROUP = "Store and workers"
    store: Path | None = None
    workers: int | None = None
    scheduler: str | None = None

    @contextmanager
    def client(self) -> Iterator[Any]:
        """The workers, for as long as the work takes; None for this process."""
        if self.workers is None and self.scheduler is None:
            yield None
            return
        if self.workers is not None and self.scheduler is not None:
            raise usage("--scheduler has workers of its own: give it or --workers", "--workers")
        if self.store is None:
            raise usage("workers fill a store: give --store FOLDER, too", "--workers")
        from urdf_ik.maps import cluster

        with cluster.connect(self.scheduler, self.workers) as client:
            yield client


@dataclass(frozen=True)
class _MapOptions(options.Record):
    """Options of a map that have the names of ``urdf_ik.maps.workspace``'s arguments.

    Options:
        voxel (M): Edge of a voxel [m]. Default: 0.1.
        orientations (N): Number of them at each voxel. Default: 200.
        bounds (X0,Y0,Z0,X1,Y1,Z1): Box to look at [m]. Default: the reach of the links.
        values (KINDS): Keep more of each voxel: manipulability, margin, and collision-free, clearance (slow); with
            commas.
    """

    GROUP = "Map"
    voxel: float | None = None
    orientations: int | None = None
    bounds: str | None = None
    values: str | None = None
    threads: int = 1

    def changed(self) -> dict[str, Any]:
        """The options that differ from their defaults."""
        out = {name: value for name, value in asdict(self).items() if value != getattr(_MapOptions, name)}
        for kind in console.split(out.pop("values", "")):
            if kind not in _VALUES:
                raise usage(f"no value is called {kind!r}; there are {', '.join(_VALUES)}", "--values")
            out[kind.replace("-", "_")] = True
        return out if self.bounds is None else out | {"bounds": console.box(self.bounds, "--bounds").tolist()}


def workspace(
    *,
    map: _MapOptions,  # noqa: A002  the group of its options
    world: Path | None = None,
    work: _StoreOptions,
    chosen: ArmOptions,
    degrees: bool = False,
    printed_as: ReportFormat = ReportFormat.TABLE,
    output: Path | None = None,
) -> None:
    """The region that the tip reaches: exact for a planar arm, a map for any other.

    Two turning joints in a plane: the exact regions of both elbows, bounded by arcs. Any other arm: a map of voxels
    x orientations, with the number of solutions, how many are within limits, and the share that each branch covers.
    `urdf-ik plot --map` draws it. With --store it is computed on the disk, block by block: killed at any moment,
    the same command continues where it stopped.

    Examples:
        urdf-ik workspace planar_2r --degrees
        urdf-ik workspace zyyzyz_6r --voxel 0.2 --orientations 50 -o map.npz
        urdf-ik workspace zyyzyz_6r --voxel 0.25 --orientations 50 --store map.zarr --workers 2

    Options:
        output (-o FILE): Write the map here, as .npz.
    """
    arm, angles = chosen.loaded(degrees)
    asked = map.changed()
    if world is not None:
        asked["world"] = read_world(world, chosen)
    if output is not None:
        files.writable(output)
    if output is not None and work.store is not None:
        raise usage("a map goes into a file or into a store: give --output or --store", "--store")
    wants_map = bool(asked) or output is not None or work.store is not None
    if arm.dof == 2 and arm.solver.control.plane is not None and not arm.chain.prismatic.any() and not wants_map:
        region = workspaces.planar(arm)
        console.emit(printed_as, _region_data(region, angles), lambda: _region_text(region, angles))
        return
    with work.client() as client, Progress("solving poses") as progress:
        if work.store is not None:
            found = workspaces.stored_workspace(arm, work.store, **asked, client=client, progress=progress.tick)
        else:
            found = workspaces.workspace(arm, **asked, progress=progress.tick)
    if output is not None:
        found.save(output)
    console.emit(printed_as, _map_data(found), lambda: _map_text(found))
    if (place := output or work.store) is not None:
        console.say(f"map written to {place}")


def _region_text(region: workspaces.PlanarWorkspace, angles: Angles) -> str:
    """The areas of the regions; the arcs that bound them are in the JSON."""
    data, total = _region_data(region, angles), region.boundary.area
    shares = [
        {"region": name, "area [m2]": f"{each['area']:.6f}", "share [%]": f"{100.0 * each['area'] / total:.1f}"}
        for name, each in data["regions"].items()
    ]
    head = f"{region.name}: exact workspace of two turning joints"
    return tables.render(head, "", tables.outline({"links [m]": list(region.lengths), "regions": shares}))


def _parts(region: workspaces.PlanarWorkspace) -> dict[str, workspaces.Region]:
    return {"either elbow": region.boundary, **region.regions, "both, two solutions": region.overlap}


def _region_data(region: workspaces.PlanarWorkspace, angles: Angles) -> dict[str, Any]:
    def arc(one: Any) -> dict[str, Any]:
        ends = {"start": angles.angle(one.start), "sweep": angles.angle(one.sweep)}
        return {"centre": one.centre, "radius": one.radius, **ends}

    regions = {
        name: {"area": part.area, "arcs": [arc(one) for one in part.arcs]} for name, part in _parts(region).items()
    }
    about = {"robot": region.name, "lengths": region.lengths, "axes": region.plane.axes}
    return about | {"units": {"angle": angles.unit, "length": "m"}, "regions": regions}


def _map_text(found: workspaces.WorkspaceMap) -> str:
    """The sums of a map in the units of its task, and the share of each branch."""
    data, totals = _map_data(found), found.totals()
    del data["urdf_sha256"]
    unit = "m2" if data["task"].startswith("planar") else "m3"
    data |= {name: f"{data[name]:.4f} {unit}" for name in ("volume", "dexterous_volume")}
    data |= {"orientations": f"{len(found.samples)} at each voxel: {found.about['sampled']}", **totals["solutions"]}
    shares = {name: {f"{key} [%]": 100.0 * x for key, x in each.items()} for name, each in data["branches"].items()}
    return tables.render(tables.outline(data | {"branches": shares}))


def _map_data(found: workspaces.WorkspaceMap) -> dict[str, Any]:
    totals, cell = found.totals(), found.cell
    return {
        **{name: found.about[name] for name in ("robot", "urdf_sha256", "task", "counted")},
        "grid": found.grid.described(),
        "poses": totals["poses"],
        "voxels": totals["voxels"],
        "volume": totals["voxels"]["reached"] * cell,
        "dexterous_volume": totals["dexterous_voxels"] * cell,
        "branches": totals["branches"],
    }


def placement(
    *,
    typed: PoseOptions,
    bounds: str,
    step: float,
    headings: int = 1,
    mount: str | None = None,
    as_path: bool = False,
    world: Path | None = None,
    margin: float | None = None,
    collisions: bool | None = None,
    chosen: ArmOptions,
    degrees: bool = False,
    printed_as: ReportFormat = ReportFormat.TABLE,
    output: Path | None = None,
) -> None:
    """Find where to put the base: every position of a grid, in every heading, with scores.

    The scores are the number of targets that are reached within the limits, the number of branches, the least limit
    margin and clearance, and with --path whether the path can be followed. The best places are printed; --output
    draws the map.

    Examples:
        urdf-ik placement zyyzyz_6r --poses seam.csv --bounds=-0.5,-0.5,0,0.5,0.5,0 --step 0.25
        urdf-ik placement zyyzyz_6r -p seam.csv --bounds=-0.5,0,0,0.5,0,0 --step 0.5 --path --world cell.urdf
        urdf-ik placement zyyzyz_6r -p seam.csv --bounds=-1,-1,0,1,1,0 --step 0.5 --headings 4 -o bases.png

    Options:
        bounds (X0,Y0,Z0,X1,Y1,Z1): Box of the base's positions in the cell [m]; equal numbers: one position.
        step (M): From one position to the next [m].
        headings (N): Headings of the base at each position.
        mount (R,P,Y): Orientation of the base at heading 0, for an arm that hangs.
        as_path (--path): The targets are the waypoints of a path to be followed.
        output (-o FILE): Draw the map: PNG, SVG or PDF.
    """
    from urdf_ik.cli import targets
    from urdf_ik.model.poses import pose
    from urdf_ik.show import plot

    if output is not None and output.suffix.lower() not in plot.SUFFIXES:
        raise ArgumentError(f"{output}: pictures are written as {', '.join(plot.SUFFIXES)}; name the file so")
    box = console.box(bounds, "--bounds")
    turned = None
    if mount is not None:
        rpy = console.numbers(mount, "--mount", ("roll", "pitch", "yaw"))
        turned = pose([0.0, 0.0, 0.0], rpy=np.deg2rad(rpy) if degrees else rpy)[:3, :3]
    obstacles = read_world(world, chosen)
    arm, angles = chosen.loaded(degrees, typed)
    target = targets.required(arm, typed, angles, "targets")
    with Progress("scoring positions") as progress:
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
            progress=progress.tick,
        )
    if output is not None:
        plot.save(plot.placements(found), output)
    best = found.places()
    data = {
        **found.about,
        "reached_all": int((found.reached == len(found.targets)).sum()),
        "places": [place._asdict() for place in best],
    }
    console.emit(printed_as, data, lambda: _places_text(found, arm, angles, data, best))
    if output is not None:
        console.say(f"picture written to {output}")


def _places_text(found: placements.PlacementMap, arm: Arm, angles: Angles, data: dict[str, Any], best: Any) -> str:
    """The sums of a map of positions, and a table of the best ones."""
    about: dict[str, Any] = {name: data[name] for name in ("robot", "base", "tip", "reached_all")}
    about |= {"targets": len(found.targets), "positions": " x ".join(map(str, found.reached.shape[:3]))}
    about["headings"] = len(found.headings)
    if found.followed is not None:
        about["followed"] = int(found.followed.sum())
    if not found.reached.any():
        base = best[0].pose
        why = arm.explain(np.linalg.inv(base) @ found.targets[0]) or "it touches something"
        about["why"] = f"from ({', '.join(tables.numbers(base[:3, 3], 3))}) m, target 0: {why}"
    names = ("x [m]", "y [m]", "z [m]", *(f"{name} [{angles.unit}]" for name in ("roll", "pitch", "yaw")))
    tilted = not np.array_equal(found.mount, np.eye(3))  # or roll and pitch are worth a column
    about["places"] = [
        {name: value for name, value in zip(names, _where(place, angles), strict=True) if tilted or name[0] not in "rp"}
        | {name: value for name, value in place._asdict().items() if name not in ("pose", "solutions")}
        for place in best
    ]
    return tables.render(tables.outline(about))


def _where(place: placements.Place, angles: Angles) -> Array:
    """Position [m] and roll, pitch, yaw of a place, as shown."""
    from urdf_ik.model.poses import to_rpy

    return np.round(np.hstack([place.pose[:3, 3], angles.angle(np.asarray(to_rpy(place.pose)))]), 6)
