"""Files of workspace maps: a compressed ``.npz`` without pickle, with a header in JSON.

The array ``header`` is text: format, version, the fields of ``About`` and the grid. The other arrays have the names of
the attributes of ``WorkspaceMap``; the file omits an array that was not computed.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from urdf_ik.errors import ArgumentError, printable
from urdf_ik.support import files, inputs

MAX_BYTES = 2**30
"""Default of the greatest unpacked size of a map [bytes]."""
FORMAT, VERSION = "urdf-ik workspace map", 2

_Map = TypeVar("_Map")


def write(path: str | os.PathLike[str], header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write a header and arrays; the file is there whole or not at all.

    Raises:
        ArgumentError: the file cannot be written.
    """
    text = json.dumps({"format": FORMAT, "version": VERSION, **header})
    held: dict[str, Any] = {"header": np.array(text), **arrays}
    files.write(path, lambda file: np.savez_compressed(file, allow_pickle=False, **held))


def read(
    path: str | os.PathLike[str], build: Callable[[dict[str, Any], dict[str, NDArray[Any]]], _Map], most: int
) -> _Map:
    """What ``build`` makes of the header and the arrays of a file that :func:`write` wrote.

    Args:
        path: the file.
        build: makes a map of its header and arrays.
        most: bytes that the file may unpack to.

    Raises:
        ArgumentError: the file cannot be read, or is no such map; the message says why.
    """
    where = inputs.path(path, "path")
    name = files.name_of(where)
    try:
        with where.open("rb") as raw, np.lib.npyio.NpzFile(raw, allow_pickle=False) as file:
            _require_room(where, file, most)
            if "header" not in file.files:
                raise ArgumentError(f"{name} is no workspace map: it has no header")
            header = json.loads(str(file["header"][()]))
            if not isinstance(header, dict) or header.get("format") != FORMAT:
                raise ArgumentError(f"{name} is no workspace map: its header is of another format")
            if header.get("version") != VERSION:
                raise ArgumentError(f"{name} is of version {header.get('version')}; this package reads {VERSION}")
            arrays = {name: file[name] for name in file.files if name != "header"}
        return build(header, arrays)
    except OSError as error:
        raise ArgumentError(f"cannot read {name}: {error.strerror or error}") from None
    except ArgumentError:
        raise
    except Exception as error:  # zip, zlib, NumPy and JSON each have their own ways to say that bytes are damaged
        reason = printable(error) or type(error).__name__
        raise ArgumentError(f"{files.name_of(path)} is no workspace map, or a damaged one: {reason}") from None


def _require_room(path: Path, file: Any, most: int) -> None:
    """Refuse a file whose arrays need more memory than there is: they may be packed to a thousandth."""
    size = sum(part.file_size for part in file.zip.infolist())
    if size > most:
        raise ArgumentError(
            f"{files.name_of(path)} unpacks to {size / 2**20:.4g} MiB, and at most {most / 2**20:.4g} MiB are read; "
            "most=... of urdf_ik.maps.workspaces.read takes more, in bytes"
        )
