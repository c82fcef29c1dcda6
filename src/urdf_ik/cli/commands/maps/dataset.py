"""Draw samples for learning, to Zarr or Parquet.

Each sample is a joint vector drawn evenly within the limits, with its pose, all solutions of that pose, the branch that
was drawn, the Jacobian's singular values and whether links touch. The bytes are the same for any number of workers, and
after any kill.

Examples:
    urdf-ik dataset zyyzyz_6r -n 1000 --store samples.parquet
    urdf-ik dataset zyyzyz_6r -n 2000 --seed 7 --no-collisions --store samples.zarr -f json
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
from typer import Option

from urdf_ik.cli import console, options, tables
from urdf_ik.cli.arm_options import ArmOptions, read_world
from urdf_ik.cli.options import ReportFormat
from urdf_ik.cli.progress import Progress
from urdf_ik.cli.store_options import StoreOptions

_FIRST = 4096  # samples that the figures are taken from


def command(
    *,
    n: Annotated[
        int,
        Option("--random", "-n", metavar="N", min=1, help="Number of samples.", rich_help_panel=options.POSES),
    ],
    store: Annotated[
        Path,
        Option(
            metavar="FOLDER",
            help="NAME.zarr or NAME.parquet to write; the same command continues it.",
            rich_help_panel=StoreOptions.GROUP,
        ),
    ],
    seed: options.Seed = 0,
    world: options.World = None,
    collisions: options.Collisions = None,
    threads: options.Threads = 1,
    work: StoreOptions,
    chosen: ArmOptions,
    printed_as: options.TextFormat = ReportFormat.TABLE,
) -> None:
    """Write the samples, and print a summary of the store.

    Raises:
        typer.BadParameter: options that exclude each other.
        JobError: the store, the scheduler or the workers cannot be used, or the disk is too small.
    """
    from urdf_ik.maps import datasets

    obstacles = read_world(world, chosen)
    arm = chosen.load()
    work.check()
    with work.client() as client, Progress("drawing samples", "solving") as progress:
        found = datasets.dataset(
            arm,
            n,
            store=store,
            seed=seed,
            world=obstacles,
            collisions=collisions,
            threads=threads,
            client=client,
            progress=progress.tick,
        )
    size = sum(path.stat().st_size for path in found.path.rglob("*") if path.is_file())
    first = found.read(0, min(n, _FIRST))
    each = float((~np.isnan(first.solutions).any(axis=-1)).sum(axis=1).mean())
    if printed_as is ReportFormat.JSON:
        columns = {name: list(array.shape[1:]) for name, array in first.columns.items()}
        console.write(
            console.json_text({"store": str(found.path), **found.about, "bytes": size, "columns": columns}), None
        )
        return
    rows = [
        [name, " x ".join(map(str, (n, *array.shape[1:]))), str(array.dtype)] for name, array in first.columns.items()
    ]
    console.write(
        tables.render(
            f"{arm.name}: {arm.base} to {arm.tip}, {n} samples, seed {found.about['seed']}, in {found.path}",
            f"{size / 2**20:.3g} MiB; {each:.2f} solutions a sample, of the first {len(first.q)}",
            "",
            tables.grid(["column", "shape", "type"], rows, left=["column", "shape", "type"]),
        ),
        None,
    )
