"""Arrays that are kept in the user's cache folder, by the content that they were computed from."""

import contextlib
import hashlib
import os
import zipfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from urdf_ik.errors import UrdfIkError
from urdf_ik.support import files


def folder() -> Path:
    """The folder: ``urdf-ik`` in XDG_CACHE_HOME, in LOCALAPPDATA on Windows, or in ``~/.cache``."""
    parent = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    return (Path(parent) if parent else Path("~/.cache").expanduser()) / "urdf-ik"


def arrays(
    kind: str, content: Sequence[bytes], compute: Callable[[], Mapping[str, NDArray[np.generic]]]
) -> Mapping[str, NDArray[np.generic]]:
    """The arrays that ``compute`` makes from some content; from the cache where it has them.

    Args:
        kind: what they are, with a version: a change of ``compute`` needs another.
        content: all that ``compute`` depends on.
        compute: makes them.
    """
    digest = hashlib.blake2b(digest_size=20)
    for part in content:
        digest.update(len(part).to_bytes(8, "little") + part)
    file = folder() / f"{kind}-{digest.hexdigest()}.npz"
    with contextlib.suppress(OSError, ValueError, zipfile.BadZipFile), np.load(file) as kept:
        return dict(kept)
    computed = compute()
    with contextlib.suppress(OSError, UrdfIkError):  # a home that cannot be written, a full disk
        file.parent.mkdir(parents=True, exist_ok=True)
        files.write(file, lambda target: np.savez(target, **computed))  # type: ignore[arg-type]
    return computed
