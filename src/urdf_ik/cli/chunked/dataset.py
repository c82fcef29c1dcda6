"""What ``urdf-ik dataset`` prints: what the store holds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.cli import console, tables
from urdf_ik.cli.progress import Progress
from urdf_ik.maps import datasets

if TYPE_CHECKING:
    from pathlib import Path

    from urdf_ik.arm import Arm
    from urdf_ik.cli.chunked.places import Places

_FIRST = 4096  # samples that the figures are taken from


def run(arm: Arm, n: int, store: Path, options: dict[str, Any], places: Places, as_json: bool) -> None:
    """Draw samples into a store, and say what it holds.

    Raises:
        typer.BadParameter: places that cannot be.
        JobError: a store that cannot be gone on with, does not fit on the disk or cannot be written.
        JobError: a scheduler or workers that cannot do the work.
    """
    places.check()
    with places.client() as client, Progress("drawing samples", "solving") as progress:
        found = datasets.dataset(arm, n, store=store, **options, client=client, progress=progress.tick)
    size = sum(path.stat().st_size for path in found.path.rglob("*") if path.is_file())
    first = found.read(0, min(n, _FIRST))
    each = float((~np.isnan(first.solutions).any(axis=-1)).sum(axis=1).mean())
    if as_json:
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
