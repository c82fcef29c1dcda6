"""Chunks as Zarr itself writes them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from urdf_ik.maps.engine import zarr_writer

zarr = pytest.importorskip("zarr")


@pytest.mark.parametrize("kind", ["uint8", "uint16", "uint32", "int8", "float32", "float64"])
def test_chunks_have_the_bytes_that_zarr_writes(tmp_path: Path, kind: str) -> None:
    """A whole chunk, one at the end, one of fill values alone."""
    rng = np.random.default_rng(0)
    fill: Any = np.nan if kind.startswith("float") else 0
    plan = zarr_writer.ArrayPlan("values", ("x", "y"), (7, 3), (4, 3), kind, fill, {"units": "m"})
    values = rng.integers(0, 100, (7, 3)).astype(kind)
    for name, data in zarr_writer.group_files((plan,), (), {"robot": "none"}).items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(data)
    with zarr.config.set({"array.write_empty_chunks": True}):
        array = zarr.open_group(str(tmp_path), mode="a")["values"]
        encoder = zarr_writer.Encoder((plan,))
        for written in (values, np.full((7, 3), fill, kind)):
            array[...] = written
            for k, part in enumerate((written[:4], written[4:])):
                ((name, data),) = encoder.files((k,), {"values": part}).items()
                assert (tmp_path / name).read_bytes() == data
