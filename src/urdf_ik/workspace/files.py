"""Workspace maps in files: a compressed ``.npz`` without pickle, with a header in JSON.

The array ``header`` is text: format, version, the fields of ``About`` and the grid. The other arrays are those of
``WorkspaceMap``, by its attributes' names; those that were not computed are left out.
"""

from __future__ import annotations

import json
import os
import zipfile
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from urdf_ik.errors import WorkspaceError
from urdf_ik.workspace.grid import Grid
from urdf_ik.workspace.maps import About, WorkspaceMap

if TYPE_CHECKING:
    from numpy.typing import NDArray

FORMAT, VERSION = "urdf-ik workspace map", 1
_ALWAYS = ("samples", "solutions", "branch_poses")
_PERHAPS = ("within", "free", "manipulability", "margin")
_TYPES = {"samples": np.float64, "branch_poses": np.uint16, "manipulability": np.float32, "margin": np.float32}


def save(found: WorkspaceMap, path: str | os.PathLike[str]) -> None:
    """Write a map; the file is there whole or not at all.

    Raises:
        WorkspaceError: the file cannot be written.
    """
    header = {
        "format": FORMAT,
        "version": VERSION,
        **asdict(found.about),
        "grid": {"lower": found.grid.lower.tolist(), "voxel": found.grid.voxel, "shape": list(found.grid.shape)},
    }
    arrays = {name: getattr(found, name) for name in _ALWAYS + _PERHAPS if getattr(found, name) is not None}
    target = Path(path)
    unfinished = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        with unfinished.open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, header=np.array(json.dumps(header)), **arrays)
        unfinished.replace(target)
    except OSError as error:
        raise WorkspaceError(f"cannot write {target}: {error.strerror}") from None
    finally:
        unfinished.unlink(missing_ok=True)


def read(path: str | os.PathLike[str]) -> WorkspaceMap:
    """Read a map that ``save`` wrote.

    Raises:
        WorkspaceError: the file cannot be read, or is no such map; the message says why.
    """
    try:
        with Path(path).open("rb") as raw, np.lib.npyio.NpzFile(raw, allow_pickle=False) as file:
            if "header" not in file.files:
                raise WorkspaceError(f"{path} is no workspace map: it has no header")
            header = json.loads(str(file["header"][()]))
            if not isinstance(header, dict) or header.get("format") != FORMAT:
                raise WorkspaceError(f"{path} is no workspace map: its header is of another format")
            if header.get("version") != VERSION:
                raise WorkspaceError(f"{path} is of version {header.get('version')}; this package reads {VERSION}")
            arrays = {name: file[name] for name in _ALWAYS + _PERHAPS if name in file.files}
        return _built(header, arrays)
    except OSError as error:
        raise WorkspaceError(f"cannot read {path}: {error.strerror or error}") from None
    except (KeyError, TypeError, ValueError, EOFError, zipfile.BadZipFile) as error:
        if isinstance(error, WorkspaceError):
            raise
        raise WorkspaceError(f"{path} is no workspace map, or a damaged one: {error}") from None


def _built(header: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> WorkspaceMap:
    grid = header["grid"]
    rows, columns, layers = (int(count) for count in grid["shape"])
    voxels = Grid(np.array(grid["lower"], dtype=np.float64), float(grid["voxel"]), (rows, columns, layers))
    fields = {name: header[name] for name in About.__dataclass_fields__}
    for name in ("joints", "branches"):
        fields[name] = tuple(fields[name])
    fields["limits"] = tuple((lower, upper) for lower, upper in fields["limits"])
    for name in _ALWAYS:
        if name not in arrays:
            raise ValueError(f"the array {name!r} is missing")
    if fields["counted"] != "solutions" and fields["counted"] not in arrays:
        raise ValueError(f"the array {fields['counted']!r} is missing")
    for name, array in arrays.items():
        last = len(fields["branches"]) if name == "branch_poses" else len(arrays["samples"])
        shape = array.shape if name == "samples" else (*voxels.shape, last)
        kind = _TYPES.get(name, np.uint8)
        if array.shape != shape or array.dtype != kind:
            raise ValueError(
                f"{name} is of shape {array.shape} and type {array.dtype}, not {shape} and {kind.__name__}"
            )
        array.setflags(write=False)
    return WorkspaceMap(About(**fields), voxels, **arrays)
